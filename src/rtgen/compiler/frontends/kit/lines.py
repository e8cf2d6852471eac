"""Converts offsets in a text to lines and columns."""

from __future__ import annotations

import re
from bisect import bisect_right

from rtgen.compiler.diagnostics import Span

_NEWLINE = re.compile("\n")


class LineTable:
    """The lines of a file's text; lines and columns are 1-based."""

    def __init__(
        self, file: str, text: str, newline: re.Pattern[str] = _NEWLINE
    ) -> None:
        self.file = file
        self.starts = [0, *(match.end() for match in newline.finditer(text))]

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column of an offset."""
        line = bisect_right(self.starts, offset)
        return line, offset - self.starts[line - 1] + 1

    def span(self, start: int, end: int) -> Span:
        """Return the span of [start, end); an end before the start is replaced by the start."""
        starts = self.starts
        line = bisect_right(starts, start)
        first = starts[line - 1] - 1
        if line < len(starts) and start <= end < starts[line]:
            return Span(self.file, line, start - first, line, end - first)
        return Span(self.file, line, start - first, *self.position(max(start, end)))
