"""Member headers: of mutable types, and of optional members in XCDR1."""

from __future__ import annotations

from struct import Struct
from typing import Any

PID_EXTENDED = 0x3F01
PID_LIST_END = 0x3F02
PID_IGNORE = 0x3F03
SHORT_MUST_UNDERSTAND = 0x4000
SHORT_IMPLEMENTATION = 0x8000
LONG_MUST_UNDERSTAND = 0x40000000
LONG_IMPLEMENTATION = 0x80000000
MUST_UNDERSTAND = 0x80000000
MEMBER_ID = 0x0FFFFFFF

_ULONG = (Struct(">I").unpack_from, Struct("<I").unpack_from)
_SHORT = (Struct(">HH").unpack_from, Struct("<HH").unpack_from)
_LONG = (Struct(">II").unpack_from, Struct("<II").unpack_from)


class Lengths:
    """Encoder and decoder of the length of a delimited value."""

    put_little = Struct("<I").pack_into
    put_big = Struct(">I").pack_into
    get_little = Struct("<I").unpack_from
    get_big = Struct(">I").unpack_from


class MemberHeaders:
    """Encoder of an EMHEADER and the length after it."""

    put_little = Struct("<II").pack_into
    put_big = Struct(">II").pack_into


class Parameters:
    """Encoder of a parameter's header (PID, 8, flags and id, length) and of the end of a list."""

    pack_little = Struct("<HHII").pack
    pack_big = Struct(">HHII").pack
    end_little = Struct("<HH").pack(PID_LIST_END | SHORT_MUST_UNDERSTAND, 0)
    end_big = Struct(">HH").pack(PID_LIST_END | SHORT_MUST_UNDERSTAND, 0)


def next_member(
    data: Any, offset: int, end: int, little_endian: bool
) -> tuple[int, bool, int, int]:
    """Return the id of the next member, whether it must be understood, and its content.

    The member is at an offset before `end`; the content is given by its offsets. Raises ValueError
    or struct.error.
    """
    offset += -offset & 3
    (header,) = _ULONG[little_endian](data, offset)
    offset += 4
    code = header >> 28 & 7
    if code < 4:
        size = 1 << code
    else:
        (size,) = _ULONG[little_endian](data, offset)
        if code == 4:
            offset += 4
        else:
            size = 4 + size * (1, 4, 8)[code - 5]
    left(end, offset, size)
    return header & MEMBER_ID, header >= MUST_UNDERSTAND, offset, offset + size


def next_parameter(
    data: Any, offset: int, little_endian: bool
) -> tuple[int, bool, int, int]:
    """Return the same for a parameter of XCDR1; the id at the end of a list is negative."""
    offset += -offset & 3
    pid, size = _SHORT[little_endian](data, offset)
    offset += 4
    masked = pid & ~SHORT_MUST_UNDERSTAND
    must_understand = bool(pid & SHORT_MUST_UNDERSTAND)
    if masked == PID_LIST_END:
        return -1, False, offset, offset
    if masked == PID_EXTENDED:
        if size != 8:
            raise ValueError(f"an extended parameter header of {size} octets")
        flags, size = _LONG[little_endian](data, offset)
        offset += 8
        must_understand = bool(flags & LONG_MUST_UNDERSTAND)
        masked = flags & (MEMBER_ID | LONG_IMPLEMENTATION)
    elif masked == PID_IGNORE:
        masked = LONG_IMPLEMENTATION
    elif masked & SHORT_IMPLEMENTATION:
        masked = masked & ~SHORT_IMPLEMENTATION | LONG_IMPLEMENTATION
    left(len(data), offset, size)
    return masked, must_understand, offset, offset + size


def left(end: int, offset: int, size: int) -> None:
    """Raise ValueError if fewer octets remain than are read."""
    if size > end - offset:
        rest = max(end - offset, 0)
        raise ValueError(f"truncated: {size} octets are needed, {rest} are left")
