"""Parses maps as text: lines that begin with a letter, then numbers; `#` starts a comment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path

MAX_CHARACTERS = 1 << 20
"""Maximum number of characters of a map."""
MAX_LINES = 100_000
"""Maximum number of lines of a map."""


class MapError(ValueError):
    """An unreadable or invalid map; the message has the line and the reason."""


def text_of(folder: Path, name: str) -> str:
    """Return the text of a map; file names start at `folder`. Raises MapError."""
    try:
        with (folder / name).open(encoding="utf-8") as stream:
            text = stream.read(MAX_CHARACTERS + 1)
    except OSError as error:
        raise MapError(f"{name}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise MapError(f"{name}: {error}") from error
    if len(text) > MAX_CHARACTERS:
        raise MapError(f"{name}: more than {MAX_CHARACTERS} characters")
    return text


def map_error(name: str, number: int, why: str) -> MapError:
    """Return an error in a line of a map."""
    return MapError(f"{name}:{number}: {why}")


def lines(
    text: str, name: str, columns: Mapping[str, int]
) -> Iterator[tuple[int, str, tuple[float, ...]]]:
    """Yield number of the line, letter and numbers of each non-empty line.

    `columns` is the count of finite numbers after each letter; `name` is used in errors. Raises
    MapError.
    """
    for number, line in enumerate(text.splitlines(), start=1):
        if number > MAX_LINES:
            raise map_error(name, number, f"more than {MAX_LINES} lines")
        words = line.partition("#")[0].split()
        if not words:
            continue
        letter, *rest = words
        if letter not in columns:
            known = ", ".join(sorted(columns))
            raise map_error(name, number, f"{letter!r} begins no line; known: {known}")
        try:
            values = tuple(map(float, rest))
        except ValueError:
            raise map_error(name, number, f"not numbers: {line.strip()!r}") from None
        if len(values) != columns[letter] or not all(map(isfinite, values)):
            raise map_error(
                name, number, f"{letter} and {columns[letter]} finite numbers expected"
            )
        yield number, letter, values
