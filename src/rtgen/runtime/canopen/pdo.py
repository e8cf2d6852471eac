"""What generated PDO codecs use."""

from __future__ import annotations

from struct import Struct
from typing import cast

_F32, _U32 = Struct("<f"), Struct("<I")
_F64, _U64 = Struct("<d"), Struct("<Q")


class PdoError(ValueError):
    """Data too short for a PDO, or a value that does not fit into its field."""


def outside(name: str, value: object, low: int, high: int) -> PdoError:
    """The error for a value outside of its field's range."""
    return PdoError(f"{name} is {value!r}, not {low} to {high}")


def real32(bits: int) -> float:
    """The REAL32 of these bits."""
    return cast("float", _F32.unpack(_U32.pack(bits))[0])


def real32_bits(value: float) -> int:
    """The bits of a REAL32. Raises struct.error or OverflowError if it is none."""
    return cast("int", _U32.unpack(_F32.pack(value))[0])


def real64(bits: int) -> float:
    """The REAL64 of these bits."""
    return cast("float", _F64.unpack(_U64.pack(bits))[0])


def real64_bits(value: float) -> int:
    """The bits of a REAL64. Raises struct.error if it is none."""
    return cast("int", _U64.unpack(_F64.pack(value))[0])


def octets(name: str, value: bytes, size: int) -> bytes:
    """The octets, if there are no more than `size`; struct fills up with zeros."""
    if len(value) > size:
        raise PdoError(f"{name} has {len(value)} octets, not up to {size}")
    return value


def text(name: str, value: str, size: int) -> bytes:
    """The text as Latin-1, if it is no longer than `size`."""
    try:
        return octets(name, value.encode("latin-1"), size)
    except UnicodeEncodeError:
        raise PdoError(f"{name} has a character that is not of Latin-1") from None
