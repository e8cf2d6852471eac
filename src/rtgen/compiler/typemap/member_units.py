"""Members and parameters with the units that their definitions state."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from rtgen.compiler.model import (
    ArrayType,
    Documented,
    Model,
    PrimitiveType,
    SequenceType,
    Struct,
    Type,
)
from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES

_BRACKETS: Final = re.compile(r"\[((?:[^,\[\]]|\[[^,\[\]]*\])+)\]")


class Leaf(NamedTuple):
    """A member that is not a struct; `unit` is None if its definition states none.

    `optional` says whether the member, or a struct around it, may be absent.
    """

    path: tuple[str, ...]
    type: Type
    unit: str | None
    optional: bool


def annotated_unit(entry: Documented) -> str | None:
    """Return the unit that `@unit` states for a member or parameter."""
    annotation = entry.annotation("unit")
    unit = None if annotation is None else annotation.get()
    return None if unit is None else str(unit)


def unit_of(entry: Documented) -> str | None:
    """Return the unit of a member or parameter: that of `@unit`, or the only one in its comment."""
    annotated = annotated_unit(entry)
    return unit_in(entry.doc) if annotated is None else annotated


def unit_in(comment: str) -> str | None:
    """Return the unit in a comment: the only text in brackets, or that on a line of its own."""
    units: list[str] = _BRACKETS.findall(comment)
    if len(units) > 1:
        units = [
            m[1]
            for m in map(_BRACKETS.fullmatch, map(str.strip, comment.splitlines()))
            if m
        ]
    return units[0] if len(units) == 1 else None


def leaves(
    model: Model, struct: Struct, path: tuple[str, ...] = (), *, optional: bool = False
) -> Iterator[Leaf]:
    """Yield the members of a struct and of the structs in it, inherited ones first."""
    for member in model.members(struct):
        inner = model.declared(member.type)
        absent = optional or member.optional
        if isinstance(inner, Struct):
            yield from leaves(model, inner, (*path, member.name), optional=absent)
        else:
            type_ = model.unalias(member.type)
            yield Leaf((*path, member.name), type_, unit_of(member), absent)


def is_number(model: Model, type_: Type) -> bool:
    """Return whether it is a number, or sequences or arrays of numbers."""
    type_ = model.unalias(type_)
    if isinstance(type_, SequenceType | ArrayType):
        return is_number(model, type_.element)
    kinds = (FLOAT_LIMITS, INTEGER_RANGES)
    return isinstance(type_, PrimitiveType) and any(type_.kind in k for k in kinds)


def is_real(model: Model, type_: Type) -> bool:
    """Return whether it is a real number, or sequences or arrays of real numbers."""
    if isinstance(type_, SequenceType | ArrayType):
        return is_real(model, model.unalias(type_.element))
    return isinstance(type_, PrimitiveType) and type_.kind in FLOAT_LIMITS
