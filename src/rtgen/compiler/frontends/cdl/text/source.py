"""Source files of CDL: decoded text, with comments blanked and angle strings marked."""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.frontends.cdl.rules import files, lexical
from rtgen.compiler.frontends.kit import characters, library
from rtgen.compiler.frontends.kit.doc_comments import Comment, Docs
from rtgen.compiler.frontends.kit.library import MAX_BYTES
from rtgen.compiler.frontends.kit.lines import LineTable
from rtgen.facts.encodings import digest

ANGLE_MARK = "\x02"
"""Replaces, in `code`, the `<` that starts an angle string."""

_TOKENS = re.compile(
    r"//[^\n]*|/\*(?:.*?\*/|.*)"
    r'|"(?:[^"\\\n]|\\.)*"?'
    r"|'(?:[^'\\\n]|\\[^\n])'"
    r"|<",
    re.DOTALL,
)
_ANGLE = re.compile(r"<(?:[^>\\\n]|\\[^\n])*>")
_PROGRAMS = "programs that join lines"
_READERS = "tecsgen and gcc"
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


class Source:
    """A source file.

    `text` is its content; `code` is the text, of equal length, with comments blanked and the
    start of each angle string marked. Offsets are valid for both.
    """

    def __init__(
        self,
        name: str,
        key: str,
        path: Path,
        data: bytes | None,
        encoding: str = "auto",
    ) -> None:
        self.name = name
        self.key = key
        self.path = path
        self.comments: list[Comment] = []
        self.unfinished = False
        self.sha256 = digest(data or b"")
        self._characters = characters.read(
            data or b"", name, encoding, rule=files.ENCODING
        )
        self._characters.check_line_ends()
        self.text = self._characters.text
        self.problems: list[Diagnostic] = self._characters.problems
        if data is None:
            message = f"the file is larger than {MAX_BYTES:,} bytes"
            self.problems.append(files.TOO_LARGE.at(self.span(0, 0), message))
        self.code = self._marked(self._acceptable())

    def _acceptable(self) -> str:
        """Return the text with control characters replaced by white space."""
        text = self.text
        match = _CONTROL.search(text)
        if match is None:
            return text
        if "\0" in text:
            place = text.index("\0")
            message = "this is not a text file: it holds a NUL byte"
            self.problems.append(files.BINARY.at(self.span(place, place + 1), message))
            return ""
        span = self.span(match.start(), match.end())
        message = f"the control character U+{ord(match[0]):04X} is not allowed here"
        self.problems.append(lexical.BAD_CHARACTER.at(span, message))
        return _CONTROL.sub(" ", text)

    def _marked(self, text: str) -> str:
        parts: list[str] = []
        done = position = dead = 0
        has_octets = self._characters.has_octets
        while match := _TOKENS.search(text, position):
            start, position = match.span()
            token = match[0]
            if token == "<":
                # If one `<` of a line has no `>`, no later one has.
                angle = _ANGLE.match(text, start) if start >= dead else None
                if angle is not None:
                    parts += text[done:start], ANGLE_MARK
                    done, position = start + 1, angle.end()
                elif start >= dead:
                    dead = (text.find("\n", start) + 1) or len(text)
            elif token.startswith(("//", "/*")):
                if token.startswith("/*") and (
                    len(token) < 4 or not token.endswith("*/")
                ):
                    self._unclosed(start)
                elif token[1] == "/" and has_octets:
                    self._characters.check_comment(start, position, _PROGRAMS)
                self.comments.append(Comment(start, position, token))
                parts += text[done:start], _blank(token)
                done = position
            elif has_octets:
                self._characters.check_literal(start, position, _READERS)
        parts.append(text[done:])
        return "".join(parts)

    def _unclosed(self, start: int) -> None:
        self.unfinished = True
        self.problems.append(
            lexical.UNCLOSED_COMMENT.at(
                self.span(start, start + 2),
                "this comment is never closed",
                hint="close it with */",
            )
        )

    @cached_property
    def folder(self) -> Path:
        """The folder of the file."""
        return self.path.parent

    @cached_property
    def docs(self) -> Docs:
        """The documentation comments, by declaration."""
        return Docs(self.code, self.comments)

    @cached_property
    def _lines(self) -> LineTable:
        return LineTable(self.name, self.text)

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column, both from 1, of an offset."""
        return self._lines.position(offset)

    def span(self, start: int, end: int) -> Span:
        """Return the span of [start, end)."""
        return self._lines.span(start, end)

    def after(self, offset: int) -> Span:
        """Return the span directly after the character before `offset`, one column wide."""
        line, column = self.position(max(offset - 1, 0))
        return Span(self.name, line, column + 1, line, column + 2)


class Library(library.Library[Source]):
    """The CDL files of a run."""


def _blank(comment: str) -> str:
    if "\n" not in comment:
        return " " * len(comment)
    return "\n".join(" " * len(line) for line in comment.split("\n"))
