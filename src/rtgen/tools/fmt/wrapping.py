"""Breaks a statement into lines: where required, and where it is too long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

LAST_RESORT = 100
"""Priority of a break directly after an opening bracket."""


@dataclass(slots=True)
class Piece:
    """A token with its layout.

    `opens`, `closes`: the bracket that the piece is, or an empty text. `must`: a line ends before
    the piece. `may`: the cost of a break before it; None if a break is impossible. `restarts`: a
    line that starts with it is indented like the first one. `column` is that of a comment in the
    source, whose further lines are moved with it.
    """

    text: str
    space: bool
    opens: str = ""
    closes: str = ""
    must: bool = False
    may: int | None = None
    restarts: bool = False
    column: int | None = None


@dataclass(frozen=True, slots=True)
class Frame:
    """Widths of a layout in columns."""

    width: int
    step: int


class _Open(NamedTuple):
    """An open bracket, inside of `outer`; `braces`: the number of `{` up to it.

    The stack is immutable, so that a state can be kept without a copy.
    """

    mark: str
    column: int | None
    outer: _Open | None
    braces: int


@dataclass(slots=True)
class _Point:
    """A possible end of a line, with the state of the line before it."""

    may: int
    piece: int
    parts: int
    opened: _Open | None


class _Wrapping:
    def __init__(self, pieces: Sequence[Piece], indent: int, frame: Frame) -> None:
        self._pieces = pieces
        self._indent = indent
        self._frame = frame
        self._lines: list[str] = []
        self._open: _Open | None = None
        self._points: list[_Point] = []
        self._parts: list[str] = []
        self._column = 0

    def lines(self, first: int) -> list[str]:
        self._start(first)
        index = 0
        while index < len(self._pieces):
            piece = self._pieces[index]
            fresh = len(self._parts) == 1
            if not fresh and piece.must:
                self._end_line(index)
                fresh = True
            elif not fresh and not self._fits(piece):
                self._mark(index, piece)
                if self._points:
                    index = self._rewind()
                    continue
            elif not fresh:
                self._mark(index, piece)
            self._add(piece, fresh)
            index += 1
        self._lines.append("".join(self._parts))
        return self._lines

    def _start(self, column: int) -> None:
        self._parts = [" " * column]
        self._column = column
        self._points = []

    def _fits(self, piece: Piece) -> bool:
        first, _, _ = piece.text.partition("\n")
        return self._column + piece.space + len(first) <= self._frame.width

    def _mark(self, index: int, piece: Piece) -> None:
        if piece.may is not None:
            point = _Point(piece.may, index, len(self._parts), self._open)
            while self._points and self._points[-1].may >= piece.may:
                self._points.pop()
            self._points.append(point)

    def _rewind(self) -> int:
        """End the line at the best point so far; return the piece to continue with."""
        point = self._points[0]
        del self._parts[point.parts :]
        self._open = point.opened
        self._end_line(point.piece)
        return point.piece

    def _end_line(self, index: int) -> None:
        self._lines.append("".join(self._parts))
        if index and self._pieces[index - 1].opens and self._open is not None:
            self._open = self._open._replace(column=None)
        self._start(self._continuation(self._pieces[index]))

    def _continuation(self, piece: Piece) -> int:
        step = self._frame.step
        if piece.restarts:
            return self._indent
        inside = self._open
        if inside is not None and inside.mark == "{":
            return self._indent + step * (inside.braces - (piece.closes == "{"))
        column = None if inside is None else inside.column
        if column is not None and column <= self._frame.width // 2:
            return column
        return self._indent + 2 * step

    def _add(self, piece: Piece, fresh: bool) -> None:
        if piece.space and not fresh:
            self._parts.append(" ")
            self._column += 1
        text = piece.text
        if piece.column is not None and "\n" in text:
            text = moved(text, piece.column, self._column)
        self._parts.append(text)
        _, newline, last = text.rpartition("\n")
        self._column = len(last) if newline else self._column + len(last)
        if piece.opens:
            braces = 0 if self._open is None else self._open.braces
            braces += piece.opens == "{"
            self._open = _Open(piece.opens, self._column, self._open, braces)
        elif piece.closes:
            for _ in piece.text if piece.closes == "<" else "}":
                self._close(piece.closes)

    def _close(self, mark: str) -> None:
        while self._open is not None:
            opening, self._open = self._open.mark, self._open.outer
            if opening == mark:
                return


def wrapped(
    pieces: Sequence[Piece], indent: int, frame: Frame, first: int | None = None
) -> list[str]:
    """Return the lines of a statement, indented by `indent`; the first starts at column `first`."""
    return _Wrapping(pieces, indent, frame).lines(indent if first is None else first)


def moved(comment: str, column: int, target: int) -> str:
    """Return a comment of several lines, moved from one column to another.

    The stars of a doc comment are aligned; other lines keep their relative indentation, if
    possible.
    """
    if comment.startswith("//"):
        return comment
    first, *rest = [line.rstrip(" \t") for line in comment.split("\n")]
    if all(not line or line.lstrip(" \t").startswith("*") for line in rest):
        starred = (line.lstrip(" \t") for line in rest)
        return "\n".join(
            [
                first,
                *(f"{' ' * (target + 1)}{line}" if line else "" for line in starred),
            ]
        )
    distance = target - column
    if any("\t" in line[: len(line) - len(line.lstrip())] for line in rest):
        distance = 0
    if distance < 0 and any(line and line[:-distance].strip() for line in rest):
        distance = 0
    if distance < 0:
        rest = [line[-distance:] for line in rest]
    else:
        rest = [f"{' ' * distance}{line}" if line else "" for line in rest]
    return "\n".join([first, *rest])
