"""Layout of TECS OpaqueRPC messages: values in wire order, and dependencies of sizes.

A message is a tuple of steps. A `Run` is a sequence of values whose size is fixed once the TDR is
known; between the runs are values whose size depends on earlier ones. Expressions are those of the
definition.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import Enum, auto
from functools import cached_property
from typing import TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.c_types import (
    AggregateExpression,
    BinaryExpression,
    CastExpression,
    ConditionalExpression,
    Expression,
    Reference,
    UnaryExpression,
)
from rtgen.compiler.model.tecs import Signature, TecsDirection, TecsFunction, TecsStruct
from rtgen.facts.tdr import LETTERS, Scalar

OCTETS = (Scalar.CHAR, Scalar.SCHAR, Scalar.UCHAR, Scalar.UINT8)
"""The types whose arrays are octets."""


class TransferError(Exception):
    """A parameter, member or return value that OpaqueRPC cannot transfer; `hint` is optional."""

    def __init__(self, span: Span, reason: str, hint: str | None = None) -> None:
        super().__init__(reason)
        self.span = span
        self.reason = reason
        self.hint = hint


class Nothing(msgspec.Struct, frozen=True):
    """`void`, or a pointer to it, which takes no bytes."""


class Basic(msgspec.Struct, frozen=True):
    """A number or boolean."""

    scalar: Scalar

    @property
    def kind(self) -> str:
        """The letter of the type."""
        return LETTERS[self.scalar]


class Octets(msgspec.Struct, frozen=True):
    """A fixed array of octets or characters."""

    scalar: Scalar
    count: int


class FixedArray(msgspec.Struct, frozen=True):
    """A fixed array of other elements."""

    element: Node
    count: int


class Record(msgspec.Struct, frozen=True):
    """A struct; `items` in order of declaration, `steps` in wire order."""

    struct: TecsStruct
    items: tuple[Item, ...]
    steps: tuple[Step, ...]

    @property
    def fixed(self) -> bool:
        """Whether the size of the struct is independent of values."""
        return all(isinstance(step, Run) for step in self.steps)


class Counted(msgspec.Struct, frozen=True):
    """A pointer to an array: `count` elements are transferred, `size` fit; `most` bounds `size`."""

    element: Node
    size: Expression
    count: Expression
    most: int | None

    @property
    def scalar(self) -> Scalar | None:
        """The type of the elements if they are numbers or booleans."""
        return self.element.scalar if isinstance(self.element, Basic) else None

    @property
    def is_octets(self) -> bool:
        """Whether the array is one of octets or characters."""
        return self.scalar in OCTETS


class String(msgspec.Struct, frozen=True):
    """A string; `length` is the size of its buffer."""

    scalar: Scalar
    length: Expression | None

    @property
    def kind(self) -> str:
        """The letter of a unit."""
        return LETTERS[self.scalar]

    @property
    def is_wide(self) -> bool:
        """Whether a unit is larger than a byte."""
        return self.kind not in "bB"


Node: TypeAlias = Nothing | Basic | Octets | FixedArray | Record | Counted | String


class Item(msgspec.Struct, frozen=True):
    """A parameter, a member, or the return value (with an empty name).

    `pointer`: the value is the target of a pointer without sizes.
    """

    name: str
    node: Node
    span: Span
    pointer: bool = False
    nullable: bool = False
    direction: TecsDirection | None = None

    @property
    def inward(self) -> bool:
        """Whether the request contains the value."""
        return self.direction is not None and self.direction.inward

    @property
    def outward(self) -> bool:
        """Whether the reply contains the value."""
        return self.direction is not None and self.direction.outward

    @property
    def asked(self) -> bool:
        """Whether the request has a flag that says whether the caller wants the value."""
        return self.nullable and self.direction is TecsDirection.OUT


class Role(Enum):
    """The role of a field of a run."""

    SOP = auto()
    ID = auto()
    EOP = auto()
    FLAG = auto()
    LENGTH = auto()
    VALUE = auto()


class Field(msgspec.Struct, frozen=True):
    """A part of a run; `item` is that of a flag, a length or a value."""

    role: Role
    item: Item | None = None

    @property
    def kinds(self) -> tuple[tuple[str, int], ...]:
        """Letters with their repeat counts."""
        match self.role:
            case Role.SOP | Role.ID | Role.EOP:
                return (("H", 1),)
            case Role.FLAG:
                return (("b", 1),)
            case Role.LENGTH:
                return (("i", 1),)
        assert self.item is not None
        return kinds(self.item.node)


class Run(msgspec.Struct, frozen=True):
    """Fields of fixed size, one after the other."""

    fields: tuple[Field, ...]

    @property
    def kinds(self) -> tuple[tuple[str, int], ...]:
        """Letters with their repeat counts."""
        return tuple(kind for field in self.fields for kind in field.kinds)


class Payload(msgspec.Struct, frozen=True):
    """The elements of a `Counted` whose elements have a fixed size, or the units of a `String`."""

    item: Item


class Part(msgspec.Struct, frozen=True):
    """A compound value with parts whose sizes depend on values."""

    item: Item


class Branch(msgspec.Struct, frozen=True):
    """Steps that are only present if the item is not NULL."""

    item: Item
    steps: tuple[Step, ...]


class Reserve(msgspec.Struct, frozen=True):
    """No bytes: allocates the server's memory for an outward array or string."""

    item: Item


Step: TypeAlias = Run | Payload | Part | Branch | Reserve


class FunctionLayout(msgspec.Struct, dict=True, frozen=True):
    """A function. `reply` is None if it is oneway; `paper` is the reply with the outs first.

    `kept` are the parameters on whose request values the reply depends. `leaves_out`: after an
    `E_RPC` the reply has no outs.
    """

    function: TecsFunction
    items: tuple[Item, ...]
    returned: Item
    request: tuple[Step, ...]
    reply: tuple[Step, ...] | None
    paper: tuple[Step, ...] | None
    kept: tuple[Item, ...]
    leaves_out: bool

    @cached_property
    def arguments(self) -> tuple[Item, ...]:
        """The items of which the request has the value or a flag."""
        return tuple(i for i in self.items if i.inward or i.asked)

    @cached_property
    def outs(self) -> tuple[Item, ...]:
        """The items whose values are in the reply."""
        return tuple(i for i in self.items if i.outward)

    @property
    def is_void(self) -> bool:
        """Whether the function returns `void`."""
        return isinstance(self.returned.node, Nothing)


class SignatureLayout(msgspec.Struct, frozen=True):
    """A signature; `records` are the structs that it uses, contained ones first."""

    signature: Signature
    functions: tuple[FunctionLayout, ...]
    records: tuple[Record, ...]


def kinds(node: Node) -> tuple[tuple[str, int], ...]:
    """Return the letters of a node of fixed size with their repeat counts."""
    match node:
        case Basic():
            return (("16s" if node.kind in "wW" else node.kind, 1),)
        case Octets(count=count):
            return ((f"{count}s", 1),)
        case FixedArray(Basic() as basic, count) if basic.kind not in "wW":
            return ((f"{count}{basic.kind}", 1),)
        case FixedArray(element, count):
            inner = kinds(element)
            if len(inner) == 1 and inner[0][1] == 1:
                return ((inner[0][0], count),)
            return (("".join(text * times for text, times in inner), count),)
        case Record():
            fields = (f for s in node.steps if isinstance(s, Run) for f in s.fields)
            return tuple(kind for field in fields for kind in field.kinds)
        case Nothing():
            return ()
    raise AssertionError(node)


def is_fixed(node: Node) -> bool:
    """Return whether the size of a value depends on no other value."""
    match node:
        case Record():
            return node.fixed
        case FixedArray(element):
            return is_fixed(element)
        case Counted() | String():
            return False
    return True


def size_of(node: Node) -> int | None:
    """Return the octets of a value in TDR `network`; None if they depend on other values."""
    match node:
        case Basic():
            return _SIZES[node.kind]
        case Octets(_, count):
            return count
        case FixedArray(element, count):
            inner = size_of(element)
            return None if inner is None else inner * count
        case Record():
            sizes = [size_of(item.node) for item in node.items]
            return None if None in sizes else sum(s for s in sizes if s is not None)
        case Counted() | String():
            return None
    return 0


_SIZES = {
    letter: size
    for letters, size in (
        ("?bB", 1),
        ("hHkK", 2),
        ("iInNlLpPf", 4),
        ("qQd", 8),
        ("wW", 16),
    )
    for letter in letters
}
"""Sizes of letters in octets with TDR `network`: short 16 bits; int, long and intptr_t 32."""


def references(expression: Expression | None) -> Iterator[str]:
    """Yield the parameters or members in an expression, except members of a struct's value."""
    match expression:
        case Reference(name):
            yield name
        case UnaryExpression(_, operand) | CastExpression(_, operand):
            yield from references(operand)
        case BinaryExpression(operator, left, right):
            yield from references(left)
            if operator != ".":
                yield from references(right)
        case ConditionalExpression(condition, yes, no):
            for part in (condition, yes, no):
                yield from references(part)
        case AggregateExpression(items):
            for part in items:
                yield from references(part)


def sizes_of(node: Node) -> tuple[Expression, ...]:
    """Return the expressions on which a value's layout depends, `size` before `count`."""
    match node:
        case Counted(element, size, count):
            own = (size,) if count is size else (size, count)
            return own + sizes_of(element)
        case String(length=length) if length is not None:
            return (length,)
    return ()


def capacity(node: Node) -> Expression | None:
    """Return the expression for the number of elements or units that the caller can hold."""
    match node:
        case Counted(size=size):
            return size
        case String(length=length):
            return length
    return None


def is_known(node: Node, items: Iterable[Item]) -> bool:
    """Return whether the capacity can be computed from the values of these items."""
    names = {item.name for item in items}
    return all(name in names for name in references(capacity(node)))
