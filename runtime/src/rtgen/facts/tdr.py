"""TDR, the data representation of TECS RPC: letters and widths of C's basic types.

A letter is that of the `struct` module for a type of fixed size, one whose width the TDR defines
(`k` short, `n` int, `l` long, `p` intptr_t), or `w` for 128 bits. Upper case: unsigned.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Final


class Scalar(StrEnum):
    """C's basic types by their names in CDL and C headers; the value is the canonical spelling."""

    VOID = "void"
    BOOL = "bool_t"
    CHAR = "char_t"
    SCHAR = "schar_t"
    UCHAR = "uchar_t"
    INT8 = "int8_t"
    INT16 = "int16_t"
    INT32 = "int32_t"
    INT64 = "int64_t"
    INT128 = "int128_t"
    UINT8 = "uint8_t"
    UINT16 = "uint16_t"
    UINT32 = "uint32_t"
    UINT64 = "uint64_t"
    UINT128 = "uint128_t"
    SHORT = "short"
    USHORT = "unsigned short"
    INT = "int"
    UINT = "unsigned int"
    LONG = "long"
    ULONG = "unsigned long"
    LONG_LONG = "long long"
    ULONG_LONG = "unsigned long long"
    INTPTR = "intptr_t"
    UINTPTR = "uintptr_t"
    FLOAT32 = "float32_t"
    DOUBLE64 = "double64_t"


LETTERS: Final[Mapping[Scalar, str]] = {
    Scalar.BOOL: "?",
    Scalar.CHAR: "B",
    Scalar.UCHAR: "B",
    Scalar.SCHAR: "b",
    Scalar.INT8: "b",
    Scalar.UINT8: "B",
    Scalar.INT16: "h",
    Scalar.UINT16: "H",
    Scalar.INT32: "i",
    Scalar.UINT32: "I",
    Scalar.INT64: "q",
    Scalar.UINT64: "Q",
    Scalar.LONG_LONG: "q",
    Scalar.ULONG_LONG: "Q",
    Scalar.INT128: "w",
    Scalar.UINT128: "W",
    Scalar.SHORT: "k",
    Scalar.USHORT: "K",
    Scalar.INT: "n",
    Scalar.UINT: "N",
    Scalar.LONG: "l",
    Scalar.ULONG: "L",
    Scalar.INTPTR: "p",
    Scalar.UINTPTR: "P",
    Scalar.FLOAT32: "f",
    Scalar.DOUBLE64: "d",
}
"""The letter of each type that has values."""

INTEGERS: Final = frozenset(
    s for s in LETTERS if s not in (Scalar.BOOL, Scalar.FLOAT32, Scalar.DOUBLE64)
)
"""The integer types."""

UNSIGNED: Final = frozenset(
    s for s in INTEGERS if LETTERS[s].isupper() and s is not Scalar.CHAR
)
"""The unsigned integer types; the compiler decides whether `char_t` is signed."""

BITS: Final[Mapping[str, int]] = {"b": 8, "h": 16, "i": 32, "q": 64, "w": 128}
"""Widths of integers of fixed size, by letters in lower case."""

WIDTH_NAMES: Final[Mapping[str, str]] = {
    "k": "short_bits",
    "n": "int_bits",
    "l": "long_bits",
    "p": "intptr_bits",
}
"""Letters of integers whose width the TDR defines, with the TDR's name for it."""

STRUCT_CODES: Final[Mapping[int, str]] = {16: "h", 32: "i", 64: "q"}
"""The `struct` code of a signed integer, by the widths that a TDR can define."""
