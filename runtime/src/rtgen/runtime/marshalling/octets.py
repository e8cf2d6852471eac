"""Conversions between Python values and their octets in CDR, where `struct` has none.

Strings are UTF-8; `char` is ISO 8859-1; `wchar` and `wstring` are UTF-16 as omniORB 4.3 sends them
under GIOP 1.2 (CORBA 3.3 part 2, 9.3.1 and 9.3.2). All raise ValueError or a related
error for invalid values; the codecs convert that to a `CdrError`.
"""

from __future__ import annotations

import struct
import sys
from array import array
from codecs import (
    utf_16_be_decode,
    utf_16_be_encode,
    utf_16_le_decode,
    utf_16_le_encode,
)
from collections.abc import Sequence
from decimal import Decimal
from struct import Struct
from typing import Any, TypeVar

import msgspec

_T = TypeVar("_T")

BOOLEAN = {0: False, 1: True}
"""Values of a boolean octet."""


def text_octets(text: str) -> bytes:
    """Return the octets of a string without the final NUL. Raises ValueError.

    NUL and surrogates are invalid.
    """
    if "\0" in text:
        raise ValueError("a string cannot hold NUL")
    return text.encode()


def text_value(octets: bytes) -> str:
    """Return the string of octets that end with NUL (no octets: an empty string)."""
    if octets.find(0) != len(octets) - 1:
        raise ValueError("a string has to end with its only NUL")
    return octets[:-1].decode()


def wide_octets(text: str) -> bytes:
    """Return a wstring: UTF-16, little-endian with BOM in either byte order; may be empty."""
    if "\0" in text:
        raise ValueError("a wstring cannot hold NUL")
    return b"\xff\xfe" + utf_16_le_encode(text)[0] if text else b""


def wide_value(octets: bytes, bound: int | None = None) -> str:
    """Return the wstring of octets with a BOM, or without one big-endian (GIOP 1.2)."""
    decode = utf_16_be_decode
    mark = octets[:2]
    if mark in (b"\xff\xfe", b"\xfe\xff"):
        octets = octets[2:]
        decode = utf_16_le_decode if mark == b"\xff\xfe" else decode
    if bound is not None and len(octets) > 2 * bound:
        raise ValueError("wrong length")
    text, _ = decode(octets, "strict", True)
    if "\0" in text:
        raise ValueError("a wstring cannot hold NUL")
    return text


def unit_octets(text: str, little_endian: bool) -> bytes:
    """Return a wstring in XCDR: UTF-16 in the byte order, without BOM and NUL."""
    if "\0" in text:
        raise ValueError("a wstring cannot hold NUL")
    octets, _ = utf_16_le_encode(text) if little_endian else utf_16_be_encode(text)
    return octets


def unit_text(octets: bytes, little_endian: bool) -> str:
    """Return the wstring of octets in XCDR."""
    decode = utf_16_le_decode if little_endian else utf_16_be_decode
    text, _ = decode(octets, "strict", True)
    if "\0" in text:
        raise ValueError("a wstring cannot hold NUL")
    return text


def words_of(text: str) -> Sequence[int]:
    """Return the UTF-16 units of a wstring, each of which has four octets in ROS 2."""
    octets = unit_octets(text, sys.byteorder == "little")
    return memoryview(octets).cast("H")


def words_text(words: Sequence[int]) -> str:
    """Return the wstring of UTF-16 units."""
    if words and max(words) > 0xFFFF:
        raise ValueError(f"{max(words):#x} is not a unit of UTF-16")
    return unit_text(array("H", words).tobytes(), sys.byteorder == "little")


def unit_number(character: str) -> int:
    """Return a wchar in XCDR: one UTF-16 unit."""
    unit = ord(character)
    if 0xD800 <= unit < 0xE000 or unit > 0xFFFF:
        raise ValueError("a wchar is one character of the basic multilingual plane")
    return unit


def unit_character(unit: int) -> str:
    """Return the character of a unit."""
    if 0xD800 <= unit < 0xE000:
        raise ValueError(f"a wchar cannot be the surrogate {unit:#x}")
    return chr(unit)


def wide_character(character: str) -> bytes:
    """Return a wchar: the number of octets, then one UTF-16 unit, big-endian."""
    octets, _ = utf_16_be_encode(character)
    if len(octets) != 2:
        raise ValueError("a wchar is one character of the basic multilingual plane")
    return b"\x02" + octets


def wide_character_value(octets: bytes) -> str:
    """Return the character of a wchar."""
    if octets[0] != 2:
        raise ValueError(f"a wchar of {octets[0]} octets")
    return utf_16_be_decode(octets[1:], "strict", True)[0]


def quad_octets(value: float, little_endian: bool) -> bytes:
    """Return the long double (IEEE 754 binary128) equal to a float."""
    bits = int.from_bytes(struct.pack(">d", value))
    sign, exponent, fraction = bits >> 63, bits >> 52 & 0x7FF, bits & ((1 << 52) - 1)
    if exponent == 0x7FF:
        exponent = 0x7FFF
    elif exponent:
        exponent += 0x3FFF - 0x3FF
    elif fraction:
        shift = 53 - fraction.bit_length()
        fraction = fraction << shift & ((1 << 52) - 1)
        exponent = 0x3FFF - 0x3FF + 1 - shift
    quad = sign << 127 | exponent << 112 | fraction << 60
    return quad.to_bytes(16, "little" if little_endian else "big")


def quad_value(octets: bytes, little_endian: bool) -> float:
    """Return the nearest float (ties to even). Raises OverflowError beyond the range of a float."""
    quad = int.from_bytes(octets, "little" if little_endian else "big")
    sign, exponent, fraction = (
        quad >> 127,
        quad >> 112 & 0x7FFF,
        quad & ((1 << 112) - 1),
    )
    if exponent == 0x7FFF:
        bits = (
            sign << 63
            | 0x7FF << 52
            | fraction >> 60
            | (fraction != 0 and not fraction >> 60)
        )
        return float(struct.unpack(">d", bits.to_bytes(8))[0])
    number = fraction | (1 << 112 if exponent else 0)
    power = max(exponent, 1) - 0x3FFF - 112
    value = float(number << power) if power >= 0 else number / (1 << -power)
    return -value if sign else value


def fixed_octets(value: Decimal, digits: int, scale: int) -> bytes:
    """Return a fixed: decimal digits in half octets, sign last. Raises ValueError."""
    if not isinstance(value, Decimal) or not value.is_finite():
        raise TypeError("a fixed is a finite Decimal")
    sign, figures, exponent = value.as_tuple()
    assert isinstance(exponent, int)
    number = int("".join(map(str, figures)))
    shift = exponent + scale
    if shift < 0:
        number, rest = divmod(number, 10**-shift) if -shift < 100 else (0, number)
        if rest:
            raise ValueError(f"more than {scale} digits after the point")
    elif number:
        if shift > digits:
            raise ValueError(f"more than {digits} digits")
        number *= 10**shift
    text = f"{number:0{digits + 1 - digits % 2}d}"
    if len(text) > digits + 1 - digits % 2 or (digits % 2 == 0 and text[0] != "0"):
        raise ValueError(f"more than {digits} digits")
    return bytes.fromhex(text + ("d" if sign and number else "c"))


def fixed_value(octets: bytes, digits: int, scale: int) -> Decimal:
    """Return the Decimal of a fixed, with `scale` digits after the point."""
    text = octets.hex()
    figures, sign = text[:-1], text[-1]
    if sign not in "cd" or not figures.isdecimal() or int(figures) >= 10**digits:
        raise ValueError("not a fixed")
    return Decimal(
        (int(sign == "d"), tuple(map(int, figures.lstrip("0") or "0")), -scale)
    )


def exact(items: Sequence[_T], length: int) -> Sequence[_T]:
    """Return the items. Raises ValueError unless their number is `length`."""
    if len(items) != length:
        raise ValueError(f"{len(items)} items instead of {length}")
    return items


def octets_in(value: Any) -> bytes | bytearray:
    """Return the octets of `bytes`, or of a buffer of octets. Raises ValueError."""
    if isinstance(value, bytes | bytearray):
        return value
    try:
        view = memoryview(value)
    except TypeError:
        message = f"bytes are needed, not {type(value).__name__}"
        raise ValueError(message) from None
    if view.format[-1:] not in ("B", "c") or view.itemsize != 1:
        raise ValueError(f"a buffer of octets is needed, not of {view.format!r}")
    if view.ndim != 1:
        raise ValueError(f"a buffer of 1 dimension is needed, not of {view.ndim}")
    return view.tobytes()


def exact_octets(value: Any, length: int) -> bytes | bytearray:
    """Return that many octets. Raises ValueError."""
    octets = octets_in(value)
    if len(octets) != length:
        raise ValueError(f"{len(octets)} items instead of {length}")
    return octets


def copied_octets(value: Any) -> bytes:
    """Return an immutable copy of octets. Raises ValueError."""
    return bytes(octets_in(value))


def flat(items: Sequence[Any], dimensions: Sequence[int]) -> list[Any]:
    """Flatten the items of a multidimensional array, outermost first."""
    for depth, length in enumerate(dimensions):
        if len(items) != length:
            raise ValueError(f"{len(items)} items instead of {length}")
        if depth + 1 < len(dimensions):
            rows = [exact(row, dimensions[depth + 1]) for row in items]
            return [item for row in rows for item in flat(row, dimensions[depth + 1 :])]
    return list(items)


def nested(items: Sequence[Any], dimensions: Sequence[int]) -> list[Any]:
    """Nest the items to an array with those dimensions."""
    if len(dimensions) == 1:
        return list(items)
    step = len(items) // dimensions[0]
    return [
        nested(items[i : i + step], dimensions[1:]) for i in range(0, len(items), step)
    ]


class ObjectReference(msgspec.Struct, frozen=True, gc=False):
    """An object reference (IOR): repository id and tagged profiles (CORBA 3.3 part 2, 7.6.2)."""

    type_id: str = ""
    profiles: tuple[tuple[int, bytes], ...] = ()


_ULONG = (Struct(">I"), Struct("<I"))


def write_reference(
    out: bytearray, reference: ObjectReference | None, little_endian: bool
) -> None:
    """Append a reference; None is nil."""
    pack = _ULONG[bool(little_endian)].pack
    type_id = b"" if reference is None else text_octets(reference.type_id)
    profiles = () if reference is None else reference.profiles
    out += bytes(-len(out) % 4) + pack(len(type_id) + 1) + type_id + b"\0"
    out += bytes(-len(out) % 4) + pack(len(profiles))
    for tag, octets in profiles:
        out += bytes(-len(out) % 4) + pack(tag) + pack(len(octets)) + octets


def read_reference(
    data: bytes | bytearray | memoryview, offset: int, little_endian: bool
) -> tuple[ObjectReference | None, int]:
    """Return the reference at `offset` (None for nil) and the next offset."""
    unpack = _ULONG[bool(little_endian)].unpack_from

    def octets() -> bytes:
        nonlocal offset
        offset += -offset % 4
        (length,) = unpack(data, offset)
        offset += 4
        if length > len(data) - offset:
            raise ValueError(f"{length} octets, and {len(data) - offset} are left")
        offset += length
        return bytes(data[offset - length : offset])

    type_id = text_value(octets())
    offset += -offset % 4
    (count,) = unpack(data, offset)
    offset += 4
    if count * 8 > len(data) - offset:
        raise ValueError(f"{count} profiles, and {len(data) - offset} octets are left")
    profiles = []
    for _ in range(count):
        offset += -offset % 4
        (tag,) = unpack(data, offset)
        offset += 4
        profiles.append((tag, octets()))
    if not profiles:
        return None, offset
    return ObjectReference(type_id, tuple(profiles)), offset


def flags_number(value: int, bound: int) -> int:
    """Return the number of a bitmask with that many bits."""
    if not 0 <= value < 1 << bound:
        raise ValueError(f"{value} has more than {bound} bits")
    return int(value)
