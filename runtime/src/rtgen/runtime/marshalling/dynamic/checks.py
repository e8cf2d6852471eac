"""Sizes, codes and bounds of classic CDR, for codecs that interpret descriptors."""

from __future__ import annotations

import struct
from math import prod
from typing import Any

from rtgen.facts.primitives import NUMBERS, OCTET_TYPES
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    Descriptor,
    FixedDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.marshalling.errors import Fault

CODES = {**{name: scalar.code for name, scalar in NUMBERS.items()}, "boolean": "B"}
"""The `struct` codes of basic types."""

TEXTS = OCTET_TYPES | {"char"}
"""The basic types of which sequences and arrays are `bytes` or `str`."""


def size_of(name: str) -> int:
    """Return the size of a basic type, which is also its alignment."""
    return struct.calcsize(f"<{CODES[name]}")


def bits_code(bound: int) -> str:
    """Return the `struct` code of the smallest unsigned integer of at least that many bits."""
    return "BHIQ"[(bound > 8) + (bound > 16) + (bound > 32)]


def packed(code: str, name: str, value: Any, order: str) -> bytes:
    """Return the octets of a number. Raises Fault."""
    try:
        return struct.pack(order + code, value)
    except struct.error as failure:
        if isinstance(value, int) and not isinstance(value, bool):
            raise Fault(f"{value} is out of the range of {name}") from failure
        raise Fault(f"a value of {name} is needed, not {value!r}") from failure
    except OverflowError as failure:
        raise Fault(f"{value} is out of the range of {name}") from failure


def check_string(text: str, wide: bool, bound: int | None) -> None:
    """Raise Fault for a string beyond its bound."""
    if wide:
        check_bound(len(text.encode("utf-16-le")) // 2, bound, "UTF-16 units")
    else:
        check_bound(len(text.encode()), bound, "octets of UTF-8")


def check_bound(length: int, bound: int | None, unit: str) -> None:
    """Raise Fault for a length beyond the bound."""
    if bound is not None and length > bound:
        raise Fault(f"{length} {unit}, and {bound} are the most")


class LeastSizes:
    """The minimum sizes of types, against which counts are checked."""

    def __init__(self) -> None:
        self._sizes: dict[int, int] = {}

    def of(self, element: Descriptor) -> int:
        """Return the minimum size of a value in octets, without padding."""
        size = self._sizes.get(id(element))
        if size is None:
            self._sizes[id(element)] = 1
            size = self._sizes[id(element)] = self._least_of(element)
        return size

    def _least_of(self, element: Descriptor) -> int:
        match element:
            case PrimitiveDescriptor("wchar"):
                return 3
            case PrimitiveDescriptor("long double"):
                return 16
            case PrimitiveDescriptor(name) if name in CODES:
                return size_of(name)
            case PrimitiveDescriptor("null" | "void"):
                return 0
            case FixedDescriptor(digits=digits):
                return digits // 2 + 1
            case ArrayDescriptor(element=inner, dimensions=dimensions):
                return self.of(inner) * prod(dimensions)
            case StructDescriptor(members=members):
                return sum(self.of(member.type) for member in members)
            case AliasDescriptor(target=target):
                return self.of(target)
            case LinkDescriptor() | PrimitiveDescriptor("char"):
                return 1
            case InterfaceDescriptor(abstract=True):
                return 5
            case PrimitiveDescriptor("Object") | InterfaceDescriptor():
                return 8
            case FlagsDescriptor(bound=bound) | BitsetDescriptor(bound=bound):
                return struct.calcsize(f"<{bits_code(bound)}")
            case UnionDescriptor(switch=switch):
                return self.of(switch)
        return 4
