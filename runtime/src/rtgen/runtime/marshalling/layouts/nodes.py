"""The tree of a type on the wire, made by `trees` from a descriptor and arranged by `layout`."""

from __future__ import annotations

from enum import Enum, auto
from math import prod
from typing import Any, TypeAlias

import msgspec

from rtgen.runtime.marshalling.numeric import Numeric


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
    WORD = auto()
    QUAD = auto()
    FIXED = auto()


class Text(Enum):
    """The Python representation of a run of octets."""

    OCTETS = auto()
    CHARACTERS = auto()
    STRING = auto()
    WIDE_STRING = auto()
    UNITS = auto()


class Atom(msgspec.Struct, frozen=True):
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


class AtomArray(msgspec.Struct, frozen=True):
    """An array of atoms that `struct` can repeat; dimensions outermost first.

    In another `form` than a list, it is one value of octets for `struct`.
    """

    atom: Atom
    dimensions: tuple[int, ...]
    form: Numeric = "list"


class TextArray(msgspec.Struct, frozen=True):
    """An array of octets or characters of that length."""

    text: Text
    length: int


class AtomSequence(msgspec.Struct, frozen=True):
    """A sequence of atoms that `struct` can repeat."""

    atom: Atom
    bound: int | None
    form: Numeric = "list"


class TextSequence(msgspec.Struct, frozen=True):
    """A count of octets, then the octets.

    `bound` is in octets (of UTF-8), for a wide string in UTF-16 units, as omniORB counts.
    """

    text: Text
    bound: int | None

    @property
    def most(self) -> int | None:
        """Maximum count, including a string's NUL and a wide string's byte-order mark."""
        if self.bound is None:
            return None
        extra = {
            Text.STRING: self.bound + 1,
            Text.WIDE_STRING: 2 * self.bound + 2,
            Text.UNITS: 2 * self.bound,
        }
        return extra.get(self.text, self.bound)


class Records(msgspec.Struct, frozen=True):
    """A sequence, or array with a length, of elements of one size.

    `format` is the `struct` format of an element with the padding before the next one, `stride` the
    size of both, a multiple of `align`. There is no padding after the last element.
    """

    element: Node
    fields: tuple[Field, ...]
    format: str
    stride: int
    padding: int
    align: int
    bound: int | None = None
    length: int | None = None
    form: Numeric = "list"

    @property
    def size(self) -> int:
        """The size of an element."""
        return self.stride - self.padding

    def octets(self, count: int) -> int:
        """Return the size of a number of elements."""
        return count * self.stride - self.padding if count else 0


class Repeat(msgspec.Struct, frozen=True):
    """A sequence, or array with a length, of elements of varying size.

    `minimum` is the minimum size of an element in octets; `key` is a map's key.
    """

    element: Node
    minimum: int
    bound: int | None = None
    length: int | None = None
    key: Node | None = None


class Group(msgspec.Struct, frozen=True):
    """A struct whose members are arranged in place: (attribute, node) in order."""

    type: Any
    members: tuple[tuple[str, Node], ...]


class Call(msgspec.Struct, frozen=True):
    """A value with a codec of its own: a union, a recursive struct, a large one."""

    type: Any
    minimum: int


class Reference(msgspec.Struct, frozen=True, gc=False):
    """An object reference (IOR: type id, profiles)."""


class Dynamic(msgspec.Struct, frozen=True):
    """A value marshalled by interpreting its descriptor: `any`, a type code, a value."""

    type: Any
    minimum: int = 4


class Delimited(msgspec.Struct, frozen=True):
    """A value after its length in octets (DHEADER; DDS-XTypes 1.3, 7.4.3.4.2)."""

    node: Node


class Optional(msgspec.Struct, frozen=True):
    """A value or None, after a presence flag of one octet (DDS-XTypes 1.3, 7.4.3.4.1)."""

    node: Node


class Header(msgspec.Struct, frozen=True, gc=False):
    """A constant 32-bit number: part of an EMHEADER."""

    number: int


class Member(msgspec.Struct, frozen=True):
    """A member of a mutable type in XCDR2, after an EMHEADER (DDS-XTypes 1.3, 7.4.3.4.2).

    An `optional` one is omitted if it is None; a `key` must be present.
    """

    node: Node
    id: int
    must_understand: bool = False
    optional: bool = False
    key: bool = False

    @property
    def length_code(self) -> int:
        """Form of the length: in the code itself, after it, or as the count of the value."""
        match self.node:
            case Atom(size=size):
                return {1: 0, 2: 1, 4: 2, 8: 3}.get(size, 4)
            case AtomSequence(atom=atom):
                return {1: 5, 4: 6, 8: 7}.get(atom.size, 4)
            case TextSequence():
                return 5
            case Delimited(node=inner):
                return 4 if isinstance(inner, Repeat) and inner.key else 5
        return 4

    @property
    def header(self) -> int:
        """The EMHEADER."""
        return self.must_understand << 31 | self.length_code << 28 | self.id


class Parameter(msgspec.Struct, frozen=True):
    """A member of a mutable type in XCDR1, or an optional one of another type (7.4.1.2).

    Alignment is relative to the value. `in_list`: in a mutable type, where values are padded to 4
    octets as in Cyclone DDS 11, and an `optional` one is omitted if it is None.
    """

    node: Node
    id: int
    must_understand: bool = False
    optional: bool = False
    key: bool = False
    in_list: bool = True


class MemberList(msgspec.Struct, frozen=True):
    """A mutable struct: (attribute, member) in the order of the definition, read in any order."""

    type: Any
    members: tuple[tuple[str, Member | Parameter], ...]


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
    | Header
    | Member
    | Parameter
    | MemberList
)


Path: TypeAlias = tuple[str, ...]
"""Member names from the root value to a nested value."""

Placed: TypeAlias = (
    Atom | AtomArray | TextArray | AtomSequence | TextSequence | Records | Header
)


class Field(msgspec.Struct, frozen=True):
    """A value in a run; of a `Repeat`, only the count is in the run."""

    path: Path
    node: Placed | Repeat


def minimum_size(node: Node) -> int:
    """Return the minimum number of octets of a value, without padding."""
    match node:
        case Atom(size=size):
            return size
        case AtomArray(atom=atom, dimensions=dimensions):
            return atom.size * prod(dimensions)
        case TextArray(length=length):
            return length
        case AtomSequence() | TextSequence():
            return 4
        case Records(length=length):
            return 4 if length is None else node.octets(length)
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
        case Header() | Member() | Parameter():
            return 4
        case MemberList():
            return 0
