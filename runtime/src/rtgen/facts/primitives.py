"""Primitive types: names, `struct` codes, sizes, alignments, ranges and type code kinds."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Final, NamedTuple


class Primitive(StrEnum):
    """The primitive types; the value is the canonical spelling (OMG IDL 4.2, 7.4.1.4.4.2)."""

    # That of enums is a function in Python, which lookups of types would call.
    __hash__ = str.__hash__

    SHORT = "short"
    UNSIGNED_SHORT = "unsigned short"
    LONG = "long"
    UNSIGNED_LONG = "unsigned long"
    LONG_LONG = "long long"
    UNSIGNED_LONG_LONG = "unsigned long long"
    INT8 = "int8"
    UINT8 = "uint8"
    FLOAT = "float"
    DOUBLE = "double"
    LONG_DOUBLE = "long double"
    CHAR = "char"
    WCHAR = "wchar"
    BOOLEAN = "boolean"
    OCTET = "octet"
    ANY = "any"
    OBJECT = "Object"
    VALUE_BASE = "ValueBase"
    TYPE_CODE = "CORBA::TypeCode"
    VOID = "void"


class Scalar(NamedTuple):
    """A value of fixed size in CDR: its `struct` code, its size and alignment in octets."""

    code: str
    size: int
    align: int


INTEGERS: Final[Mapping[str, Scalar]] = {
    Primitive.INT8: Scalar("b", 1, 1),
    Primitive.UINT8: Scalar("B", 1, 1),
    Primitive.OCTET: Scalar("B", 1, 1),
    Primitive.SHORT: Scalar("h", 2, 2),
    Primitive.UNSIGNED_SHORT: Scalar("H", 2, 2),
    Primitive.LONG: Scalar("i", 4, 4),
    Primitive.UNSIGNED_LONG: Scalar("I", 4, 4),
    Primitive.LONG_LONG: Scalar("q", 8, 8),
    Primitive.UNSIGNED_LONG_LONG: Scalar("Q", 8, 8),
}
"""The integer types."""

NUMBERS: Final[Mapping[str, Scalar]] = {
    **INTEGERS,
    Primitive.FLOAT: Scalar("f", 4, 4),
    Primitive.DOUBLE: Scalar("d", 8, 8),
}
"""The types whose values `struct` packs without conversion."""

SCALARS: Final[Mapping[str, Scalar]] = {
    **NUMBERS,
    Primitive.BOOLEAN: Scalar("B", 1, 1),
    Primitive.CHAR: Scalar("c", 1, 1),
    Primitive.LONG_DOUBLE: Scalar("16s", 16, 8),
}
"""All types of fixed size; the code is one of octets where `struct` has none for the type.

`wchar` is missing: GIOP 1.2 sends a length and two octets (CORBA 3.3 part 2, 9.3.1.6), XCDR a
16-bit unit (DDS-XTypes 1.3, 7.4.1).
"""


def integer_range(scalar: Scalar) -> tuple[int, int]:
    """Return the minimum and the maximum of an integer type."""
    bits = 8 * scalar.size
    if scalar.code.isupper():
        return 0, (1 << bits) - 1
    return -(1 << bits - 1), (1 << bits - 1) - 1


INTEGER_RANGES: Final[Mapping[str, tuple[int, int]]] = {
    name: integer_range(scalar) for name, scalar in INTEGERS.items()
}
"""The minimum and the maximum of each integer type."""

FLOAT_LIMITS: Final[Mapping[str, float]] = {
    Primitive.FLOAT: (2.0 - 2.0**-23) * 2.0**127,
    Primitive.DOUBLE: float("inf"),
    Primitive.LONG_DOUBLE: float("inf"),
}
"""The greatest finite value of a floating-point type whose range is less than that of Python's
`float`.
"""

OCTET_TYPES: Final = frozenset((Primitive.OCTET, Primitive.UINT8))
"""The types whose sequences and arrays are `bytes` in Python."""

TYPE_CODE_KINDS: Final[Mapping[str, int]] = {
    "null": 0,
    Primitive.VOID: 1,
    Primitive.SHORT: 2,
    Primitive.LONG: 3,
    Primitive.UNSIGNED_SHORT: 4,
    Primitive.UNSIGNED_LONG: 5,
    Primitive.FLOAT: 6,
    Primitive.DOUBLE: 7,
    Primitive.BOOLEAN: 8,
    Primitive.CHAR: 9,
    Primitive.OCTET: 10,
    Primitive.ANY: 11,
    Primitive.TYPE_CODE: 12,
    Primitive.LONG_LONG: 23,
    Primitive.UNSIGNED_LONG_LONG: 24,
    Primitive.LONG_DOUBLE: 25,
    Primitive.WCHAR: 26,
}
"""`TCKind` of the types whose type code has no parameters (CORBA 3.3 part 2, table 9.2).

`null` is not an IDL type. `int8` and `uint8` have no kind in CORBA.
"""
