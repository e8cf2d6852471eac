"""Safe edits for diagnostics, which remove the cause without changing the meaning.

A fix is a function of the text at a diagnostic's span. It is only attached if that text is what the
diagnostic refers to, so diagnostics in expanded macros have none.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Edit, Fix, Span
from rtgen.facts.decoded_text import with_line_feeds

_LINE_END = re.compile(r"\r\n?|\n")
_ESCAPE = re.compile(r"\\([^ntvbrfa\\?'\"0-7xu\n])", re.ASCII)
_BEFORE = re.compile(r",[ \t]*\Z")
_AFTER = re.compile(r"[ \t]*,[ \t]*")
_MARKS = ("//", "/*", "#", ";", "<!--")
_COMMENT = re.compile(r"(?:/\*.*\*/|<!--.*-->|(?://|#|;).*)\Z")
_NUMBER = re.compile(r"0|[1-9]\d*")
_HINTED = re.compile(r"(?:write|did you mean) (\S+?)\??")

Replacement = tuple[int, int, str]
"""Start and end in a text, and the replacement."""


class Text:
    """A text with the offsets of its lines, whatever their ends."""

    def __init__(self, text: str) -> None:
        self.text = text
        self._starts = [0, *(m.end() for m in _LINE_END.finditer(text))]

    def offset(self, line: int, column: int) -> int:
        """Return the offset of a line and column, both 1-based; beyond the text, its end."""
        if line > len(self._starts):
            return len(self.text)
        return min(self._starts[line - 1] + column - 1, len(self.text))

    def span(self, file: str, start: int, end: int) -> Span:
        """Return the span of [start, end)."""
        places: list[int] = []
        for offset in (start, end):
            line = bisect_right(self._starts, offset)
            places += line, offset - self._starts[line - 1] + 1
        return Span(file, *places)

    def range(self, span: Span) -> tuple[int, int]:
        """Return the offsets of a span."""
        return self.offset(span.line, span.column), self.offset(
            span.end_line, span.end_column
        )

    def line(self, offset: int) -> tuple[int, int]:
        """Return the range of the line at an offset, with its line end."""
        number = bisect_right(self._starts, offset)
        return self._starts[number - 1], self.offset(number + 1, 1)


def _semicolon(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    return (start, end, "") if text[start:end] == ";" else None


def _escapes(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    return _of_literal(text, start, end, _ESCAPE.sub(r"\1", text[start:end]))


def _line_breaks(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    if "\\\n" in text[start:end] or "\r" in text[start:end]:
        return None
    return _of_literal(text, start, end, text[start:end].replace("\n", "\\n"))


def _of_literal(text: str, start: int, end: int, new: str) -> Replacement | None:
    is_literal = text[start:end].lstrip("L")[:1] in ("'", '"')
    return (start, end, new) if is_literal and new != text[start:end] else None


def _fraction(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    hinted = _HINTED.fullmatch(d.hint or "")
    number = text[start:end]
    if hinted is None or not _NUMBER.fullmatch(number):
        return None
    return (start, end, hinted[1]) if hinted[1].startswith(number) else None


def _item(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    """Return the removal of an item of a list, with the comma before it."""
    before = _BEFORE.search(text, 0, start)
    return None if before is None else (before.start(), end, "")


def _no_parameters(
    text: str, start: int, end: int, d: Diagnostic
) -> Replacement | None:
    return (
        (start, end, "(void)")
        if text[start:end].split() in (["()"], ["(", ")"])
        else None
    )


def _other_key(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    hinted = _HINTED.fullmatch(d.hint or "")
    is_key = text[start:end].isalnum()
    return (start, end, hinted[1]) if hinted is not None and is_key else None


def _equals(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    colon = text.find(":", start, end)
    return None if colon < 0 else (colon, colon + 1, "=")


def _comment(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    return (start, start + 1, ";") if text[start:end].startswith("#") else None


def _full_stop(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    return end, end, "."


def _include(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    lines = Text(text)
    first, last = lines.line(start)
    line = text[first:last]
    plain = line.lstrip().startswith("#") and "/*" not in line and "\\\n" not in line
    return (first, last, "") if plain else None


def _suppression(text: str, start: int, end: int, d: Diagnostic) -> Replacement | None:
    """Return the removal of a code without effect, with its comment if that has no other."""
    opens, closes = text.rfind("[", 0, start) + 1, text.find("]", end)
    if text[opens:start].strip():
        return text.rfind(",", 0, start), end, ""
    if text[end:closes].strip():
        follower = _AFTER.match(text, end)
        return start, follower.end() if follower else end, ""
    first, last = Text(text).line(start)
    begin = max(text.rfind(mark, first, start) for mark in _MARKS)
    match = _COMMENT.match(text[begin:last].rstrip())
    if begin < first or match is None:
        return None
    before = text[first:begin].rstrip()
    if before:
        return first + len(before), begin + match.end(), ""
    return first, last, ""


_FIXES: Mapping[
    str, tuple[str, Callable[[str, int, int, Diagnostic], Replacement | None]]
] = {
    "CDL0404": ("write (void)", _no_parameters),
    "CDL0410": ("remove the second direction", _item),
    "CDL0424": ("remove the limit", _item),
    "EDS0105": ("write ';' before the comment", _comment),
    "EDS0109": ("write the key as the standard spells it", _other_key),
    "EDS0110": ("write '='", _equals),
    "IDL0110": ("remove the ';'", _semicolon),
    "IDL0113": ("remove the backslash", _escapes),
    "IDL0114": ("write \\n", _line_breaks),
    "IDL0507": ("write the number as the type has it", _fraction),
    "IDL0606": ("remove the second name", _item),
    "LINT0001": ("remove the #include", _include),
    "LINT0015": ("remove the comment", _suppression),
    "TXT0002": ("write a full stop behind it", _full_stop),
}
"""Title of the fix and function that finds the edit, by code."""

CODES = frozenset(_FIXES)
"""Codes of the diagnostics that can have a fix."""


def attached(
    diagnostics: Iterable[Diagnostic], sources: Mapping[str, str]
) -> list[Diagnostic]:
    """Return the diagnostics with their fixes; `sources` are texts by displayed path."""
    texts: dict[str, Text] = {}
    result = []
    for d in diagnostics:
        if d.fix is None and d.code in _FIXES and d.span and d.span.file in sources:
            file = d.span.file
            if file not in texts:
                texts[file] = Text(sources[file])
            d = _with_fix(d, texts[file])
        result.append(d)
    return result


def _with_fix(d: Diagnostic, text: Text) -> Diagnostic:
    assert d.span is not None
    title, edit = _FIXES[d.code]
    start, end = text.range(d.span)
    replacement = edit(text.text, start, end, d)
    if replacement is None:
        return d
    start, end, new = replacement
    span = text.span(d.span.file, start, end)
    return replace(d, fix=Fix(title, (Edit(span, text.text[start:end], new),)))


def applied(text: str, edits: Sequence[Edit]) -> str:
    """Apply edits to a text, except those that overlap an earlier one or do not match.

    Edits have line feeds; the text keeps its own line ends.
    """
    lines = Text(text)
    line_end = "\r\n" if "\r\n" in text else "\n"
    parts: list[str] = []
    done = 0
    for edit in sorted(set(edits), key=lambda e: (e.span, e.new)):
        start, end = lines.range(edit.span)
        if start < done or with_line_feeds(text[start:end]) != edit.old:
            continue
        parts += text[done:start], edit.new.replace("\n", line_end)
        done = end
    return "".join([*parts, text[done:]])
