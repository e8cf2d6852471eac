"""Timed commands of an operator as text: target lists of the common interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from refnav.geometry import Pose

SYNTAX = "'AT X Y THETA; X Y THETA; ...' or 'AT clear' (s, m, m, rad)"


class ScriptError(ValueError):
    """An invalid script; the message has the line and the reason."""


@dataclass(frozen=True, slots=True)
class TargetList:
    """Targets given `at` seconds after the start; an empty list clears the current one."""

    at: float
    targets: tuple[Pose, ...]


def parse(text: str, name: str) -> tuple[TargetList, ...]:
    """Parse the target lists in a file's text, in order; `name` is used in errors.

    Raises ScriptError.
    """
    lists: list[TargetList] = []
    for number, line in enumerate(text.splitlines(), start=1):
        content = line.partition("#")[0].strip()
        if not content:
            continue
        at, _, rest = content.partition(" ")
        try:
            found = TargetList(_number(at), _targets(rest.strip()))
        except ValueError:
            message = f"{name}:{number}: {content!r} is not of the form {SYNTAX}"
            raise ScriptError(message) from None
        if found.at < 0.0 or (lists and found.at < lists[-1].at):
            raise ScriptError(f"{name}:{number}: {at} s is before what went before")
        lists.append(found)
    if not lists:
        raise ScriptError(f"{name}: holds no line {SYNTAX}")
    return tuple(lists)


def _targets(text: str) -> tuple[Pose, ...]:
    if text == "clear":
        return ()
    return tuple(Pose(*map(_number, part.split())) for part in _poses(text))


def _poses(text: str) -> list[str]:
    parts = text.split(";")
    if any(len(part.split()) != 3 for part in parts):
        raise ValueError(text)
    return parts


def _number(text: str) -> float:
    number = float(text)
    if not isfinite(number):
        raise ValueError(text)
    return number
