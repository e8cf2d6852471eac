"""Quoting for Markdown (CommonMark and Python-Markdown): texts are inserted without markup.

Characters that could be markup become character references, which both leave unchanged in
paragraphs, tables and headings.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from rtgen.compiler.backends.kit.quoting.code import Code
from rtgen.compiler.backends.kit.quoting.python import comment_text

_MARKUP = re.compile(r"[\\`*_{}\[\]<>#|~^=$@&\"'!+()]|://|www\.")
_FIRST = re.compile(r"\A(?:[^A-Za-z0-9&]|\d(?=\d*[.)]))")


class Markdown(Code):
    """Markdown source text of one line."""

    __slots__ = ()


def _reference(match: re.Match[str]) -> str:
    return "".join(f"&#{ord(c)};" for c in match[0])


def text(value: object) -> Markdown:
    """Return the text on one line, for a paragraph, a table cell or a heading."""
    if isinstance(value, Markdown):
        return value
    line = _MARKUP.sub(_reference, comment_text(str(value)))
    return Markdown(_FIRST.sub(_reference, line))


def code(value: object) -> Markdown:
    """Return the text on one line in a typewriter face; empty for an empty text."""
    inner = text(value)
    return Markdown(f"<code>{inner}</code>" if inner else "")


def link(target: str, label: object) -> Markdown:
    """Return a link to a page of the same site, whose path is ASCII."""
    return Markdown(f"[{text(label)}]({target})")


def paragraphs(value: str) -> Markdown:
    """Return a description: its paragraphs, each on one line."""
    parts = re.split(r"\n[ \t]*\n", value.strip())
    return Markdown("\n\n".join(line for part in parts if (line := text(part))))


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> Markdown:
    """Return a table; cells that are not Markdown are quoted, empty columns omitted."""
    cells = [[text(cell) for cell in row] for row in rows]
    if not cells:
        return Markdown("")
    columns = [i for i in range(len(head)) if any(row[i] for row in cells)]
    lines: list[list[str]] = [
        [text(head[i]) for i in columns],
        ["---"] * len(columns),
        *([row[i] or " " for i in columns] for row in cells),
    ]
    return Markdown("\n".join(f"| {' | '.join(line)} |" for line in lines))
