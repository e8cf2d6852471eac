"""Layouts of CDR and XCDR as data: the position of each value, grouped by `struct` call.

Alignment is that of each basic type, up to 8 (XCDR2: 4), from the start of the body (CORBA 3.3
part 2, 9.3.1; DDS-XTypes 1.3, 7.4.3.2). A type becomes a tree of nodes (`trees`); `steps_of` lays
the tree out in the order of the wire: runs of values whose place follows from the counts alone,
loops over elements of varying size, and calls of the codecs of unions and recursive structs.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from math import gcd, prod
from typing import Any, TypeAlias


class Form(Enum):
    """The Python representation of an atom."""

    NUMBER = auto()
    BOOLEAN = auto()
    CHARACTER = auto()
    WIDE_CHARACTER = auto()
    ENUMERATOR = auto()
    FLAGS = auto()
    BITS = auto()
    UNIT = auto()
    QUAD = auto()
    FIXED = auto()


class Text(Enum):
    """The Python representation of a run of octets."""

    OCTETS = auto()
    CHARACTERS = auto()
    STRING = auto()
    WIDE_STRING = auto()
    UNITS = auto()


@dataclass(frozen=True, slots=True)
class Atom:
    """A value of fixed size: its `struct` code, its size and alignment in octets.

    `type` describes the enum, bitmask or bitset; `digits` and `scale` are those of a fixed-point
    type (`digits` is the number of bits of a bitmask).
    """

    code: str
    size: int
    align: int
    form: Form = Form.NUMBER
    type: Any = None
    digits: int = 0
    scale: int = 0


COUNT = Atom("I", 4, 4)
"""The count before a sequence or string."""


@dataclass(frozen=True, slots=True)
class AtomArray:
    """An array of atoms that `struct` can repeat; dimensions outermost first."""

    atom: Atom
    dimensions: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class TextArray:
    """An array of octets or characters of that length."""

    text: Text
    length: int


@dataclass(frozen=True, slots=True)
class AtomSequence:
    """A sequence of atoms that `struct` can repeat."""

    atom: Atom
    bound: int | None


@dataclass(frozen=True, slots=True)
class TextSequence:
    """A count of octets, then the octets.

    `bound` is in octets (of UTF-8), for a wide string in UTF-16 units, as omniORB counts.
    """

    text: Text
    bound: int | None

    @property
    def most(self) -> int | None:
        """The largest count: a string's NUL and a wide string's byte-order mark included."""
        if self.bound is None:
            return None
        extra = {
            Text.STRING: self.bound + 1,
            Text.WIDE_STRING: 2 * self.bound + 2,
            Text.UNITS: 2 * self.bound,
        }
        return extra.get(self.text, self.bound)


@dataclass(frozen=True, slots=True)
class Records:
    """A sequence (or an array, with its length) of elements of one size and no gap between them.

    `format` is the `struct` format of an element, `size` its size, a multiple of `align`.
    """

    element: Node
    fields: tuple[Field, ...]
    format: str
    size: int
    align: int
    bound: int | None = None
    length: int | None = None


@dataclass(frozen=True, slots=True)
class Repeat:
    """A sequence (or an array, with its length) of elements of varying size.

    `minimum` is the least size of an element in octets; `key` is that of a map.
    """

    element: Node
    minimum: int
    bound: int | None = None
    length: int | None = None
    key: Node | None = None


@dataclass(frozen=True, slots=True)
class Group:
    """A struct whose members are laid out in place: (attribute, node) in order."""

    type: Any
    members: tuple[tuple[str, Node], ...]


@dataclass(frozen=True, slots=True)
class Call:
    """A value with a codec of its own: a union, a recursive struct, a large one."""

    type: Any
    minimum: int


@dataclass(frozen=True, slots=True)
class Reference:
    """An object reference (IOR: type id, profiles)."""


@dataclass(frozen=True, slots=True)
class Dynamic:
    """A value marshalled by interpreting its descriptor: `any`, a type code, a value."""

    type: Any
    minimum: int = 4


@dataclass(frozen=True, slots=True)
class Delimited:
    """A value after its length in octets (DHEADER; DDS-XTypes 1.3, 7.4.3.4.2)."""

    node: Node


@dataclass(frozen=True, slots=True)
class Optional:
    """A value, or None, after an octet that is its presence flag (DDS-XTypes 1.3, 7.4.3.4.1)."""

    node: Node


Node: TypeAlias = (
    Atom
    | AtomArray
    | TextArray
    | AtomSequence
    | TextSequence
    | Records
    | Repeat
    | Group
    | Call
    | Reference
    | Dynamic
    | Delimited
    | Optional
)

Path: TypeAlias = tuple[str, ...]
"""Member names from the root value to a value inside it."""

Placed: TypeAlias = Atom | AtomArray | TextArray | AtomSequence | TextSequence | Records


@dataclass(frozen=True, slots=True)
class Field:
    """A value in a run; of a `Repeat` only the count lies in the run."""

    path: Path
    node: Placed | Repeat


@dataclass(frozen=True, slots=True)
class Entry:
    """The meaning of one item of `struct`: a field, or its count.

    `star`: as many values as the field has items.
    """

    field: Field
    count: bool = False
    star: bool = False


@dataclass(frozen=True, slots=True)
class Section:
    """Values that one `struct` call reads, once the count before them is known.

    `text` is in the runtime's notation: `=` and a format with settled padding; or tokens such as
    `I`, `3d`, `*i` (as many as the count says), `*48s/8` (48 octets each, aligned to 8), with
    `@4` before them where the offset modulo 8 is known to be 4. `size` is that of a settled one.
    """

    text: str
    entries: tuple[Entry, ...]
    counted: Field | None
    settled: bool
    known: bool
    size: int


@dataclass(frozen=True, slots=True)
class Run:
    """Fields that one `struct` call writes, and the sections in which they are read.

    `known`: the start offset is known modulo the run's alignment.
    """

    fields: tuple[Field, ...]
    sections: tuple[Section, ...]
    known: bool


@dataclass(frozen=True, slots=True)
class Loop:
    """One pass of the inner steps for each element of `path`; its count was in the run before."""

    path: Path
    node: Repeat
    steps: tuple[Step, ...]
    key_steps: tuple[Step, ...] = ()


@dataclass(frozen=True, slots=True)
class Jump:
    """A value written and read by its own codec."""

    path: Path
    node: Call | Reference | Dynamic


@dataclass(frozen=True, slots=True)
class Frame:
    """The steps of a value that is delimited or optional."""

    path: Path
    node: Delimited | Optional
    steps: tuple[Step, ...]


Step: TypeAlias = Run | Loop | Jump | Frame


@dataclass(frozen=True, slots=True)
class Position:
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
        """After any number of items, including none (then without padding)."""
        start = self.aligned(align)
        modulus = gcd(
            self.modulus, start.modulus, size, start.remainder - self.remainder
        )
        return Position(modulus, self.remainder % modulus)


ORIGIN = Position(8, 0)
"""The start of a body."""

ANYWHERE = Position(1, 0)
"""Inside a body, after a value of varying size."""


_ALIGNED = Position(4, 0)
"""After a length."""


def steps_of(node: Node, start: Position) -> tuple[Step, ...]:
    """The layout of a value that begins at `start`."""
    return _Arrangement(start).steps(node)


def fields_of(node: Node, path: Path = ()) -> list[Field | Loop | Jump | Frame]:
    """The tree in wire order, structs flattened; a loop or jump follows its count."""
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
        case Delimited() | Optional():
            return [Frame(path, node, ())]
        case _:
            return [Field(path, node)]


def fixed_format(fields: tuple[Field, ...]) -> tuple[str, int, int, bool]:
    """(format, size, alignment, without gaps when repeated) of atoms and arrays from offset 0."""
    text, offset, most = "", 0, 1
    aligns = []
    for field in fields:
        token, size, align = _token(field.node)
        padding = -offset % align
        text += pad(padding) + token.partition("/")[0]
        offset += padding + size
        most = max(most, align)
        aligns.append(align)
    gapless = bool(aligns) and aligns[0] == most and offset % most == 0
    return text, offset, most, gapless


def minimum_size(node: Node) -> int:
    """The minimum number of octets of a value, without padding."""
    match node:
        case Atom(size=size):
            return size
        case AtomArray(atom=atom, dimensions=dimensions):
            return atom.size * prod(dimensions)
        case TextArray(length=length):
            return length
        case AtomSequence() | TextSequence():
            return 4
        case Records(length=length, size=size):
            return 4 if length is None else length * size
        case Repeat(length=length, minimum=minimum):
            return 4 if length is None else length * minimum
        case Group(members=members):
            return sum(minimum_size(inner) for _, inner in members)
        case Call(minimum=minimum) | Dynamic(minimum=minimum):
            return minimum
        case Reference():
            return 8
        case Delimited(node=inner):
            return 4 + minimum_size(inner)
        case Optional():
            return 1


def _token(node: Placed | Repeat) -> tuple[str, int, int]:
    """(token, size, alignment) of a value without a count."""
    match node:
        case Atom(size=size, align=align):
            return _aligned(node), size, align
        case AtomArray(atom=atom, dimensions=dimensions):
            number = prod(dimensions)
            return f"{number}{_aligned(atom)}", number * atom.size, atom.align
        case TextArray(length=length):
            return f"{length}s", length, 1
        case Records(length=int(length), size=size, align=align):
            return f"{length * size}s/{align}", length * size, align
    raise TypeError(node)


def _aligned(atom: Atom) -> str:
    """The code of an atom, with its alignment if that is not its size."""
    usual = atom.align in (1, atom.size)
    return atom.code if usual else f"{atom.code}/{atom.align}"


def _counted_token(node: Placed) -> tuple[str, int, int]:
    """(token, size of an item, alignment) of the items after a count."""
    match node:
        case AtomSequence(atom=atom):
            return f"*{_aligned(atom)}", atom.size, atom.align
        case TextSequence():
            return "*s", 1, 1
        case Records(size=size, align=align):
            return f"*{size}s/{align}", size, align
    raise TypeError(node)


class _Arrangement:
    """Lays a tree out while tracking the known part of the offset."""

    def __init__(self, start: Position) -> None:
        self._position = start
        self._steps: list[Step] = []
        self._begin_run()

    def steps(self, node: Node) -> tuple[Step, ...]:
        for item in fields_of(node):
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
                case Frame(path=path, node=frame):
                    self._end_run()
                    start = _ALIGNED if isinstance(frame, Delimited) else ANYWHERE
                    steps = steps_of(frame.node, start)
                    self._steps.append(Frame(path, frame, steps))
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
        known = sections[0].start.modulus % most == 0
        self._steps.append(
            Run(tuple(self._fields), tuple(s.finished(known) for s in sections), known)
        )

    def _place(self, field: Field) -> None:
        self._fields.append(field)
        node = field.node
        section = self._sections[-1]
        if not has_count(node):
            star = isinstance(node, AtomArray)
            if star and any(entry.star for entry in section.entries):
                section = _Section(self._position)
                self._sections.append(section)
            self._position = section.add(
                *_token(node), Entry(field, star=star), self._position
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
        """Appends a value of known size; returns the position after it."""
        padding = -before.remainder % align if before.modulus % align == 0 else 0
        self._format += pad(padding) + token.partition("/")[0]
        self._size += padding + size
        self.tokens.append(token)
        self.entries.append(entry)
        self.most = max(self.most, align)
        return before.aligned(align).after(size)

    def finished(self, run_known: bool) -> Section:
        known = self.start.modulus % self.most == 0
        settled = run_known and known and self.counted is None
        text = " ".join(self.tokens)
        if settled:
            text = f"={self._format}"
        elif known:
            text = f"@{self.start.remainder} {text}"
        return Section(
            text, tuple(self.entries), self.counted, settled, known, self._size
        )


def pad(octets: int) -> str:
    """Padding in a `struct` format."""
    return "x" * octets if octets < 3 else f"{octets}x"


def has_count(node: Placed | Repeat) -> bool:
    """Whether a count precedes the node on the wire."""
    match node:
        case AtomSequence() | TextSequence():
            return True
        case Records(length=length) | Repeat(length=length):
            return length is None
    return False
