"""Data types, times, texts and identifiers of CANopen (CiA 301)."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Final, Literal, TypeAlias, cast

NMT: Final = 0x000
SYNC: Final = 0x080
TIME: Final = 0x100
EMERGENCY: Final = 0x080
"""Bases of COB-IDs, to which the node-id is added: this one, and SDO_RESPONSE to ERROR_CONTROL (CiA
301, table 40).
"""
SDO_RESPONSE: Final = 0x580
SDO_REQUEST: Final = 0x600
ERROR_CONTROL: Final = 0x700
LSS_RESPONSE: Final = 0x7E4
LSS_REQUEST: Final = 0x7E5

MAX_NODE_ID: Final = 127

INVALID: Final = 1 << 31
"""Flag of the COB-ID of a PDO, SDO or EMCY: the object does not exist or is not valid."""
NO_RTR: Final = 1 << 30
"""Flag of a TPDO's COB-ID: no remote frames are answered."""
EXTENDED: Final = 1 << 29
"""Flag of a COB-ID: the CAN identifier has 29 bits."""
MAX_STANDARD_ID: Final = 0x7FF
MAX_EXTENDED_ID: Final = 0x1FFFFFFF
"""Highest CAN identifiers, of 11 and of 29 bits."""

RPDO_COMMUNICATION: Final = 0x1400
RPDO_MAPPING: Final = 0x1600
TPDO_COMMUNICATION: Final = 0x1800
TPDO_MAPPING: Final = 0x1A00
PDOS: Final = 512
"""Maximum number of PDOs per direction."""
MAX_SYNC_CYCLIC: Final = 240
"""Highest transmission type of a synchronous PDO (CiA 301, table 55)."""

MILLISECOND: Final = 1_000_000
"""Unit of heartbeat and event times, in nanoseconds."""
INHIBIT_UNIT: Final = 100_000
"""Unit of inhibit times (100 us), in nanoseconds."""


def can_id_of(cob_id: int) -> int:
    """Return the CAN identifier of a COB-ID with flags."""
    return cob_id & (MAX_EXTENDED_ID if cob_id & EXTENDED else MAX_STANDARD_ID)


def nearest_zero(low: int | float | None, high: int | float | None) -> int | float:
    """Return the value within the limits that is nearest to 0; None stands for no limit.

    An object without a default begins with it.
    """
    if low is not None and low > 0:
        return low
    return high if high is not None and high < 0 else 0


class DataType(IntEnum):
    """The basic data types and their codes (CiA 301, table 44).

    VISIBLE_CHAR is not in CiA 301: RTC-CANopen uses its code for a character.
    """

    BOOLEAN = 0x01
    INTEGER8 = 0x02
    INTEGER16 = 0x03
    INTEGER32 = 0x04
    UNSIGNED8 = 0x05
    UNSIGNED16 = 0x06
    UNSIGNED32 = 0x07
    REAL32 = 0x08
    VISIBLE_STRING = 0x09
    OCTET_STRING = 0x0A
    UNICODE_STRING = 0x0B
    TIME_OF_DAY = 0x0C
    TIME_DIFFERENCE = 0x0D
    DOMAIN = 0x0F
    INTEGER24 = 0x10
    REAL64 = 0x11
    INTEGER40 = 0x12
    INTEGER48 = 0x13
    INTEGER56 = 0x14
    INTEGER64 = 0x15
    UNSIGNED24 = 0x16
    UNSIGNED40 = 0x18
    UNSIGNED48 = 0x19
    UNSIGNED56 = 0x1A
    UNSIGNED64 = 0x1B
    VISIBLE_CHAR = 0xA0


Kind: TypeAlias = Literal[
    "bool", "char", "string", "wstring", "octets", "time_of_day", "time_difference",
    "i8", "i16", "i24", "i32", "i40", "i48", "i56", "i64",
    "u8", "u16", "u24", "u32", "u40", "u48", "u56", "u64",
    "r32", "r64",
]  # fmt: skip
"""A class of values: an integer or a real of a number of bits, text, octets, or a time."""

_WIDTHS: Final = range(8, 65, 8)

SIGNED_KINDS: Final = {cast("Kind", f"i{bits}"): bits for bits in _WIDTHS}
"""Widths in bits of the kinds of signed integers."""

UNSIGNED_KINDS: Final = {cast("Kind", f"u{bits}"): bits for bits in _WIDTHS}
"""Widths in bits of the kinds of unsigned integers."""

KIND_BITS: Final[Mapping[Kind, int]] = {
    "bool": 1, "char": 8, "r32": 32, "r64": 64,
    "time_of_day": 48, "time_difference": 48,
    **SIGNED_KINDS, **UNSIGNED_KINDS,
}  # fmt: skip
"""Widths in bits of the kinds of fixed width, as in a PDO; over SDO a boolean takes an octet."""

KINDS: Final[Mapping[DataType, Kind]] = {
    DataType.BOOLEAN: "bool",
    DataType.VISIBLE_CHAR: "char",
    DataType.VISIBLE_STRING: "string",
    DataType.UNICODE_STRING: "wstring",
    DataType.OCTET_STRING: "octets",
    DataType.DOMAIN: "octets",
    DataType.TIME_OF_DAY: "time_of_day",
    DataType.TIME_DIFFERENCE: "time_difference",
    DataType.REAL32: "r32",
    DataType.REAL64: "r64",
    **{DataType[f"INTEGER{bits}"]: kind for kind, bits in SIGNED_KINDS.items()},
    **{DataType[f"UNSIGNED{bits}"]: kind for kind, bits in UNSIGNED_KINDS.items()},
}
"""The kind of each data type."""

SIGNED: Final[Mapping[DataType, int]] = {
    t: SIGNED_KINDS[k] for t, k in KINDS.items() if k in SIGNED_KINDS
}
"""Widths in bits of the signed integer types."""

UNSIGNED: Final[Mapping[DataType, int]] = {
    t: UNSIGNED_KINDS[k] for t, k in KINDS.items() if k in UNSIGNED_KINDS
}
"""Widths in bits of the unsigned integer types."""

BITS: Final[Mapping[DataType, int]] = {
    t: KIND_BITS[k] for t, k in KINDS.items() if k in KIND_BITS
}
"""Widths in bits of the types of fixed width, as in a PDO; over SDO a BOOLEAN takes an octet."""

NUMBER_KINDS: Final = frozenset((*SIGNED_KINDS, *UNSIGNED_KINDS, "r32", "r64"))
"""The kinds of integers and reals."""

REAL_CODES: Final[Mapping[Kind, str]] = {"r32": "<f", "r64": "<d"}
"""The `struct` formats of reals."""

CHARACTER_ENCODING: Final = "latin-1"
WIDE_ENCODING: Final = "utf-16-le"


def visible_octets(text: str) -> bytes:
    """Encode a VISIBLE_STRING: ASCII by CiA 301, else Latin-1, which many devices use.

    UTF-8 for characters outside of Latin-1, and where Latin-1 would be decoded as UTF-8. Raises
    UnicodeEncodeError for a lone surrogate.
    """
    try:
        octets = text.encode("latin-1")
    except UnicodeEncodeError:
        return text.encode("utf-8")
    return octets if visible_text(octets) == text else text.encode("utf-8")


def visible_text(octets: bytes) -> str:
    """Decode a VISIBLE_STRING: UTF-8 if it is valid UTF-8, else Latin-1."""
    try:
        return octets.decode("utf-8")
    except UnicodeDecodeError:
        return octets.decode("latin-1")


DAY: Final = 86_400_000
"""Milliseconds in a day."""
EPOCH_DAYS: Final = 5113
"""1984-01-01, the epoch of TIME_OF_DAY and TIME, in days since 1970-01-01."""
EPOCH: Final = EPOCH_DAYS * DAY
"""The epoch in milliseconds since 1970-01-01."""
MAX_DAYS: Final = 0xFFFF
MILLISECONDS: Final = (1 << 28) - 1
"""Mask of the milliseconds in a time; the other four of its first 32 bits are reserved."""


def milliseconds_of(raw: int) -> int:
    """Return the milliseconds of a TIME_DIFFERENCE (48 bits; CiA 301, 7.1.6.6)."""
    return (raw >> 32) * DAY + (raw & MILLISECONDS)
