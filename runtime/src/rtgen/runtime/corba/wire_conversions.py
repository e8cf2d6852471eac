"""Conversions of single values between the forms of rtgen and omniORBpy."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

import msgspec

from rtgen.runtime.marshalling.octets import copied_octets

Convert: TypeAlias = Callable[[Any], Any]


class WireType(msgspec.Struct, frozen=True):
    """A descriptor of omniORBpy; `outgoing` and `incoming` convert values, None if unnecessary."""

    descriptor: Any
    outgoing: Convert | None = None
    incoming: Convert | None = None


class WireUnion(msgspec.Struct):
    """A union for omniORBpy to read: discriminator and value."""

    _d: Any
    _v: Any


def each(convert: Convert | None) -> Convert | None:
    """Return the conversion of a list of items."""
    if convert is None:
        return None
    return lambda items: [convert(item) for item in items]


def through(convert: Convert | None, value: Any) -> Any:
    """Convert a value; the conversion None returns it unchanged."""
    return value if convert is None else convert(value)


def octets(value: Any) -> Any:
    """Return the octets of a buffer as `bytes`; other objects unchanged, which omniORB refuses."""
    if value.__class__ is bytes:
        return value
    try:
        return copied_octets(value)
    except ValueError:
        return value


def octet_of(number: int) -> int:
    """Return an int8 as an octet. Raises ValueError."""
    if not -128 <= number < 128:
        raise ValueError(f"{number} is not an int8")
    return number & 255


def octets_of(numbers: Iterable[int]) -> bytes:
    """Return int8 numbers as octets. Raises ValueError."""
    return bytes(map(octet_of, numbers))


def int8_of(octet: int) -> int:
    """Return an octet as an int8."""
    return octet - 256 if octet > 127 else octet


# As octets, because omniORB would convert characters between code sets; they are ISO 8859-1.


def latin_octet(character: str) -> int:
    (octet,) = character.encode("latin-1")
    return octet


def latin_octets(text: str) -> bytes:
    return text.encode("latin-1")


def latin_text(octets: bytes) -> str:
    return octets.decode("latin-1")
