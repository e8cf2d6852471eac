"""Commands of an operator as text: a goal, or a path of two or more waypoints."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from refnav.geometry import Pose

SYNTAX = "'goal X Y TH' or 'path X Y TH; X Y TH; ...' (m, m, rad)"


class CommandError(ValueError):
    """An invalid command; the message says why."""


@dataclass(frozen=True, slots=True)
class Command:
    """One goal, or the waypoints of one path, in order."""

    points: tuple[Pose, ...]

    @property
    def goal(self) -> Pose:
        """The final pose of the base."""
        return self.points[-1]


def parse(line: str) -> Command | None:
    """Return the command in one line of text; None for an empty line or a comment.

    Raises CommandError.
    """
    words = line.partition("#")[0].split(maxsplit=1)
    if not words:
        return None
    verb, rest = words[0], words[1] if len(words) > 1 else ""
    if verb == "goal":
        return Command((_pose(rest),))
    if verb == "path":
        points = tuple(_pose(part) for part in rest.split(";"))
        if len(points) < 2:
            raise CommandError("a path needs two or more waypoints")
        return Command(points)
    raise CommandError(f"{verb!r} is not a command; expected {SYNTAX}")


def parse_all(text: str, name: str) -> tuple[Command, ...]:
    """Parse the commands in a file's text, at least one; `name` is used in errors.

    Raises CommandError with the file and the line.
    """
    commands = []
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            command = parse(line)
        except CommandError as error:
            raise CommandError(f"{name}:{number}: {error}") from None
        if command is not None:
            commands.append(command)
    if not commands:
        raise CommandError(f"{name}: holds no command; expected lines of {SYNTAX}")
    return tuple(commands)


def _pose(text: str) -> Pose:
    numbers = text.split()
    try:
        x, y, theta = map(float, numbers)
    except ValueError:
        raise CommandError(
            f"{text.strip()!r} is not a pose; expected three numbers"
        ) from None
    if not (isfinite(x) and isfinite(y) and isfinite(theta)):
        raise CommandError(
            f"{text.strip()!r} is not a pose; the numbers must be finite"
        )
    return Pose(x, y, theta)
