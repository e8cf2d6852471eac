"""A preprocessed file: its text, with the origin of each character."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.idl.text.source import Source
from rtgen.compiler.frontends.kit.doc_comments import Comment, Docs
from rtgen.compiler.frontends.kit.findings import Findings


class Piece(msgspec.Struct, frozen=True):
    """A run of a unit's text that comes from [start, end) of a source's code.

    `expanded`: as a whole it comes from all of [start, end), as macro expansions do. A line marker
    sets another file name and an offset for line numbers.
    """

    source: Source
    start: int
    end: int
    expanded: bool = False
    file: str | None = None
    shift: int = 0


class Pragma(msgspec.Struct, frozen=True):
    """`#pragma text` at `offset` of a unit's text; [start, end) is its place in the source."""

    offset: int
    text: str
    span: Span


class Inclusion(msgspec.Struct, frozen=True):
    """Another file's declarations, included between two definitions at file scope."""

    offset: int
    unit: Unit
    span: Span


class Repeated(msgspec.Struct, frozen=True):
    """Files included in a row, by name, of which their guards have left nothing.

    `places` are those of the inclusions, by name.
    """

    offset: int
    sources: Mapping[str, Source]
    places: Sequence[tuple[str, Span]]


class Boundary(msgspec.Struct, frozen=True):
    """The start or the end of a file that was included inside a declaration."""

    offset: int
    source: Source
    opens: bool


class Unit(msgspec.Struct, eq=False, dict=True):
    """Result of preprocessing a file.

    `events` (pragmas, inclusions, boundaries of nested files) and `comments` are in order of their
    offsets in `text`. `lacking`: an include or a macro's text is missing, so unknown names are not
    reported; `flawed` are the offsets of macro calls that could not be expanded; `maybe_declared`
    are names, in lower case, that declarations with syntax errors may have declared; `excused` are
    the offsets of superfluous `;` caused by a reported error; `cut`: an unterminated comment or
    conditional has swallowed the rest. `included` are the units of its inclusions, `findings` the
    diagnostics of its own text; `searched` has the absolute paths of the files that its includes
    were searched at, `printed` the names of included files that are on no disk. `guessed`: a hint
    refers to other files of a folder.
    """

    source: Source
    text: str = ""
    pieces: list[Piece] = msgspec.field(default_factory=list)
    offsets: list[int] = msgspec.field(default_factory=list)
    events: list[Pragma | Inclusion | Repeated | Boundary] = msgspec.field(
        default_factory=list
    )
    comments: list[Comment] = msgspec.field(default_factory=list)
    nested: list[Source] = msgspec.field(default_factory=list)
    lacking: bool = False
    cut: bool = False
    flawed: set[int] = msgspec.field(default_factory=set)
    maybe_declared: set[str] = msgspec.field(default_factory=set)
    excused: set[int] = msgspec.field(default_factory=set)
    included: list[Unit] = msgspec.field(default_factory=list)
    findings: Findings = msgspec.field(default_factory=Findings)
    searched: dict[str, None] = msgspec.field(default_factory=dict)
    printed: dict[str, None] = msgspec.field(default_factory=dict)
    guessed: bool = False
    _spans: dict[tuple[int, int], Span] = msgspec.field(default_factory=dict)

    @property
    def all_included(self) -> Iterator[Unit]:
        """The unit and the units that it includes, each once, in order of their inclusions."""
        visited: set[int] = set()
        waiting = [self]
        while waiting:
            unit = waiting.pop()
            if id(unit) not in visited:
                visited.add(id(unit))
                yield unit
                waiting += reversed(unit.included)

    @property
    def includes(self) -> dict[str, None]:
        """The names of the files that it includes, in order."""
        names: dict[str, None] = {}
        for event in self.events:
            if isinstance(event, Inclusion):
                names[event.unit.source.name] = None
            elif isinstance(event, Repeated):
                names |= dict.fromkeys(event.sources)
        names |= dict.fromkeys(source.name for source in self.nested)
        return names

    @property
    def inclusions(self) -> Iterator[tuple[str, Span]]:
        """The places where it includes files at file scope, by name, in order."""
        for event in self.events:
            if isinstance(event, Inclusion):
                yield event.unit.source.name, event.span
            elif isinstance(event, Repeated):
                yield from event.places

    @cached_property
    def docs(self) -> Docs:
        """The doc comments of its text."""
        return Docs(self.text, self.comments)

    def piece(self, offset: int) -> tuple[Piece, int]:
        """Return the piece at an offset, and its start; at the end of the text, the last piece."""
        index = max(bisect_right(self.offsets, offset) - 1, 0)
        return self.pieces[index], self.offsets[index]

    def span(self, start: int, end: int) -> Span:
        """Return the place of [start, end) in the original text."""
        span = self._spans.get((start, end))
        if span is None:
            span = self._spans[start, end] = self._original(start, end)
        return span

    def _original(self, start: int, end: int) -> Span:
        if not self.pieces:
            return self.source.span(0, 0)
        first, begin = self.piece(start)
        if (
            end - begin <= first.end - first.start
            and start < end
            and first.file is None
            and not first.expanded
            and not first.shift
        ):
            offset = first.start - begin
            return first.source.span(start + offset, end + offset)
        within = not first.expanded and end - begin <= first.end - first.start
        if within or end <= start:
            last, until = first, begin
        else:
            last, until = self.piece(end - 1)
        low = first.start if first.expanded else first.start + start - begin
        high = last.end if last.expanded else last.start + max(end, start) - until
        if last.source is not first.source or high < low:
            high = first.end
        span = first.source.span(low, high)
        if first.file is None and not first.shift:
            return span
        return Span(
            first.file or span.file,
            max(span.line + first.shift, 1),
            span.column,
            max(span.end_line + first.shift, 1),
            span.end_column,
        )

    def after(self, offset: int) -> Span:
        """Return the place just after the character before `offset`, one column wide."""
        span = self.span(max(offset - 1, 0), max(offset, 1))
        column = span.end_column
        return Span(span.file, span.end_line, column, span.end_line, column + 1)


class TextBuilder:
    """Assembles a unit's text, piece by piece."""

    def __init__(self, source: Source) -> None:
        self.unit = Unit(source)
        self.length = 0
        self._parts: list[str] = []

    def copy(
        self, source: Source, start: int, end: int, file: str | None, shift: int
    ) -> None:
        """Append [start, end) of a source's code unchanged."""
        if start == end:
            return
        unit = self.unit
        self._parts.append(source.code[start:end])
        last = unit.pieces[-1] if unit.pieces else None
        if (
            last is not None
            and last.source is source
            and last.end == start
            and not last.expanded
            and (last.file, last.shift) == (file, shift)
        ):
            unit.pieces[-1] = Piece(source, last.start, end, False, file, shift)
        else:
            unit.pieces.append(Piece(source, start, end, False, file, shift))
            unit.offsets.append(self.length)
        self.length += end - start

    def expand(
        self,
        text: str,
        source: Source,
        start: int,
        end: int,
        file: str | None,
        shift: int,
    ) -> None:
        """Append the expansion of [start, end) of a source's code."""
        if text:
            self._parts.append(text)
            self.unit.pieces.append(Piece(source, start, end, True, file, shift))
            self.unit.offsets.append(self.length)
            self.length += len(text)

    def tail(self, start: int) -> tuple[str, int]:
        """Return the parts appended since part number `start`, and the number of the next part."""
        return "".join(self._parts[start:]), len(self._parts)

    def finish(self) -> Unit:
        """Return the unit, with the comments of its pieces."""
        unit = self.unit
        unit.text = "".join(self._parts)
        for piece, offset in zip(unit.pieces, unit.offsets, strict=True):
            if piece.expanded:
                continue
            comments = piece.source.comments
            first = bisect_left(comments, piece.start, key=lambda c: c.start)
            last = bisect_left(comments, piece.end, first, key=lambda c: c.start)
            shift = offset - piece.start
            unit.comments += (
                Comment(c.start + shift, c.end + shift, c.text) if shift else c
                for c in comments[first:last]
            )
        return unit
