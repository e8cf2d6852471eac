"""The members of a struct, at any depth, with the units that their definitions state."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from rtgen.facts.primitives import FLOAT_LIMITS
from rtgen.model import (
    ArrayType,
    Member,
    Model,
    NamedType,
    PrimitiveType,
    SequenceType,
    Struct,
    Type,
)

_BRACKETS: Final = re.compile(r"\[([^,\]]+)\]")


class Leaf(NamedTuple):
    """A member that is not a struct; `unit` is None if its definition states none."""

    path: tuple[str, ...]
    type: Type
    unit: str | None


def unit_of(member: Member) -> str | None:
    """Return a member's unit: that of `@unit`, or the only one in its comment."""
    annotation = member.annotation("unit")
    if annotation is not None:
        return str(dict(annotation.arguments)["value"])
    units = _BRACKETS.findall(member.doc)
    return units[0] if len(units) == 1 else None


def leaves(model: Model, struct: Struct, path: tuple[str, ...] = ()) -> Iterator[Leaf]:
    """Yield the members of a struct and of the structs in it, inherited ones first."""
    if struct.base is not None and isinstance(base := model.find(struct.base), Struct):
        yield from leaves(model, base, path)
    for member in struct.members:
        type_ = model.unalias(member.type)
        inner = model.find(type_.name) if isinstance(type_, NamedType) else None
        if isinstance(inner, Struct):
            yield from leaves(model, inner, (*path, member.name))
        else:
            yield Leaf((*path, member.name), type_, unit_of(member))


def is_real(model: Model, type_: Type) -> bool:
    """Return whether it is a real number, or a sequence or array of real numbers."""
    if isinstance(type_, SequenceType | ArrayType):
        type_ = model.unalias(type_.element)
    return isinstance(type_, PrimitiveType) and type_.kind in FLOAT_LIMITS
