"""Text of a document: offsets, rtgen's lines and columns, and the protocol's positions."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from rtgen.compiler.diagnostics import Span
from rtgen.facts.decoded_text import with_line_feeds

if TYPE_CHECKING:  # an extra; imported lazily, since only editors need positions
    from lsprotocol.types import Position, PositionEncodingKind, Range

_LINE_END = re.compile(r"\r\n|\n|\r")
_MARK = "\ufeff"

UTF_8, UTF_16, UTF_32 = "utf-8", "utf-16", "utf-32"
"""The protocol's names of encodings."""

_UNITS: dict[str, Callable[[str], int]] = {
    UTF_8: lambda text: len(text.encode("utf-8", "surrogatepass")),
    UTF_16: lambda text: len(text.encode("utf-16-le", "surrogatepass")) // 2,
    UTF_32: len,
}
"""Functions that count the code units of a text."""


class Text:
    """A text with its lines; immutable."""

    def __init__(self, source: str) -> None:
        self.source = source

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *(match.end() for match in _LINE_END.finditer(self.source))]

    @cached_property
    def _rows(self) -> list[int]:
        """The starts of lines as front ends count them: without a byte-order mark."""
        return [int(self.source.startswith(_MARK)), *self._starts[1:]]

    @cached_property
    def normal(self) -> str:
        """The text as front ends have it: with line feeds, without a byte-order mark."""
        return with_line_feeds(self.source.removeprefix(_MARK))

    @cached_property
    def _ascii(self) -> bool:
        return self.source.isascii()

    @property
    def lines(self) -> int:
        """The number of lines, including a last one without a line end."""
        return len(self._starts)

    def offset(self, position: Position, encoding: PositionEncodingKind) -> int:
        """Return the offset of a position; positions beyond a line or the text are clipped."""
        line = max(position.line, 0)
        if line >= len(self._starts):
            return len(self.source)
        start, end = self._line(line)
        text = self.source[start:end]
        column: int = max(position.character, 0)
        if encoding == UTF_32 or text.isascii():
            return start + min(column, len(text))
        units = _UNITS[encoding]
        passed = 0
        for index, character in enumerate(text):
            passed += units(character)
            if passed > column:
                return start + index
        return end

    def position(self, offset: int, encoding: PositionEncodingKind) -> Position:
        """Return the position of an offset."""
        from lsprotocol.types import Position

        line = bisect_right(self._starts, offset) - 1
        start = self._starts[line]
        if self._ascii or encoding == UTF_32:
            return Position(line, offset - start)
        text = self.source[start:offset]
        return Position(line, len(text) if text.isascii() else _UNITS[encoding](text))

    def range(self, start: int, end: int, encoding: PositionEncodingKind) -> Range:
        """Return the range of [start, end)."""
        from lsprotocol.types import Range

        return Range(self.position(start, encoding), self.position(end, encoding))

    @cached_property
    def whole_lines(self) -> tuple[int, ...]:
        """The offsets of the starts of lines."""
        return tuple(self._starts)

    def offsets(self, span: Span) -> tuple[int, int]:
        """Return the start and the end of one of rtgen's spans, clipped to the text."""
        start = self._place(span.line, span.column)
        return start, max(start, self._place(span.end_line, span.end_column))

    def span(self, file: str, start: int, end: int) -> Span:
        """Return the span of [start, end) in a file."""
        rows = self._rows
        line, last = (max(bisect_right(rows, place), 1) for place in (start, end))
        return Span(
            file, line, start - rows[line - 1] + 1, last, end - rows[last - 1] + 1
        )

    def replaced(
        self, range_: Range, new: str, encoding: PositionEncodingKind
    ) -> tuple[Text, Shift]:
        """Return the text with a range replaced; an inverted range is empty."""
        start = self.offset(range_.start, encoding)
        end = max(start, self.offset(range_.end, encoding))
        text = Text(self.source[:start] + new + self.source[end:])
        return text, Shift(start, end, start + len(new))

    def _line(self, line: int) -> tuple[int, int]:
        """Return a line without its line end."""
        start = self._starts[line]
        last = line + 1 == len(self._starts)
        end = len(self.source) if last else self._starts[line + 1]
        return start, start + len(self.source[start:end].rstrip("\r\n"))

    def _place(self, line: int, column: int) -> int:
        rows = self._rows
        if line > len(rows):
            return len(self.source)
        end = rows[line] - 1 if line < len(rows) else len(self.source)
        place = rows[line - 1] + column - 1
        return place if place < end else end


@dataclass(frozen=True, slots=True)
class Shift:
    """An edit as a map of offsets: `[start, old)` became `[start, new)`.

    All edits between two versions are merged into one, from the first to the last changed
    character.
    """

    start: int
    old: int
    new: int

    @staticmethod
    def between(old: str, new: str) -> Shift:
        """Return the edit that turns `old` into `new`."""
        if old == new:
            return Shift(len(old), len(old), len(new))
        start = _common(old, new, min(len(old), len(new)), forwards=True)
        most = min(len(old), len(new)) - start
        end = _common(old, new, most, forwards=False)
        return Shift(start, len(old) - end, len(new) - end)

    def forward(self, start: int, end: int) -> tuple[int, int] | None:
        """Return the place of [start, end) after the edit; None if the edit changed it."""
        if end <= self.start:
            return start, end
        if start >= self.old:
            by = self.new - self.old
            return start + by, end + by
        return None

    def around(self, start: int, end: int) -> tuple[int, int]:
        """Return the place of a range that may contain the edit."""
        by = self.new - self.old
        first = start if start <= self.start else max(start + by, self.start)
        last = end if end < self.old and end <= self.start else max(end + by, first)
        return first, last

    def back(self, offset: int) -> int:
        """Return the offset before the edit; inside the edit, its start."""
        if offset <= self.start:
            return offset
        if offset >= self.new:
            return offset + self.old - self.new
        return self.start


class Shifts:
    """Several edits, one after the other, as a map of offsets."""

    def __init__(self, shifts: Sequence[Shift]) -> None:
        self._shifts = shifts

    def forward(self, start: int, end: int) -> tuple[int, int] | None:
        """As `Shift.forward`."""
        place: tuple[int, int] | None = (start, end)
        for shift in self._shifts:
            if place is None:
                return None
            place = shift.forward(*place)
        return place

    def around(self, start: int, end: int) -> tuple[int, int]:
        """As `Shift.around`."""
        for shift in self._shifts:
            start, end = shift.around(start, end)
        return start, end

    def back(self, offset: int) -> int:
        """As `Shift.back`."""
        for shift in reversed(self._shifts):
            offset = shift.back(offset)
        return offset


_CHUNK = 4096


def _common(old: str, new: str, most: int, *, forwards: bool) -> int:
    """Return the number of common characters at the start, or else at the end."""

    def same(low: int, high: int) -> bool:
        if forwards:
            return old[low:high] == new[low:high]
        return old[len(old) - high : len(old) - low] == (
            new[len(new) - high : len(new) - low]
        )

    low = 0
    while low < most and same(low, min(low + _CHUNK, most)):
        low = min(low + _CHUNK, most)
    high = min(low + _CHUNK, most)
    while low < high:
        middle = (low + high + 1) // 2
        if same(low, middle):
            low = middle
        else:
            high = middle - 1
    return low
