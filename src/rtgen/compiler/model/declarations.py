"""Resolved declarations of definition files, with their places."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from enum import StrEnum
from typing import TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.types import ScopedName, Type

OPAQUE = "opaque"
"""The annotation of a struct or interface of which only the name is known."""


class EnumeratorName(msgspec.Struct, frozen=True):
    """The value of an enumerated constant or label."""

    name: ScopedName


ConstantValue: TypeAlias = bool | int | float | str | Decimal | EnumeratorName
"""The value of a constant expression; its Python type depends on the constant's type."""

InitialValue: TypeAlias = ConstantValue | tuple[ConstantValue, ...]
"""The value of `@default`: of a sequence or array its items, those of all dimensions in a row.

That of a bitmask is a number.
"""


class Annotation(msgspec.Struct, frozen=True):
    """`@name(arguments)`; a single unnamed argument has the name `value`."""

    name: str
    arguments: tuple[tuple[str, ConstantValue], ...] = ()

    def get(self, key: str = "value") -> ConstantValue | None:
        """Return the argument of that name, or None."""
        return dict(self.arguments).get(key)


Limits: TypeAlias = tuple[ConstantValue | None, ConstantValue | None]
"""The minimum and the maximum of a value, None for none."""


def limits(annotations: Iterable[Annotation]) -> Limits:
    """Return the limits that `@min`, `@max` and `@range` state; the first of each end counts."""
    annotations = tuple(annotations)
    low, high = (
        next(
            (
                value
                for each in annotations
                if (key := {end: "value", "range": end}.get(each.name)) is not None
                and (value := each.get(key)) is not None
            ),
            None,
        )
        for end in ("min", "max")
    )
    return low, high


class Documented(msgspec.Struct, frozen=True, kw_only=True):
    """Attributes common to declarations and members: place, doc comment and annotations."""

    span: Span
    doc: str = ""
    annotations: tuple[Annotation, ...] = ()

    def annotation(self, name: str) -> Annotation | None:
        """Return the first annotation of that name, or None."""
        return next((a for a in self.annotations if a.name == name), None)


class Declaration(Documented, frozen=True, kw_only=True):
    """A named declaration. `span` is the place of its name; `file` is the file that contains it."""

    name: ScopedName
    repository_id: str
    file: str

    @property
    def scoped(self) -> str:
        """The name as IDL writes it, without a leading `::`."""
        return "::".join(self.name)


class Member(Documented, frozen=True, kw_only=True):
    """A field of a struct or exception; see `model.initial` for the value it starts with.

    `id` is its member id if the definition gives one, as a number or as a hash of a name; None is
    the id after that of the previous member (DDS-XTypes 1.3, 7.3.1.2.1).
    """

    name: str
    type: Type
    optional: bool = False
    key: bool = False
    id: int | None = None
    must_understand: bool = False
    external: bool = False
    initial: InitialValue | None = None


class Extensibility(StrEnum):
    """Extensibility of a type between versions (DDS-XTypes 1.3, 7.2.2.4.3)."""

    FINAL = "final"
    APPENDABLE = "appendable"
    MUTABLE = "mutable"


class Struct(Declaration, frozen=True, kw_only=True):
    """A struct; `base` as in IDL 4.2's struct inheritance. `members` excludes inherited ones."""

    members: tuple[Member, ...]
    base: ScopedName | None = None
    extensibility: Extensibility = Extensibility.FINAL
    nested: bool = False


class ExceptionDecl(Declaration, frozen=True, kw_only=True):
    """A user exception."""

    members: tuple[Member, ...]


class Case(Documented, frozen=True, kw_only=True):
    """A branch of a union. `labels` are of the switch type; `default` may be given in addition."""

    labels: tuple[ConstantValue, ...]
    default: bool
    name: str
    type: Type
    id: int | None = None
    external: bool = False
    initial: InitialValue | None = None


class Union(Declaration, frozen=True, kw_only=True):
    """A discriminated union."""

    switch: Type
    cases: tuple[Case, ...]
    extensibility: Extensibility = Extensibility.FINAL
    nested: bool = False


class Enumerator(Documented, frozen=True, kw_only=True):
    """A member of an enum or bitmask with its number (bit position for a bitmask)."""

    name: str
    value: int


class Enum(Declaration, frozen=True, kw_only=True):
    """An enum; its enumerators belong to the enclosing scope. `bound` is in bits."""

    members: tuple[Enumerator, ...]
    bound: int = 32

    @property
    def initial(self) -> Enumerator:
        """The enumerator with which values start: that of `@default_literal`, else the first."""
        marked = (m for m in self.members if m.annotation("default_literal"))
        return next(marked, self.members[0])


class Bitfield(Documented, frozen=True, kw_only=True):
    """A field of a bitset: `bits` wide, `type` when one was written; unnamed ones are padding."""

    name: str | None
    bits: int
    type: Type | None
    initial: InitialValue | None = None


class Bitset(Declaration, frozen=True, kw_only=True):
    """A bitset (IDL 4.2)."""

    members: tuple[Bitfield, ...]
    base: ScopedName | None = None


class Bitmask(Declaration, frozen=True, kw_only=True):
    """A bitmask (IDL 4.2)."""

    members: tuple[Enumerator, ...]
    bound: int = 32


class Typedef(Declaration, frozen=True, kw_only=True):
    """One declarator of a typedef; `initial` is the value with which members of it start."""

    type: Type
    initial: InitialValue | None = None


class Const(Declaration, frozen=True, kw_only=True):
    """A constant, evaluated."""

    type: Type
    value: ConstantValue


class Native(Declaration, frozen=True, kw_only=True):
    """A native type: a name without marshalling."""


class Direction(StrEnum):
    """How a parameter is passed."""

    IN = "in"
    OUT = "out"
    INOUT = "inout"


class Parameter(Documented, frozen=True, kw_only=True):
    """A parameter of an operation."""

    direction: Direction
    name: str
    type: Type


class Operation(Documented, frozen=True, kw_only=True):
    """An operation of an interface."""

    name: str
    returns: Type
    parameters: tuple[Parameter, ...] = ()
    raises: tuple[ScopedName, ...] = ()
    oneway: bool = False
    context: tuple[str, ...] = ()
    repository_id: str = ""

    @property
    def shape(self) -> tuple[object, ...]:
        """What its signature consists of; operations of equal shape have equal bodies."""
        parts = ((each.name, each.type, each.direction) for each in self.parameters)
        return self.returns, bool(self.context), *parts

    @property
    def arguments(self) -> list[Parameter]:
        """The parameters that a caller passes: `in` and `inout`."""
        return [p for p in self.parameters if p.direction is not Direction.OUT]

    @property
    def results(self) -> list[Parameter]:
        """The parameters that a caller gets: `inout` and `out`."""
        return [p for p in self.parameters if p.direction is not Direction.IN]


class Attribute(Documented, frozen=True, kw_only=True):
    """An attribute of an interface or component."""

    name: str
    type: Type
    readonly: bool = False
    get_raises: tuple[ScopedName, ...] = ()
    set_raises: tuple[ScopedName, ...] = ()
    repository_id: str = ""


class Interface(Declaration, frozen=True, kw_only=True):
    """An interface. Operations and attributes exclude inherited ones, each in source order.

    `forward`: the interface is only declared, and not defined in any file that was read.
    """

    bases: tuple[ScopedName, ...] = ()
    abstract: bool = False
    local: bool = False
    forward: bool = False
    attributes: tuple[Attribute, ...] = ()
    operations: tuple[Operation, ...] = ()


class StateMember(Member, frozen=True, kw_only=True):
    """A state member of a valuetype."""

    public: bool


class Valuetype(Declaration, frozen=True, kw_only=True):
    """A valuetype; `eventtype` marks the CORBA 3 form, `forward` is as for interfaces."""

    bases: tuple[ScopedName, ...] = ()
    supports: tuple[ScopedName, ...] = ()
    abstract: bool = False
    forward: bool = False
    custom: bool = False
    truncatable: bool = False
    eventtype: bool = False
    attributes: tuple[Attribute, ...] = ()
    operations: tuple[Operation, ...] = ()
    state: tuple[StateMember, ...] = ()
    factories: tuple[Operation, ...] = ()


class ValueBox(Declaration, frozen=True, kw_only=True):
    """A boxed value: `valuetype Name T;`."""

    type: Type


class Home(Declaration, frozen=True, kw_only=True):
    """A component home; parsed, but not generated from."""

    manages: ScopedName | None = None
