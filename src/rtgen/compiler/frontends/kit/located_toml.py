"""TOML with places: the content of a file, and the span of each key."""

from __future__ import annotations

import re
from typing import TypeAlias

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.kit.toml_text import parse

Path: TypeAlias = tuple[str | int, ...]
"""Keys from the root; in an array of tables, the number of the entry."""

_HEADER = re.compile(r"\s*(\[\[?)\s*(.*?)\s*\]")
_KEY = re.compile(
    r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*="""
)
_NAME = re.compile(r"""[\w-]+|"[^"]*"|'[^']*'""")


class Toml:
    """A TOML text; `file` is its displayed path. Raises TomlError."""

    def __init__(self, text: str, file: str) -> None:
        self.file = file
        self.content = parse(text, file)
        self._places: dict[Path, Span] = {}
        self._find(text)

    def span(self, path: Path) -> Span:
        """Return the span of a key, or of the table that should contain it."""
        while path and path not in self._places:
            path = path[:-1]
        return self._places.get(path, self._span(1, 1, 1))

    def _find(self, text: str) -> None:
        table: Path = ()
        counts: dict[Path, int] = {}
        for number, line in enumerate(text.split("\n"), 1):
            header = _HEADER.match(line)
            if header is not None:
                table = _names(header[2])
                if header[1] == "[[":
                    counts[table] = counts.get(table, -1) + 1
                    table = (*table, counts[table])
                span = self._span(number, header.start(2) + 1, len(header[2]))
                self._keep(table, span)
            elif (key := _KEY.match(line)) is not None:
                span = self._span(number, key.start(1) + 1, len(key[1]))
                self._keep((*table, *_names(key[1])), span)

    def _keep(self, path: Path, span: Span) -> None:
        for length in range(1, len(path) + 1):
            self._places.setdefault(path[:length], span)

    def _span(self, line: int, column: int, length: int) -> Span:
        return Span(self.file, line, column, line, column + max(length, 1))


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip("\"'") for name in _NAME.findall(text))
