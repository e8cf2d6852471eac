"""Maps as text: lines that begin with a letter, then numbers; `#` begins a comment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path

LARGEST = 1 << 20
"""No map has more characters."""
LONGEST = 100_000
"""No map has more lines."""


class MapError(ValueError):
    """A map that cannot be read or is not understood; the message has the line and says why."""


def text_of(folder: Path, name: str) -> str:
    """Return the text of a map; file names start at `folder`. Raises MapError."""
    try:
        with (folder / name).open(encoding="utf-8") as stream:
            text = stream.read(LARGEST + 1)
    except OSError as error:
        raise MapError(f"{name}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise MapError(f"{name}: {error}") from error
    if len(text) > LARGEST:
        raise MapError(f"{name}: more than {LARGEST} characters")
    return text


def mistake(name: str, number: int, why: str) -> MapError:
    """Return the error in a line."""
    return MapError(f"{name}:{number}: {why}")


def lines(
    text: str, name: str, columns: Mapping[str, int]
) -> Iterator[tuple[int, str, tuple[float, ...]]]:
    """Number of the line, letter and numbers of each non-empty line.

    `columns` is the count of finite numbers after each letter; `name` is used in errors. Raises
    MapError.
    """
    for number, line in enumerate(text.splitlines(), start=1):
        if number > LONGEST:
            raise mistake(name, number, f"more than {LONGEST} lines")
        words = line.partition("#")[0].split()
        if not words:
            continue
        letter, *rest = words
        if letter not in columns:
            known = ", ".join(sorted(columns))
            raise mistake(name, number, f"{letter!r} begins no line; known: {known}")
        try:
            values = tuple(map(float, rest))
        except ValueError:
            raise mistake(name, number, f"not numbers: {line.strip()!r}") from None
        if len(values) != columns[letter] or not all(map(isfinite, values)):
            raise mistake(
                name, number, f"{letter} and {columns[letter]} finite numbers expected"
            )
        yield number, letter, values
