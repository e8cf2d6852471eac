"""Default value of a type, for members that were not sent (DDS-XTypes 1.3, 7.2.2.4.4)."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    FlagsDescriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.forms import formed
from rtgen.runtime.marshalling.octets import nested


def initial_value(descriptor: Descriptor) -> Any:
    """Return zero, empty, or the first enumerator; a new object for each call."""
    descriptor = plain(descriptor)
    match descriptor:
        case PrimitiveDescriptor("boolean"):
            return False
        case PrimitiveDescriptor("char" | "wchar"):
            return "\0"
        case PrimitiveDescriptor("float" | "double" | "long double"):
            return 0.0
        case PrimitiveDescriptor():
            return 0
        case StringDescriptor():
            return ""
        case SequenceDescriptor(element=element):
            empty = _text(element, 0)
            return formed(descriptor, empty) if empty == [] else empty
        case ArrayDescriptor(element=element, dimensions=(length,)):
            return _text(element, length) or formed(
                descriptor, [initial_value(element) for _ in range(length)]
            )
        case ArrayDescriptor(element=element, dimensions=dimensions):
            total = 1
            for length in dimensions:
                total *= length
            items = [initial_value(element) for _ in range(total)]
            return formed(descriptor, nested(items, dimensions))
        case MapDescriptor():
            return {}
        case EnumDescriptor(members=members):
            return descriptor.class_(members[0][1])
        case FlagsDescriptor():
            return descriptor.class_(0)
        case StructDescriptor() | UnionDescriptor():
            return descriptor.class_()
    return None


def _text(element: Descriptor, length: int) -> Any:
    """Return zeros as octets or characters, or an empty list."""
    match plain(element):
        case PrimitiveDescriptor("octet" | "uint8"):
            return bytes(length)
        case PrimitiveDescriptor("char"):
            return "\0" * length
    return []
