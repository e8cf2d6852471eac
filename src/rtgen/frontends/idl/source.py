"""Reading of definition files: bytes to text, lines, comments; no file is read twice in a run."""

from __future__ import annotations

import codecs
import os
import re
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

from rtgen.diagnostics import Diagnostic, Span
from rtgen.frontends import Dependency
from rtgen.frontends.idl.rules import lexical

MAX_BYTES = 32 * 1024 * 1024

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
    """UTF-8 with or without mark; bytes that are not UTF-8 count as Latin-1, one by one."""
    return data.removeprefix(codecs.BOM_UTF8).decode("utf-8", errors=_FALLBACK)


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment with its marks, at [start, end) of a text."""

    start: int
    end: int
    text: str


class Source:
    """A file that was read.

    `text` is what it holds; `code` the same with continuation lines joined and comments blanked,
    so that every later stage reads `code`, and `span` leads back to `text`.
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
        message = f"the control character U+{ord(found[0]):04X} cannot stand here"
        span = self.text_span(found.start(), found.end())
        self.problems.append(lexical.BAD_CHARACTER.at(span, message))
        return _CONTROL.sub(" ", self.text)

    def _join_lines(self, text: str) -> str:
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
        """The folder that the file is in."""
        return self.path.parent

    @cached_property
    def real(self) -> str:
        """The path without links: the same for a file that is found in two ways."""
        return str(self.path.resolve())

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(match.end() for match in re.finditer("\n", self.text))]

    def text_offset(self, offset: int) -> int:
        """The place in `text` of a place in `code`."""
        return offset + self._removed[bisect_right(self._splices, offset)]

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column, both from 1, of a place in `text`."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def text_span(self, start: int, end: int) -> Span:
        """The span of [start, end) of `text`."""
        return Span(self.name, *self.position(start), *self.position(end))

    def span(self, start: int, end: int) -> Span:
        """The span of [start, end) of `code`."""
        if end > start:
            return self.text_span(
                self.text_offset(start), self.text_offset(end - 1) + 1
            )
        place = self.text_offset(start)
        return self.text_span(place, place)


def absolute_path(path: Path | str) -> str:
    """The path from the root, without `..`; links are kept, so a file's includes lie beside it."""
    return os.path.normpath(Path.cwd() / path)


class Library:
    """The files of a run: each is read once, and whatever was looked for is remembered."""

    def __init__(
        self, root: Path, include: Sequence[Path], main: Mapping[str, str] | None = None
    ) -> None:
        """`main` maps absolute paths of the files given to the names they are displayed by."""
        self._root = root.resolve()
        self.include = tuple(include)
        self._main = dict(main or {})
        self._working = Path.cwd()
        self._read: dict[str, Source | None] = {}
        self._dependencies: dict[str, Dependency] = {}

    @property
    def dependencies(self) -> tuple[Dependency, ...]:
        """Every path looked at, in order."""
        return tuple(self._dependencies.values())

    @property
    def sources(self) -> list[Source]:
        """Every file read, in order."""
        return [source for source in self._read.values() if source is not None]

    def open(self, path: Path | str, folder: Path | None = None) -> Source | None:
        """The file of that path, or None where there is none.

        `folder` is the include folder in which it was found. Raises OSError if there is a file
        that cannot be read.
        """
        absolute = absolute_path(path)
        if absolute in self._read:
            return self._read[absolute]
        source = None
        digest = None
        file = Path(absolute)
        if file.is_file():
            with file.open("rb") as stream:
                data = stream.read(MAX_BYTES + 1)
            too_large = len(data) > MAX_BYTES
            source = Source(
                self._displayed(absolute),
                self._key(file, folder),
                Path(path),
                b"" if too_large else data,
            )
            if too_large:
                message = f"the file is larger than {MAX_BYTES:,} bytes"
                source.problems = [
                    lexical.FILE_TOO_LARGE.at(source.text_span(0, 0), message)
                ]
            digest = source.sha256
        self._read[absolute] = source
        self._dependencies[absolute] = Dependency(file, digest)
        return source

    def displayed(self, folder: Path) -> str:
        """A folder as it is shown: relative to the working folder."""
        return self._displayed(absolute_path(folder))

    def _displayed(self, absolute: str) -> str:
        if absolute in self._main:
            return self._main[absolute]
        try:
            return Path(os.path.relpath(absolute, self._working)).as_posix()
        except ValueError:  # another drive
            return Path(absolute).as_posix()

    def _key(self, path: Path, folder: Path | None) -> str:
        real = path.resolve()
        for base in (self._root, folder.resolve() if folder else None):
            if base is not None and real.is_relative_to(base):
                return real.relative_to(base).as_posix()
        return path.name
