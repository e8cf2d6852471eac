"""Maps as text: lines that begin with a letter, then numbers; `#` begins a comment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite

LONGEST = 100_000
"""No map has more lines."""


class MapError(ValueError):
    """A map that is not understood; the message has the line and says why."""

    def __init__(self, name: str, number: int, why: str) -> None:
        super().__init__(f"{name}:{number}: {why}")


def lines(
    text: str, name: str, columns: Mapping[str, int]
) -> Iterator[tuple[int, str, tuple[float, ...]]]:
    """Number of the line, letter and numbers of each line that is not empty.

    `columns` tells how many finite numbers follow each letter; `name` is told in errors.
    Raises MapError.
    """
    for number, line in enumerate(text.splitlines(), start=1):
        if number > LONGEST:
            raise MapError(name, number, f"more than {LONGEST} lines")
        words = line.partition("#")[0].split()
        if not words:
            continue
        letter, *rest = words
        if letter not in columns:
            known = ", ".join(sorted(columns))
            raise MapError(name, number, f"{letter!r} begins no line; known: {known}")
        try:
            values = tuple(map(float, rest))
        except ValueError:
            raise MapError(name, number, f"not numbers: {line.strip()!r}") from None
        if len(values) != columns[letter] or not all(map(isfinite, values)):
            raise MapError(
                name, number, f"{letter} and {columns[letter]} finite numbers expected"
            )
        yield number, letter, values
