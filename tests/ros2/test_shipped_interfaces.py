"""The interfaces that ship with rtgen, compared with all that distributions of ROS 2 install."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from ros2_peers import DISTRIBUTIONS, installation

from rtgen.compiler.kit.resources import ros_file, ros_interfaces

pytestmark = [pytest.mark.peer]

SUFFIXES = (".msg", ".srv", ".action")
FOR_TESTS = "test_msgs/"


@pytest.fixture(scope="module", params=DISTRIBUTIONS)
def share(request: pytest.FixtureRequest) -> Path:
    return installation(request.param).share


def installed(share: Path) -> set[str]:
    """Return the names of all interface files: `std_msgs/msg/String.msg`."""
    names = (p.relative_to(share).as_posix() for p in share.glob("*/*/*"))
    return {n for n in names if n.endswith(SUFFIXES) and not n.startswith(FOR_TESTS)}


def declarations(file: Path) -> list[list[str]]:
    """Return constants and fields of each message of a file, without comments.

    Constants come first: their place among the fields has no meaning. Messages of the same package
    are without its name.
    """
    package = f"{file.parents[1].name}/"
    parts: list[list[str]] = [[]]
    for line in file.read_text("utf-8").splitlines():
        text = " ".join(re.sub(r"\s*#.*", "", line).split())
        text = text.removeprefix(package)
        if text == "---":
            parts.append([])
        elif text:
            parts[-1].append(re.sub(r"(?<!<) ?= ?", "=", text))
    return [sorted(part, key=lambda text: not is_constant(text)) for part in parts]


def is_constant(text: str) -> bool:
    return re.match(r"\S+ [A-Z0-9_]+=", text) is not None


def test_all_are_there(share: Path) -> None:
    assert installed(share)
    assert not installed(share) - {*ros_interfaces()}


def test_each_declares_the_same(share: Path) -> None:
    differ = [
        name
        for name in sorted(installed(share))
        if declarations(share / name) != declarations(ros_file(name))
    ]
    assert not differ
