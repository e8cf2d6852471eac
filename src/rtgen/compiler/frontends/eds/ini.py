"""Lexical form of EDS and DCF files: sections and keys with their places (CiA 306, 4.2)."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.rules import lexical
from rtgen.facts import encodings
from rtgen.facts.decoded_text import Decoded

MAX_BYTES = 16 * 1024 * 1024
MAX_LINE = 1024 * 1024

_KEY = re.compile(r"\s*([^=]*?)\s*=\s*(.*?)\s*", re.DOTALL)
_KEY_WITH_COLON = re.compile(r"\s*(\w+)\s*:\s*(.*?)\s*", re.DOTALL)
_HEADER = re.compile(r"\s*\[+([^\[\]]*)\]*\s*(.*?)\s*", re.DOTALL)
_CLEAN_HEADER = re.compile(r"\s*\[[^\[\]]*\]\s*")
_KEPT = re.compile(r"\s*;\s*rtgen:\s+(?=\[|\w+=)(.*)", re.DOTALL)
_NOT_ASCII = re.compile(r"[^\x00-\x7f]")
_PATH = re.compile(r"[^\s=\[\]]+\.(?:eds|dcf)\s*", re.IGNORECASE)


class Entry(msgspec.Struct, eq=False):
    """An entry `key=value`. Columns are 1-based; `value` is stripped."""

    file: str
    line: int
    column: int
    key: str
    value: str
    value_column: int

    @property
    def span(self) -> Span:
        """The place of the value, or of the key without one."""
        start, text = self.value_column, self.value
        if not text:
            start, text = self.column, self.key
        return Span(self.file, self.line, start, self.line, start + len(text))

    @property
    def key_span(self) -> Span:
        """The place of the key."""
        end = self.column + len(self.key)
        return Span(self.file, self.line, self.column, self.line, end)


class Section(msgspec.Struct, eq=False):
    """A section: its name as written, and its entries by lower-case key."""

    name: str
    span: Span
    entries: dict[str, Entry] = msgspec.field(default_factory=dict)

    def get(self, key: str) -> Entry | None:
        """Return the entry of a key, if it has a value."""
        entry = self.entries.get(key.lower())
        return entry if entry is not None and entry.value else None

    def text(self, key: str) -> str:
        """Return the value of a key, or an empty text."""
        entry = self.entries.get(key.lower())
        return "" if entry is None else entry.value

    def numbered(self) -> Iterator[tuple[int, Entry]]:
        """Yield the entries with decimal numbers as keys, in order of the file."""
        for key, entry in self.entries.items():
            if key.isascii() and key.isdigit() and len(key) <= 6:
                yield int(key), entry


class Document(msgspec.Struct, eq=False):
    """A file as text, and as sections by lower-case name, in order.

    `headers` are the lines that sections begin in, with their names; of a text in sections they
    are determined when needed. `inline`: a section has keys in that line, too.
    """

    file: str
    text: str
    sections: dict[str, Section]
    headers: list[tuple[int, str]] | None = None
    inline: bool = False

    def section_at(self, line: int) -> str | None:
        """Return the name of the section that contains a line; None for a header of a text."""
        if self.headers is None:
            self.headers = [
                (number, match[1].strip())
                for number, text in enumerate(self.text.split("\n"), 1)
                if text.lstrip()[:1] == "[" and (match := _HEADER.fullmatch(text))
            ]
        at = bisect_left(self.headers, (line + self.inline, "")) - 1
        following = self.headers[at + 1 : at + 2]
        if at < 0 or (not self.inline and following and following[0][0] == line):
            return None
        return self.headers[at][1]

    @property
    def start(self) -> Span:
        """The start of the file, for diagnostics about something missing."""
        return Span(self.file, 1, 1, 1, 1)


def too_large(file: str) -> Diagnostic:
    """Return the diagnostic for a file that is too large."""
    message = f"the file is larger than {MAX_BYTES:,} bytes"
    return lexical.TOO_LARGE.at(Span(file, 1, 1, 1, 1), message)


def read(
    data: bytes, file: str, findings: Findings, encoding: str = "auto"
) -> Document:
    """Split a file into sections; `file` is the path in diagnostics.

    `encoding` is the one asked for.
    """
    document = Document(file, "", {})
    if len(data) > MAX_BYTES:
        findings.report(too_large(file))
        return document
    decoded = encodings.decode(data, encoding)
    document.text = text = decoded.normal
    if "\0" in text:
        message = "this is not a text file: it holds a NUL byte"
        line = text.count("\n", 0, text.index("\0")) + 1
        findings.add(lexical.BINARY, Span(file, line, 1, line, 2), message)
        return document
    if _PATH.fullmatch(text):
        message = f"the file holds nothing but the path {text.strip()}"
        hint = "this is a symbolic link as text: give the file that it leads to"
        findings.add(lexical.A_LINK, document.start, message, hint=hint)
        return document
    _Reader(document, findings, decoded).run()
    return document


_OTHER_ENCODING = "if the text is wrong, say the encoding by --encoding"


class _Reader(msgspec.Struct, eq=False):
    """Reads the text line by line."""

    _document: Document
    _findings: Findings
    _decoded: Decoded
    _section: Section | None = None

    def run(self) -> None:
        text, file = self._document.text, self._document.file
        odd = _NOT_ASCII.search(text)
        if odd is not None or self._decoded.mark:
            at = 0 if odd is None else odd.start()
            row = text.count("\n", 0, at) + 1
            column = at - (text.rfind("\n", 0, at) + 1) + 1
            span = Span(file, row, column, row, column + (odd is not None))
            title = self._decoded.title
            if title == "UTF-8" and self._decoded.mark:
                title = "UTF-8 with a byte-order mark"
            message = f"the file is not ASCII; it is read as {title}"
            hint = None if self._decoded.doubt is None else _OTHER_ENCODING
            self._findings.add(lexical.NOT_ASCII, span, message, hint=hint)
        for number, line in enumerate(text.split("\n"), 1):
            if len(line) > MAX_LINE:
                message = (
                    f"line of {len(line):,} characters; at most {MAX_LINE:,} are read"
                )
                span = Span(file, number, 1, number, 2)
                self._findings.add(lexical.TOO_LARGE, span, message)
                self._document.text = text[:MAX_LINE]
                self._document.sections.clear()
                return
            stripped = line.lstrip()
            if stripped and stripped[0] != ";":
                self._line(number, line, stripped[0])
            elif stripped and (match := _KEPT.fullmatch(line)) is not None:
                self._kept(number, line, match.start(1))

    def _line(self, number: int, line: str, first: str) -> None:
        if first == "[":
            self._header(number, line)
        elif first == "#":
            message = "a comment starts with ';'"
            self._findings.add(
                lexical.STRAY_COMMENT, self._whole(number, line), message
            )
        elif (match := _KEY_WITH_COLON.fullmatch(line)) is not None:
            message = f"the ':' after {match[1]} is read as '='"
            self._findings.add(lexical.COLON, self._whole(number, line), message)
            self._entry(number, match)
        elif (match := _KEY.fullmatch(line)) is not None:
            self._entry(number, match)
        else:
            message = "this line is neither a section nor a key; it is ignored"
            self._findings.add(lexical.STRAY_LINE, self._whole(number, line), message)

    def _kept(self, number: int, line: str, start: int) -> None:
        """Read a line in a comment; its key comes before that of the section itself."""
        text = " " * start + line[start:]
        match = _KEY.fullmatch(text)
        if match is None:
            self._line(number, text, "[")
        elif self._section is not None:
            self._section.entries.pop(match[1].lower(), None)
            self._entry(number, match)

    def _whole(self, number: int, line: str) -> Span:
        start = len(line) - len(line.lstrip()) + 1
        return Span(self._document.file, number, start, number, len(line.rstrip()) + 1)

    def _header(self, number: int, line: str) -> None:
        match = _HEADER.fullmatch(line)
        name = "" if match is None else match[1].strip()
        span = self._whole(number, line)
        clean = _CLEAN_HEADER.fullmatch(line) is not None
        rest = "" if match is None else match[2]
        if not name or (not clean and rest[:1] != ";"):
            message = "malformed header of a section"
            self._findings.add(lexical.BAD_HEADER, span, message)
        elif rest:
            message = "a comment must be on its own line"
            self._findings.add(lexical.STRAY_COMMENT, span, message)
        self._section = None
        if not name:
            self._section = Section(name, span)
            return
        section = self._document.sections.get(name.lower())
        if section is None:
            section = Section(name, span)
            self._document.sections[name.lower()] = section
        else:
            message = f"there is a section [{section.name}] in line {section.span.line}"
            self._findings.add(lexical.SAME_SECTION, span, message)
        self._section = section

    def _entry(self, number: int, match: re.Match[str]) -> None:
        entry = Entry(
            self._document.file,
            number,
            match.start(1) + 1,
            match[1],
            match[2],
            match.start(2) + 1,
        )
        if self._section is None:
            message = "this key precedes the first section; it is ignored"
            self._findings.add(lexical.OUTSIDE, entry.key_span, message)
        elif not entry.key:
            message = "there is no key before the '='; the line is ignored"
            span = self._whole(number, match.string)
            self._findings.add(lexical.STRAY_LINE, span, message)
        else:
            first = self._section.entries.setdefault(entry.key.lower(), entry)
            if first is not entry:
                message = f"{first.key} is given in line {first.line} already"
                self._findings.add(lexical.SAME_KEY, entry.key_span, message)
