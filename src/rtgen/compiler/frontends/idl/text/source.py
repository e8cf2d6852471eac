"""Reads definition files: bytes to text, lines, comments; each file once per run."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.frontends import Dependency
from rtgen.compiler.frontends.idl.rules import lexical
from rtgen.compiler.frontends.kit import characters, library
from rtgen.compiler.frontends.kit.characters import TOKENS, Joined
from rtgen.compiler.frontends.kit.doc_comments import Comment
from rtgen.compiler.frontends.kit.library import MAX_BYTES, VirtualFile, absolute_path
from rtgen.compiler.frontends.kit.lines import LineTable
from rtgen.facts.encodings import digest

_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")
_READERS = "omniidl and gcc"
"""Programs that read the octets of IDL."""


class Source:
    """A file that was read.

    `text` is its content; `code` is the text with continuation lines joined and comments blanked.
    Later stages read `code`, and `span` maps offsets back to `text`.
    """

    def __init__(
        self, name: str, key: str, path: Path, data: bytes, encoding: str = "auto"
    ) -> None:
        self.name = name
        self.key = key
        self.path = path
        self.sha256 = digest(data)
        self._characters = characters.read(data, name, encoding)
        self._characters.check_line_ends()
        self.text = self._characters.text
        self.problems: list[Diagnostic] = self._characters.problems
        self.unfinished = False
        self.comments: list[Comment] = []
        self._joined = Joined(self._acceptable_text())
        self._characters.check(self._joined, _READERS, literals=True)
        self.code = self._blank_comments(self._joined.text)

    def _acceptable_text(self) -> str:
        match = _CONTROL.search(self.text)
        if match is None:
            return self.text
        if "\0" in self.text:
            message = "this is not a text file: it holds a NUL byte"
            place = self.text.index("\0")
            span = self.text_span(place, place + 1)
            hint = "save it as UTF-8 if an editor shows it as text"
            self.problems.append(lexical.BINARY.at(span, message, hint=hint))
            return ""
        message = f"the control character U+{ord(match[0]):04X} is not allowed here"
        span = self.text_span(match.start(), match.end())
        self.problems.append(lexical.BAD_CHARACTER.at(span, message))
        return _CONTROL.sub(" ", self.text)

    def _blank_comments(self, text: str) -> str:
        parts: list[str] = []
        start = 0
        for match in TOKENS.finditer(text):
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
        return self._joined.original(offset)

    def _range(self, start: int, end: int) -> tuple[int, int]:
        """Return the range in `text` of a range in `code` that is not empty."""
        return self.text_offset(start), self.text_offset(end - 1) + 1

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column, both 1-based, of an offset in `text`."""
        return self._lines.position(offset)

    def text_span(self, start: int, end: int) -> Span:
        """Return the span of [start, end) of `text`."""
        return self._lines.span(start, end)

    def span(self, start: int, end: int) -> Span:
        """Return the span of [start, end) of `code`."""
        if not self._joined.starts:
            return self._lines.span(start, max(start, end))
        if end > start:
            return self.text_span(*self._range(start, end))
        place = self.text_offset(start)
        return self.text_span(place, place)


def _source(
    name: str, key: str, path: Path, data: bytes | None, encoding: str
) -> Source:
    source = Source(name, key, path, data or b"", encoding)
    if data is None:
        message = f"the file is larger than {MAX_BYTES:,} bytes"
        source.problems = [lexical.FILE_TOO_LARGE.at(source.text_span(0, 0), message)]
    return source


class Printed(msgspec.Struct, frozen=True):
    """The IDL of an interface of ROS 2, by its name in `#include`.

    `findings` are those in the files that it depends on.
    """

    name: str
    text: str
    dependencies: tuple[Dependency, ...]
    findings: tuple[Diagnostic, ...] = ()


Interfaces: TypeAlias = Callable[[Path, bool], Printed | None]
"""Function that returns the IDL of the file at a path, if that is an interface of ROS 2.

Its second argument: the path is in an include folder.
"""


class Library(library.Library[Source]):
    """The IDL files of a run."""

    def __init__(
        self,
        root: Path,
        include: Sequence[Path],
        main: Mapping[str, str] | None = None,
        virtual: Mapping[str, VirtualFile | Path] | None = None,
        encoding: str = "auto",
        interfaces: Interfaces | None = None,
    ) -> None:
        """See `library.Library`; `encoding` is that of files that do not tell theirs.

        `interfaces` returns the IDL of a file that ROS 2 has generated.
        """
        make = partial(_source, encoding=encoding)
        super().__init__(make, root, include, main, virtual)
        self.encoding = encoding
        self._interfaces = interfaces
        self._printed: dict[str, tuple[Source, Printed] | None] = {}

    def interface(
        self, path: str, folder: Path | None
    ) -> tuple[Source, Printed] | None:
        """Return the IDL of an interface of ROS 2, in place of the file at a path."""
        absolute = absolute_path(path)
        if self._interfaces is None or absolute in self._main:
            return None
        if absolute not in self._printed:
            shown = Path(self._displayed(absolute))
            printed = self._interfaces(shown, folder is not None)
            printed_source = None
            if printed is not None:
                place = self._root / printed.name
                text = printed.text.encode()
                printed_source = (
                    self._make(printed.name, printed.name, place, text),
                    printed,
                )
                self.note(printed.dependencies)
            self._printed[absolute] = printed_source
        return self._printed[absolute]
