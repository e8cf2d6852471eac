"""Movements of a game pad's sticks as text: values held for some time."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from math import isfinite

MAX_HOLD = 86_400.0
"""Maximum time for which a value is held [s]."""


class ScriptError(ValueError):
    """An invalid script; the message has the line and the reason."""


class Script:
    """Values over time."""

    def __init__(
        self, ends: Sequence[float], values: Sequence[tuple[float, ...]]
    ) -> None:
        self._ends = ends
        self._values = values

    @property
    def end(self) -> float:
        """The duration of the script [s]."""
        return self._ends[-1]

    def at(self, seconds: float) -> tuple[float, ...] | None:
        """Return the values `seconds` after the start; None after the end."""
        place = bisect_right(self._ends, seconds)
        return self._values[place] if place < len(self._values) else None


def parse(text: str, name: str, columns: int, most: float = 1.0) -> Script:
    """Parse the script in a file's text; `name` is used in errors. Raises ScriptError.

    A line is `SECONDS VALUE...` with a fixed number of values, each within [-most, most]; `#`
    starts a comment.
    """
    ends: list[float] = []
    values: list[tuple[float, ...]] = []
    # Decimal seconds are added as milliseconds, without rounding errors.
    end = 0
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            seconds, *held = map(float, words)
        except ValueError:
            raise ScriptError(
                f"{name}:{number}: not numbers: {line.strip()!r}"
            ) from None
        if len(held) != columns:
            raise ScriptError(
                f"{name}:{number}: SECONDS and {columns} values expected,"
                f" {len(words)} numbers found"
            )
        if not 0.0 < seconds <= MAX_HOLD:
            raise ScriptError(f"{name}:{number}: {words[0]} is not a duration [s]")
        if not all(isfinite(value) and abs(value) <= most for value in held):
            raise ScriptError(f"{name}:{number}: values go from {-most:g} to {most:g}")
        end += round(seconds * 1000.0)
        ends.append(end / 1000.0)
        values.append(tuple(held))
    if not ends:
        raise ScriptError(f"{name}: holds no line of SECONDS and {columns} values")
    return Script(ends, values)
