"""Types of members, as constants for them see them."""

from __future__ import annotations

from rtgen.compiler.model import (
    ArrayType,
    Model,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from rtgen.facts.adapter_constants import Shape


def shape_of(model: Model, type_: Type) -> Shape:
    """Return a type as constants see it."""
    match model.unalias(type_):
        case SequenceType(element=element, bound=bound):
            return Shape("sequence", bound, shape_of(model, element))
        case ArrayType(element=element, dimensions=(length,)):
            return Shape("array", length, shape_of(model, element))
        case StringType(wide=wide, bound=bound):
            return Shape("wstring" if wide else "string", bound)
        case PrimitiveType(kind=kind):
            return Shape(kind)
    return Shape("")
