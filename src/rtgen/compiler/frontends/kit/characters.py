"""Characters of definition files: decoding, line ends, and octets that other programs misread.

In Shift_JIS the second octet of some characters is 5Ch, a backslash in ASCII. Programs that read
octets, such as omniidl and gcc, join a comment that ends in such a character with the next line;
here lines are joined by characters.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from functools import cache, cached_property

from rtgen.compiler.diagnostics import Diagnostic, Rule
from rtgen.compiler.frontends.kit.character_rules import (
    CONTINUED_COMMENT,
    ENCODING,
    LONE_RETURN,
    OCTET_OF_COMMENT,
    OCTET_OF_LITERAL,
)
from rtgen.compiler.frontends.kit.lines import LineTable
from rtgen.facts import encodings
from rtgen.facts.decoded_text import Decoded

TOKENS = re.compile(
    r"//[^\n]*|/\*(?:.*?\*/|.*)"
    r'|"(?:\\[^\n]|[^"\\\n])*"|"(?:\\.|[^"\\;{}#])*"|"[^\n]*'
    r"|'(?:\\[^\n]|[^'\\\n]){0,12}'",
    re.DOTALL,
)
"""A comment or a literal of IDL or C, in a text whose continued lines are joined."""

YAML = "YAML"
"""The format that may be UTF-16, too (YAML 1.2.2, 5.2)."""

_SPLICE = re.compile(r"\\\n")
_SPLICE_WITH_BLANKS = re.compile(r"\\[ \t]*\n")
_NOT_ASCII = re.compile(r"[^\x00-\x7f]")


class Joined:
    """A text whose lines are joined at backslashes, as C does, with the places in the original.

    `blanks`: blanks may follow the backslash, as gcc allows.
    """

    def __init__(self, text: str, *, blanks: bool = False) -> None:
        self.starts: list[int] = []
        """The offsets where a line was joined to the one before."""
        self._removed = [0]
        if "\\" not in text:
            self.text = text
            return
        parts = []
        start = length = 0
        for match in (_SPLICE_WITH_BLANKS if blanks else _SPLICE).finditer(text):
            parts.append(text[start : match.start()])
            length += match.start() - start
            start = match.end()
            self.starts.append(length)
            self._removed.append(start - length)
        parts.append(text[start:])
        self.text = "".join(parts)

    def original(self, offset: int) -> int:
        """Return the offset in the original text."""
        return offset + self._removed[bisect_right(self.starts, offset)]

    def with_all_lines(self) -> str:
        """Return the text with empty lines in place of those that were joined to others."""
        lines = []
        place = end = 0
        for line in self.text.split("\n"):
            place += len(line)
            joined = bisect_right(self.starts, place)
            lines.append(line + "\n" * (joined - end))
            place, end = place + 1, joined
        return "\n".join(lines)

    def backslashes(self, start: int, end: int) -> Iterator[tuple[int, int]]:
        """Yield the backslashes in (start, end), as places in the original and in this text."""
        first, last = bisect_right(self.starts, start), bisect_left(self.starts, end)
        for number in range(first, last):
            place = self.starts[number]
            yield place + self._removed[number], place


class Characters:
    """The characters of a file, with a line feed as its only line end, and findings about them.

    `file` is its displayed path.
    """

    def __init__(self, file: str, decoded: Decoded) -> None:
        self.file = file
        self.text = decoded.normal
        self.problems: list[Diagnostic] = []
        self._lone_return = decoded.lone_return
        self.has_octets = any(
            encoding in ("sjis", "none") and b"\\" in part
            for encoding, part in decoded.parts
        )
        """Whether a character may have the octet of a backslash; at the end of a line, it is read
        as one of Shift_JIS in Windows-1252, too.
        """
        self._is_sjis = decoded.encoding == "sjis"

    @cached_property
    def _lines(self) -> LineTable:
        return LineTable(self.file, self.text)

    def doubt(self, rule: Rule, message: str, line: int) -> None:
        """Report a doubt about the encoding, at the first character that is not ASCII."""
        starts = self._lines.starts
        first = starts[min(line, len(starts)) - 1]
        match = _NOT_ASCII.search(self.text, first)
        span = self._lines.span(*((first, first) if match is None else match.span()))
        self.problems.append(rule.at(span, message))

    def check(self, joined: Joined, readers: str, *, literals: bool) -> None:
        """Report comments, and literals, that `readers` read otherwise, and continued comments.

        `joined` is the text with its lines joined, `readers` are programs that read octets.
        """
        if not (self.has_octets or joined.starts):
            return
        for match in TOKENS.finditer(joined.text):
            start, end = match.span()
            place = joined.original(start), joined.original(end - 1) + 1
            if match[0].startswith("//"):
                self.check_comment(*place, readers)
                self._check_continued(start, end, joined)
            elif literals and match[0][0] != "/":
                self.check_literal(*place, readers)

    def check_comment(self, start: int, end: int, readers: str) -> None:
        """Report a `//` comment at [start, end) of the text if it ends in such an octet."""
        if not self.has_octets:
            return
        end = start + len(self.text[start:end].rstrip(" \t"))
        if not _ends_in_backslash().match(self.text, end - 1):
            return
        message = (
            f"the last octet of {self.text[end - 1]} is 5Ch, a backslash: to {readers} the"
            " next line is part of the comment"
        )
        span = self._lines.span(end - 1, end)
        self.problems.append(OCTET_OF_COMMENT.at(span, message))

    def check_literal(self, start: int, end: int, readers: str) -> None:
        """Report a literal at [start, end) of the text with such an octet."""
        if not (self.has_octets and self._is_sjis):
            return
        match = _ends_in_backslash().search(self.text, start, end)
        if match is not None:
            message = (
                f"the last octet of {match[0]} is 5Ch, a backslash: to {readers} it begins"
                " an escape sequence"
            )
            span = self._lines.span(*match.span())
            self.problems.append(OCTET_OF_LITERAL.at(span, message))

    def _check_continued(self, start: int, end: int, joined: Joined) -> None:
        """Report a `//` comment at [start, end) of the joined text that contains other lines."""
        for backslash, place in joined.backslashes(start, end):
            if joined.text[place:end].strip():
                message = "the backslash makes the next line part of this comment"
                span = self._lines.span(backslash, backslash + 1)
                self.problems.append(CONTINUED_COMMENT.at(span, message))

    def check_line_ends(self) -> None:
        """Report the first carriage return without a line feed."""
        if self._lone_return is not None:
            message = "a lone carriage return is read as a line end"
            span = self._lines.span(self._lone_return, self._lone_return)
            self.problems.append(LONE_RETURN.at(span, message))


@cache
def _ends_in_backslash() -> re.Pattern[str]:
    """Return the pattern of the characters of Shift_JIS whose second octet is a backslash."""
    leads = (*range(0x81, 0xA0), *range(0xE0, 0xFD))
    pairs = (bytes((lead, ord("\\"))).decode("cp932", "ignore") for lead in leads)
    return re.compile(f"[{''.join(pair for pair in pairs if not pair.isascii())}]")


def read(
    data: bytes,
    file: str,
    encoding: str = "auto",
    *,
    rule: Rule = ENCODING,
    standard: str | None = None,
) -> Characters:
    """Return the characters of a file displayed as `file`.

    `encoding`, of `decoded_text.NAMES`, is the one asked for; `rule` that of doubts about it.
    `standard` is the name of a format that demands UTF-8.
    """
    decoded = encodings.decode(data, encoding, standard=standard is not None)
    characters = Characters(file, decoded)
    doubt = decoded.doubt
    is_utf16 = decoded.title == "UTF-16"
    if standard is None:
        if doubt is None and is_utf16:
            doubt = "the file is UTF-16, which other compilers do not read"
    elif decoded.encoding != "utf8" and not (is_utf16 and standard == YAML):
        doubt = f"{standard} is UTF-8; read as {decoded.title}"
    if doubt is not None:
        characters.doubt(rule, doubt, decoded.line)
    return characters
