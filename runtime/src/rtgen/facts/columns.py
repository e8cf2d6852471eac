"""The columns that a text takes on a terminal (Unicode Standard Annex #11), and tables of texts."""

from __future__ import annotations

import re
import sys
from collections.abc import Container, Sequence
from functools import cache
from itertools import zip_longest
from unicodedata import category, east_asian_width

from rtgen.facts.substitutes import registered

_NO_COLUMN = ("Mn", "Me", "Cf")
_WIDE = "WF"
_CLOSING = r",.:;?!)\]、。\uff0c\uff0e・\uff1a\uff1b\uff1f\uff01\uff09」』】〉》ーっゃゅょッャュョ"
_LEGACY = frozenset(
    {"cp932", "shift_jis", "shift_jis_2004", "shift_jisx0213", "euc_jp"}
)
"""Encodings of terminals that show characters of ambiguous width as wide ones."""


def columns(text: str, *, on_terminal: bool = True) -> int:
    """Return the number of columns of a text without tabulators and line ends.

    Characters of ambiguous width take two on terminals of older Japanese encodings.
    """
    if text.isascii():
        return len(text)
    wide = _WIDE
    encoding = _legacy() if on_terminal else None
    if encoding is not None:
        wide += "A"
        text = text.encode(encoding, registered()).decode(encoding)
    return sum(_columns_of(character, wide) for character in text)


def _columns_of(character: str, wide: str) -> int:
    if category(character) in _NO_COLUMN:
        return 0
    return 2 if east_asian_width(character) in wide else 1


@cache
def _legacy() -> str | None:
    """Return the encoding of the terminal if it is an older Japanese one."""
    encoding = getattr(sys.stderr, "encoding", None) or ""
    return encoding if encoding.lower().replace("-", "_") in _LEGACY else None


def padded(text: str, width: int) -> str:
    """Return a text with spaces after it, so that it takes `width` columns on a terminal."""
    return text + " " * (width - columns(text))


def wrapped(text: str, width: int) -> list[str]:
    """Return a paragraph as lines of at most `width` columns.

    A line ends at a space, or beside a wide character; no line begins with a closing mark.
    """
    lines = []
    line = ""
    for piece in _pieces().findall(text):
        if line and columns(line + piece.rstrip()) > width:
            lines.append(line.rstrip())
            line = ""
        line += piece if line else piece.lstrip()
    return [*lines, line.rstrip()] if line.strip() else lines


@cache
def _pieces() -> re.Pattern[str]:
    """Match what stays on one line: a word, or a wide character, with closing marks after it.

    Compiled at first use: it takes longer than the import of this module.
    """
    return re.compile(
        rf" *(?:[^\x00-\u2fff]|[^ \u3000-\U0010ffff]+)[{_CLOSING}]*", re.DOTALL
    )


def table(
    rows: Sequence[Sequence[str]],
    *,
    right: Container[int] = (),
    on_terminal: bool = True,
) -> list[str]:
    """Return the lines of a table; its columns in `right` are aligned right, the others left."""
    widths = [
        max(columns(cell, on_terminal=on_terminal) for cell in column)
        for column in zip_longest(*rows, fillvalue="")
    ]
    lines = []
    for row in rows:
        cells = []
        for number, (cell, width) in enumerate(zip(row, widths, strict=False)):
            space = " " * (width - columns(cell, on_terminal=on_terminal))
            cells.append(space + cell if number in right else cell + space)
        lines.append("  ".join(cells).rstrip())
    return lines
