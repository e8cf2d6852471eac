"""Layouts of CDR and XCDR as data: the position of each value, grouped by `struct` call.

Alignment is that of each basic type, up to 8 (XCDR2: 4), from the start of the body (CORBA 3.3 part
2, 9.3.1; DDS-XTypes 1.3, 7.4.3.2). A type becomes a tree of nodes (`trees`); `steps_of` arranges
the tree in wire order: runs of values whose positions depend on counts only, loops over elements of
varying size, and calls of the codecs of unions and recursive structs.
"""

from __future__ import annotations

from math import gcd, prod
from typing import Final, NamedTuple, TypeAlias

import msgspec

from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Delimited,
    Dynamic,
    Field,
    Group,
    Header,
    Member,
    MemberList,
    Node,
    Optional,
    Parameter,
    Path,
    Placed,
    Records,
    Reference,
    Repeat,
    Text,
    TextArray,
    TextSequence,
)


class Entry(msgspec.Struct, frozen=True):
    """Meaning of an item of `struct`: a field, or its count.

    `star`: as many values as the field has items.
    """

    field: Field
    count: bool = False
    star: bool = False


class Section(msgspec.Struct, frozen=True):
    """Values read by one `struct` call, once the count before them is known.

    `text` is in the runtime's notation: `=` and a format with fixed padding; or tokens such as `I`,
    `3d`, `*i` (the count's number of items), `*48o/8` (48 octets each, aligned to 8), preceded by
    `@4` if the offset modulo 8 is known to be 4, and by `!` if no `struct` call reads them
    (`bulk`). `size` is that of fixed sections.
    """

    text: str
    entries: tuple[Entry, ...]
    counted: Field | None
    settled: bool
    known: bool
    size: int
    bulk: bool = False


class Run(msgspec.Struct, frozen=True):
    """Fields that one `struct` call writes, and the sections in which they are read.

    `known`: the start offset is known modulo the run's alignment.
    """

    fields: tuple[Field, ...]
    sections: tuple[Section, ...]
    known: bool


class Loop(msgspec.Struct, frozen=True):
    """Repetition of the inner steps for each element of `path`; the previous run has the count."""

    path: Path
    node: Repeat
    steps: tuple[Step, ...]
    key_steps: tuple[Step, ...] = ()


class Jump(msgspec.Struct, frozen=True):
    """A value written and read by its own codec."""

    path: Path
    node: Call | Reference | Dynamic


class Frame(msgspec.Struct, frozen=True):
    """The steps of a value that is delimited, optional, or after a header of its own.

    Those of a `MemberList` are in wire order.
    """

    path: Path
    node: Framed
    steps: tuple[Step, ...]


Framed: TypeAlias = Delimited | Optional | Member | Parameter | MemberList


Step: TypeAlias = Run | Loop | Jump | Frame


class Position(msgspec.Struct, frozen=True, gc=False):
    """A partly known offset: its remainder modulo 1, 2, 4 or 8."""

    modulus: int
    remainder: int

    def aligned(self, align: int) -> Position:
        if self.modulus % align:
            return Position(align, 0)
        return Position(
            self.modulus, (self.remainder + -self.remainder % align) % self.modulus
        )

    def after(self, size: int) -> Position:
        return Position(self.modulus, (self.remainder + size) % self.modulus)

    def after_items(self, size: int, align: int) -> Position:
        """Return the position after any number of items, including none (then without padding)."""
        start = self.aligned(align)
        modulus = gcd(
            self.modulus, start.modulus, size, start.remainder - self.remainder
        )
        return Position(modulus, self.remainder % modulus)


ORIGIN = Position(8, 0)
"""The start of a body."""

ANYWHERE = Position(1, 0)
"""Inside a body, after a value of varying size."""


ALIGNED = Position(4, 0)
"""After a length or a header."""


def steps_of(node: Node, start: Position) -> tuple[Step, ...]:
    """Return the layout of a value that begins at `start`."""
    return steps_of_fields(fields_of(node), start)


def steps_of_fields(
    fields: list[Field | Loop | Jump | Frame], start: Position
) -> tuple[Step, ...]:
    """Return the layout of consecutive values, the first of which begins at `start`."""
    return _Arrangement(start).steps(fields)


class Single(NamedTuple):
    """The run that is a whole value, and the path of that run; `delimited`: after a DHEADER."""

    run: Run
    path: Path = ()
    delimited: bool = False


def single(steps: tuple[Step, ...]) -> Single | None:
    """Return the run that is the whole value, if it is one."""
    match steps:
        case (Run() as run,):
            return Single(run)
        case (Frame(path=path, node=Delimited(), steps=(Run() as run,)),):
            return Single(run, path, True)
    return None


def settled_size(steps: tuple[Step, ...]) -> int | None:
    """Return the size of a value of fixed size; None if it varies, or has several runs."""
    if not steps:
        return 0
    if len(steps) > 1 or not isinstance(steps[0], Run):
        return None
    sections = steps[0].sections
    return sum(s.size for s in sections) if all(s.settled for s in sections) else None


def fields_of(node: Node, path: Path = ()) -> list[Field | Loop | Jump | Frame]:
    """Return the tree in wire order with structs flattened; loops and jumps follow their counts."""
    match node:
        case Group(members=members):
            return [
                f for name, inner in members for f in fields_of(inner, (*path, name))
            ]
        case Repeat(length=None):
            return [Field(path, node), Loop(path, node, ())]
        case Repeat():
            return [Loop(path, node, ())]
        case Call() | Reference() | Dynamic():
            return [Jump(path, node)]
        case MemberList() | Parameter() | Delimited() | Optional():
            return [Frame(path, node, ())]
        case Member(node=inner) if not node.optional:
            headers = _headers(node)
            if headers is None:
                return [Frame(path, node, ())]
            return [Field(path, header) for header in headers] + fields_of(inner, path)
        case Member():
            return [Frame(path, node, ())]
        case _:
            return [Field(path, node)]


def has_varying_length(member: Member) -> bool:
    """Return whether the length after the EMHEADER varies."""
    return _headers(member) is None


def _headers(member: Member) -> list[Header] | None:
    """Return the headers before a member's value; None if its length varies."""
    if member.length_code != 4:
        return [Header(member.header)]
    size = settled_size(steps_of(member.node, ALIGNED))
    return None if size is None else [Header(member.header), Header(size)]


def _framed(node: Framed) -> tuple[Step, ...]:
    match node:
        case MemberList(members=members):
            fields = [f for name, inner in members for f in fields_of(inner, (name,))]
            return _Arrangement(ALIGNED).steps(fields)
        case Member(node=inner):
            headers = _headers(node)
            if headers is None:
                return steps_of(inner, ALIGNED)
            fields = [Field((), header) for header in headers]
            return _Arrangement(ANYWHERE).steps(fields + fields_of(inner))
        case Parameter(node=inner):
            return steps_of(inner, ORIGIN)
        case Delimited(node=inner):
            return steps_of(inner, ALIGNED)
    return steps_of(node.node, ANYWHERE)


def fixed_format(fields: tuple[Field, ...]) -> tuple[str, int, int, int] | None:
    """Return (format, stride, padding, alignment) of repeated elements that begin at offset 0.

    The result is None if the place of a field depends on that of the element.
    """
    text, offset, most = "", 0, 1
    aligns = []
    for field in fields:
        token, size, align = token_of(field.node)
        padding = -offset % align
        text += pad(padding) + token.partition("/")[0]
        offset += padding + size
        most = max(most, align)
        aligns.append(align)
    if not aligns or aligns[0] != most:
        return None
    padding = -offset % most
    return text + pad(padding), offset + padding, padding, most


def token_of(node: Placed | Repeat) -> tuple[str, int, int]:
    """Return (token, size, alignment) of a value without a count."""
    match node:
        case Atom(size=size, align=align):
            return _aligned(node), size, align
        case Header():
            return "I", 4, 4
        case AtomArray(atom=atom, dimensions=dimensions, form="list"):
            number = prod(dimensions)
            return f"{number}{_aligned(atom)}", number * atom.size, atom.align
        case AtomArray(atom=atom, dimensions=dimensions):
            size = prod(dimensions) * atom.size
            return f"{size}o/{atom.align}", size, atom.align
        case TextArray(length=length):
            return f"{length}s", length, 1
        case Records(length=int(length), align=align):
            size = node.octets(length)
            return f"{size}o/{align}", size, align
    raise TypeError(node)


def _aligned(atom: Atom) -> str:
    """Return the code of an atom, with its alignment if that is not its size."""
    usual = atom.align in (1, atom.size)
    return atom.code if usual else f"{atom.code}/{atom.align}"


def _counted_token(node: Placed) -> tuple[str, int, int]:
    """Return (token, divisor of the size of any number of items, alignment) after a count."""
    match node:
        case AtomSequence(atom=atom):
            return f"*{_aligned(atom)}", atom.size, atom.align
        case TextSequence(text=text):
            return ("*z" if text is Text.STRING else "*s"), 1, 1
        case Records(stride=stride, padding=padding, align=align):
            without = f"-{padding}" if padding else ""
            return f"*{stride}o/{align}{without}", gcd(stride, padding), align
    raise TypeError(node)


_MAX_UNSTARRED: Final = 256
"""Python allows fewer targets of an assignment before a starred one."""


class _Arrangement:
    """Arranges a tree while tracking the known part of the offset."""

    def __init__(self, start: Position) -> None:
        self._position = start
        self._steps: list[Step] = []
        self._begin_run()

    def steps(self, fields: list[Field | Loop | Jump | Frame]) -> tuple[Step, ...]:
        for item in fields:
            match item:
                case Field():
                    self._place(item)
                    continue
                case Loop(path=path, node=repeat):
                    self._end_run()
                    keys = (
                        steps_of(repeat.key, ANYWHERE) if repeat.key is not None else ()
                    )
                    self._steps.append(
                        Loop(path, repeat, steps_of(repeat.element, ANYWHERE), keys)
                    )
                case Jump():
                    self._end_run()
                    self._steps.append(item)
                case Frame(path=path, node=framed):
                    self._end_run()
                    self._steps.append(Frame(path, framed, _framed(framed)))
            self._position = ANYWHERE
            self._begin_run()
        self._end_run()
        return tuple(self._steps)

    def _begin_run(self) -> None:
        self._fields: list[Field] = []
        self._sections = [_Section(self._position)]

    def _end_run(self) -> None:
        if not self._fields:
            return
        sections = [section for section in self._sections if section.tokens]
        most = max(section.most for section in sections)
        is_aligned = sections[0].start.modulus % most == 0
        self._steps.append(
            Run(
                tuple(self._fields),
                tuple(s.finished(is_aligned) for s in sections),
                is_aligned,
            )
        )

    def _place(self, field: Field) -> None:
        self._fields.append(field)
        node = field.node
        section = self._sections[-1]
        if not has_count(node):
            star = isinstance(node, AtomArray) and node.form == "list"
            entries = section.entries
            if star and (
                len(entries) >= _MAX_UNSTARRED or any(e.star for e in entries)
            ):
                section = _Section(self._position)
                self._sections.append(section)
            self._position = section.add(
                *token_of(node), Entry(field, star=star), self._position
            )
            return
        self._position = section.add(
            "I", 4, 4, Entry(field, count=True), self._position
        )
        if isinstance(node, Repeat):
            return
        section = _Section(self._position, field)
        self._sections.append(section)
        token, size, align = _counted_token(node)
        section.tokens.append(token)
        section.most = align
        section.entries.append(Entry(field, star=isinstance(node, AtomSequence)))
        self._position = self._position.after_items(size, align)
        if is_bulk(node):
            self._sections.append(_Section(self._position))


class _Section:
    """A section under construction."""

    def __init__(self, start: Position, counted: Field | None = None) -> None:
        self.start = start
        self.counted = counted
        self.tokens: list[str] = []
        self.entries: list[Entry] = []
        self.most = 1
        self._format = ""
        self._size = 0

    def add(
        self, token: str, size: int, align: int, entry: Entry, before: Position
    ) -> Position:
        """Append a value of known size; return the position after it."""
        padding = -before.remainder % align if before.modulus % align == 0 else 0
        self._format += pad(padding) + token.partition("/")[0]
        self._size += padding + size
        self.tokens.append(token)
        self.entries.append(entry)
        self.most = max(self.most, align)
        return before.aligned(align).after(size)

    def finished(self, run_known: bool) -> Section:
        is_aligned = self.start.modulus % self.most == 0
        settled = run_known and is_aligned and self.counted is None
        text = " ".join(self.tokens)
        bulk = self.counted is not None and is_bulk(self.counted.node)
        if settled:
            text = f"={self._format}"
        elif is_aligned:
            text = f"@{self.start.remainder} {text}"
        if bulk:
            text = f"!{text}"
        return Section(
            text,
            tuple(self.entries),
            self.counted,
            settled,
            is_aligned,
            self._size,
            bulk,
        )


def pad(octets: int) -> str:
    """Return padding in a `struct` format."""
    return "x" * octets if octets < 3 else f"{octets}x"


def is_bulk(node: Node) -> bool:
    """Return whether the items of a sequence are read in one piece, by `bulk`."""
    return isinstance(node, AtomSequence | Records) and node.form == "numpy"


def has_count(node: Placed | Repeat) -> bool:
    """Return whether a count precedes the node on the wire."""
    match node:
        case AtomSequence() | TextSequence():
            return True
        case Records(length=length) | Repeat(length=length):
            return length is None
    return False
