"""Default value of a type, for members that were not sent.

DDS-XTypes 1.3, 7.2.2.4.4.4.9 and Table 9.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from math import prod
from typing import Any, Final

from rtgen.facts.primitives import INTEGER_RANGES
from rtgen.runtime.marshalling.descriptors import (
    NULL,
    UNKNOWN,
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    Descriptor,
    EnumDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    LinkDescriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.forms import formed, is_octet
from rtgen.runtime.marshalling.octets import nested

_CHAR: Final = PrimitiveDescriptor("char")


def initial_value(descriptor: Descriptor, default: Any = None) -> Any:
    """Return the default, else the value of the type; a new object for each call.

    A type has the default of its nearest typedef, else zero, empty, the first or default
    enumerator, the defaults of its members.
    """
    while default is None and isinstance(descriptor, AliasDescriptor | LinkDescriptor):
        if isinstance(descriptor, LinkDescriptor):
            descriptor = descriptor.target()
        else:
            default, descriptor = descriptor.initial, descriptor.target
    descriptor = plain(descriptor)
    if isinstance(descriptor, SequenceDescriptor | ArrayDescriptor):
        return _collection(descriptor, default)
    return _implicit(descriptor) if default is None else default


def _implicit(descriptor: Descriptor) -> Any:
    match descriptor:
        case PrimitiveDescriptor("boolean"):
            return False
        case PrimitiveDescriptor("char" | "wchar"):
            return "\0"
        case PrimitiveDescriptor("float" | "double" | "long double"):
            return 0.0
        case PrimitiveDescriptor("any"):
            return UNKNOWN[PrimitiveDescriptor](NULL, None)
        case PrimitiveDescriptor("CORBA::TypeCode"):
            return NULL
        case PrimitiveDescriptor(name) if name in INTEGER_RANGES:
            return 0
        case StringDescriptor():
            return ""
        case FixedDescriptor():
            return Decimal(0)
        case MapDescriptor():
            return {}
        case EnumDescriptor(members=members, initial=initial):
            return descriptor.class_(members[0][1] if initial is None else initial)
        case FlagsDescriptor():
            return descriptor.class_(0)
        case StructDescriptor() | UnionDescriptor() | BitsetDescriptor():
            return descriptor.class_()
    return None


def _collection(descriptor: SequenceDescriptor | ArrayDescriptor, default: Any) -> Any:
    """Return a list, octets or characters: the items of a default, or initial ones."""
    element = descriptor.element
    dimensions: tuple[int, ...] = (0 if default is None else len(default),)
    if isinstance(descriptor, ArrayDescriptor):
        dimensions = descriptor.dimensions
    items = default
    if items is None:
        items = [initial_value(element) for _ in range(prod(dimensions))]
    *outer, last = dimensions
    if is_octet(element):
        items = [bytes(row) for row in _rows(items, last)]
    elif plain(element) == _CHAR:
        items = ["".join(row) for row in _rows(items, last)]
    else:
        return formed(descriptor, nested(items, dimensions))
    return nested(items, outer) if outer else items[0]


def _rows(items: Sequence[Any], size: int) -> list[Sequence[Any]]:
    """Split items into rows; without any there is one empty row."""
    return [items[at : at + size] for at in range(0, len(items), size or 1)] or [()]
