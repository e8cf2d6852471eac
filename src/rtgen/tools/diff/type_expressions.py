"""Compares type expressions: whether old values are read as equal by the new type."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Declaration,
    Enum,
    ExceptionDecl,
    FixedType,
    Interface,
    MapType,
    Model,
    NamedType,
    Native,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
)
from rtgen.tools.diff.changes import Kind, Wire
from rtgen.tools.diff.kinds import types as kinds

Pair: TypeAlias = tuple[ScopedName, ScopedName]
"""A declaration of the old version, and the one of the new version compared with it."""

ENCODINGS = frozenset((Wire.CDR, Wire.XCDR1, Wire.XCDR2))
NO_WIRES: frozenset[Wire] = frozenset()

COMPOSITE = (Struct, Union, ExceptionDecl, Enum, Bitmask, Bitset)
"""Declarations that are compared part by part."""

_OCTETS = frozenset((Primitive.OCTET, Primitive.UINT8))


@dataclass(frozen=True, slots=True)
class Verdict:
    """How a type expression changed; `kind` is None if it did not.

    `wires`: encodings that break by the expression itself. `pair` are the declarations that it
    refers to, compared separately; `replaced`: it refers to another declaration than before.
    """

    kind: Kind | None = None
    wires: frozenset[Wire] = NO_WIRES
    pairs: frozenset[Pair] = frozenset()
    replaced: Pair | None = None

    @property
    def keeps_octets(self) -> bool:
        """Whether the expression itself breaks nothing: at most names in it changed."""
        return not self.wires


_SAME = Verdict()
_OTHER = Verdict(kinds.MEMBER_TYPE, ENCODINGS)


class TypeExpressions:
    """Compares the types of two models; `names` maps old declarations to matching ones."""

    def __init__(
        self, old: Model, new: Model, names: Mapping[ScopedName, ScopedName]
    ) -> None:
        self._old, self._new, self._names = old, new, names

    def compare(self, old: Type, new: Type) -> Verdict:
        """Return the verdict on two types of a member, element, parameter or port."""
        found = self._compare(self._old.unalias(old), self._new.unalias(new))
        if found.kind is None and self._written(old) != str(new):
            return Verdict(kinds.MEMBER_ALIAS, found.wires, found.pairs)
        return found

    def _written(self, type_: Type) -> str:
        """Return the old type with the names of the new version."""
        match type_:
            case NamedType(name):
                return str(NamedType(self._names.get(name, name)))
            case SequenceType(element, bound):
                end = "" if bound is None else f",{bound}"
                return f"sequence<{self._written(element)}{end}>"
            case ArrayType(element, dimensions):
                return self._written(element) + "".join(f"[{n}]" for n in dimensions)
            case MapType(key, value, bound):
                end = "" if bound is None else f",{bound}"
                return f"map<{self._written(key)},{self._written(value)}{end}>"
        return str(type_)

    def _compare(self, old: Type, new: Type) -> Verdict:
        match old, new:
            case PrimitiveType(a), PrimitiveType(b):
                return _SAME if a == b or {a, b} == _OCTETS else _OTHER
            case StringType(a_wide, a_bound), StringType(b_wide, b_bound):
                return _OTHER if a_wide != b_wide else _bounds(a_bound, b_bound)
            case SequenceType(a_element, a_bound), SequenceType(b_element, b_bound):
                return _first(
                    self._inner(a_element, b_element), _bounds(a_bound, b_bound)
                )
            case ArrayType(), ArrayType():
                a_type, a_dimensions = _flat(old, self._old)
                b_type, b_dimensions = _flat(new, self._new)
                sizes = (
                    _SAME
                    if a_dimensions == b_dimensions
                    else Verdict(kinds.DIMENSIONS, ENCODINGS)
                )
                return _first(self._inner(a_type, b_type), sizes)
            case MapType(a_key, a_value, a_bound), MapType(b_key, b_value, b_bound):
                return _first(
                    _first(self._inner(a_key, b_key), self._inner(a_value, b_value)),
                    _bounds(a_bound, b_bound),
                )
            case FixedType(), FixedType():
                return _SAME if old == new else _OTHER
            case NamedType(a_name), NamedType(b_name):
                return self._named(a_name, b_name)
        return _OTHER

    def enums(self, old: Type, new: Type) -> tuple[Enum, Enum] | None:
        """Return the enums that two types stand for, if they are some."""
        before, after = self._old.unalias(old), self._new.unalias(new)
        if not isinstance(before, NamedType) or not isinstance(after, NamedType):
            return None
        one, other = self._old.find(before.name), self._new.find(after.name)
        if isinstance(one, Enum) and isinstance(other, Enum):
            return one, other
        return None

    def _inner(self, old: Type, new: Type) -> Verdict:
        return self._compare(self._old.unalias(old), self._new.unalias(new))

    def _named(self, old: ScopedName, new: ScopedName) -> Verdict:
        before, after = self._old.find(old), self._new.find(new)
        same = self._names.get(old) == new
        if isinstance(before, COMPOSITE) and type(before) is type(after):
            pair = (old, new)
            if same:
                return Verdict(pairs=frozenset((pair,)))
            return Verdict(
                kinds.MEMBER_TYPE, NO_WIRES, frozenset((pair,)), replaced=pair
            )
        if type(before) is not type(after):
            return _OTHER
        if same:
            return _SAME
        if isinstance(before, Native):
            return Verdict(kinds.MEMBER_TYPE)  # which is never sent
        is_reference = isinstance(before, Interface)
        return Verdict(
            kinds.MEMBER_TYPE, frozenset((Wire.GIOP,)) if is_reference else ENCODINGS
        )


def _first(inner: Verdict, own: Verdict) -> Verdict:
    """Return the inner change, else the own one, with what either breaks."""
    return Verdict(
        inner.kind or own.kind,
        inner.wires | own.wires,
        inner.pairs | own.pairs,
        inner.replaced or own.replaced,
    )


def _bounds(old: int | None, new: int | None) -> Verdict:
    if old == new:
        return _SAME
    raised = new is None or (old is not None and new > old)
    kind = kinds.BOUND_RAISED if raised else kinds.BOUND_LOWERED
    return Verdict(kind, ENCODINGS)


def _flat(type_: Type, model: Model) -> tuple[Type, tuple[int, ...]]:
    """Return the innermost element of an array of arrays, and all dimensions."""
    dimensions: tuple[int, ...] = ()
    while isinstance(type_, ArrayType):
        dimensions += type_.dimensions
        type_ = model.unalias(type_.element)
    return type_, dimensions


def shape(declaration: Declaration, names: Mapping[ScopedName, ScopedName]) -> object:
    """Return all that determines a type's values, except its name; None for other kinds."""

    def written(type_: Type) -> str:
        return TypeExpressions(Model(), Model(), names)._written(type_)

    match declaration:
        case Struct():
            return (
                *("struct", declaration.extensibility, declaration.base),
                *(
                    (m.name, written(m.type), m.optional, m.key, m.id)
                    for m in declaration.members
                ),
            )
        case ExceptionDecl():
            return (
                "exception",
                *((m.name, written(m.type)) for m in declaration.members),
            )
        case Union():
            return (
                *("union", declaration.extensibility, written(declaration.switch)),
                *(
                    (c.labels, c.default, c.name, written(c.type), c.id)
                    for c in declaration.cases
                ),
            )
        case Enum() | Bitmask():
            return (
                *(type(declaration), declaration.bound),
                *((m.name, m.value) for m in declaration.members),
            )
        case Bitset():
            return ("bitset", *((m.name, m.bits) for m in declaration.members))
    return None
