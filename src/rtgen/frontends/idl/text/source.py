"""Reads definition files: bytes to text, lines, comments; each file once per run."""

from __future__ import annotations

import codecs
import re
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from functools import cached_property
from hashlib import sha256
from pathlib import Path

from rtgen.diagnostics import Diagnostic, Span
from rtgen.frontends.idl.rules import lexical
from rtgen.frontends.kit import library
from rtgen.frontends.kit.doc_comments import Comment
from rtgen.frontends.kit.library import MAX_BYTES, VirtualFile
from rtgen.frontends.kit.lines import LineTable

_FALLBACK = "rtgen-latin-1"
_SPLICE = re.compile(r"(?<![\x80-\xff])\\\r?\n")
_COMMENT_OR_TEXT = re.compile(
    r"//[^\n]*|/\*(?:.*?\*/|.*)"
    r'|"(?:\\[^\n]|[^"\\\n])*"|"(?:\\.|[^"\\;{}#])*"|"[^\n]*'
    r"|'(?:\\[^\n]|[^'\\\n]){0,12}'",
    re.DOTALL,
)
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


def _as_latin_1(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode("latin-1"), error.end


codecs.register_error(_FALLBACK, _as_latin_1)


def decode(data: bytes) -> str:
    """Decode UTF-8 with or without a byte-order mark; other bytes are read as Latin-1."""
    return data.removeprefix(codecs.BOM_UTF8).decode("utf-8", errors=_FALLBACK)


class Source:
    """A file that was read.

    `text` is its content; `code` is the text with continuation lines joined and comments blanked.
    Later stages read `code`, and `span` maps offsets back to `text`.
    """

    def __init__(self, name: str, key: str, path: Path, data: bytes) -> None:
        self.name = name
        self.key = key
        self.path = path
        self.sha256 = sha256(data).hexdigest()
        self.text = decode(data)
        self.problems: list[Diagnostic] = []
        self.unfinished = False
        self.comments: list[Comment] = []
        self._splices: list[int] = []
        self._removed: list[int] = [0]
        self.code = self._blank_comments(self._join_lines(self._acceptable_text()))

    def _acceptable_text(self) -> str:
        found = _CONTROL.search(self.text)
        if found is None:
            return self.text
        if "\0" in self.text:
            message = "this is not a text file: it holds a NUL byte"
            place = self.text.index("\0")
            span = self.text_span(place, place + 1)
            hint = "save it as UTF-8 if an editor shows it as text"
            self.problems.append(lexical.BINARY.at(span, message, hint=hint))
            return ""
        message = f"the control character U+{ord(found[0]):04X} is not allowed here"
        span = self.text_span(found.start(), found.end())
        self.problems.append(lexical.BAD_CHARACTER.at(span, message))
        return _CONTROL.sub(" ", self.text)

    def _join_lines(self, text: str) -> str:
        if "\\" not in text:
            return text
        parts = []
        start = length = 0
        for match in _SPLICE.finditer(text):
            parts.append(text[start : match.start()])
            length += match.start() - start
            start = match.end()
            self._splices.append(length)
            self._removed.append(start - length)
        parts.append(text[start:])
        return "".join(parts)

    def _blank_comments(self, text: str) -> str:
        parts: list[str] = []
        start = 0
        for match in _COMMENT_OR_TEXT.finditer(text):
            comment = match[0]
            if comment[0] != "/":
                continue
            if comment[1] == "*" and (len(comment) < 4 or not comment.endswith("*/")):
                self.unfinished = True
                self.problems.append(
                    lexical.UNCLOSED_COMMENT.at(
                        self.span(match.start(), match.start() + 2),
                        "this comment is never closed",
                        hint="comments do not nest; close it with */",
                    )
                )
            self.comments.append(Comment(match.start(), match.end(), comment))
            parts += text[start : match.start()], " " * len(comment)
            start = match.end()
        parts.append(text[start:])
        return "".join(parts)

    @cached_property
    def folder(self) -> Path:
        """The folder of the file."""
        return self.path.parent

    @cached_property
    def real(self) -> str:
        """The path without links, which identifies the file."""
        return str(self.path.resolve())

    @cached_property
    def _lines(self) -> LineTable:
        return LineTable(self.name, self.text)

    def text_offset(self, offset: int) -> int:
        """Return the offset in `text` of an offset in `code`."""
        return offset + self._removed[bisect_right(self._splices, offset)]

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column, both 1-based, of an offset in `text`."""
        return self._lines.position(offset)

    def text_span(self, start: int, end: int) -> Span:
        """Return the span of [start, end) of `text`."""
        return self._lines.span(start, end)

    def span(self, start: int, end: int) -> Span:
        """Return the span of [start, end) of `code`."""
        if not self._splices:
            return self._lines.span(start, max(start, end))
        if end > start:
            return self.text_span(
                self.text_offset(start), self.text_offset(end - 1) + 1
            )
        place = self.text_offset(start)
        return self.text_span(place, place)


def _source(name: str, key: str, path: Path, data: bytes | None) -> Source:
    source = Source(name, key, path, data or b"")
    if data is None:
        message = f"the file is larger than {MAX_BYTES:,} bytes"
        source.problems = [lexical.FILE_TOO_LARGE.at(source.text_span(0, 0), message)]
    return source


class Library(library.Library[Source]):
    """The IDL files of a run."""

    def __init__(
        self,
        root: Path,
        include: Sequence[Path],
        main: Mapping[str, str] | None = None,
        virtual: Mapping[str, VirtualFile | Path] | None = None,
    ) -> None:
        """See `library.Library`."""
        super().__init__(_source, root, include, main, virtual)
