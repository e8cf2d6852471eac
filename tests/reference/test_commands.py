"""Goals and paths as text."""

from __future__ import annotations

import pytest

from refnav.commands import Command, CommandError, parse, parse_all
from refnav.geometry import Pose


def test_a_goal() -> None:
    assert parse("goal 3.4 7.7 -1.57 # the far corner") == Command(
        (Pose(3.4, 7.7, -1.57),)
    )


def test_a_path_ends_at_its_last_waypoint() -> None:
    command = parse("  path 2 0 0; 2 2 0;0 2 3.14")
    assert command == Command((Pose(2, 0, 0), Pose(2, 2, 0), Pose(0, 2, 3.14)))
    assert command.goal == Pose(0, 2, 3.14)


@pytest.mark.parametrize("line", ["", "   ", "# only a comment"])
def test_nothing(line: str) -> None:
    assert parse(line) is None


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("path 1 2 3", "two or more waypoints"),
        ("path", "three numbers"),
        ("path 1 2 3;", "three numbers"),
        ("goal 1 2", "three numbers"),
        ("goal 1 2 3 4", "three numbers"),
        ("goal 1 2 east", "'1 2 east' is not a pose"),
        ("goal 1 2 nan", "finite"),
        ("goal 1 inf 3", "finite"),
        ("gaol 1 2 3", "'gaol' is not a command"),
    ],
)
def test_what_is_not_understood(line: str, message: str) -> None:
    with pytest.raises(CommandError, match=message):
        parse(line)


def test_a_file_tells_the_line_of_an_error() -> None:
    with pytest.raises(CommandError, match=r"^tour\.txt:3: a path needs two or more"):
        parse_all("# tour\n\npath 1 2 3\n", "tour.txt")


def test_a_file_without_a_command_is_an_error() -> None:
    with pytest.raises(CommandError, match=r"tour\.txt: holds no command"):
        parse_all("# nothing yet\n", "tour.txt")


def test_the_commands_of_a_file_keep_their_order() -> None:
    commands = parse_all("goal 1 2 3\r\n\r\npath 1 2 3; 4 5 6\n", "tour.txt")
    assert [len(command.points) for command in commands] == [1, 2]
