"""Helpers of generated PDO codecs (data types of CiA 301, 7.1.6)."""

from __future__ import annotations

from struct import Struct
from typing import TYPE_CHECKING, cast

from rtgen.facts.canopen import (
    DAY,
    EPOCH,
    MAX_DAYS,
    milliseconds_of,
    visible_octets,
    visible_text,
)
from rtgen.runtime.canopen.wire.frames import SECOND

if TYPE_CHECKING:
    from rtgen.runtime.rtc.component import Time

_F32, _U32 = Struct("<f"), Struct("<I")
_F64, _U64 = Struct("<d"), Struct("<Q")
_EPOCH_SECONDS = EPOCH // 1000
_MAX_SECONDS = 0xFFFFFFFF
"""The largest `RTC::Time.sec`."""


class PdoError(ValueError):
    """Data too short for a PDO, or a value outside the range of its field."""


def outside(name: str, value: object, low: int, high: int) -> PdoError:
    """Return the error for a value outside of its field's range."""
    return PdoError(f"{name} is {value!r}, not {low} to {high}")


def real32(bits: int) -> float:
    """Return the REAL32 of these bits."""
    return cast("float", _F32.unpack(_U32.pack(bits))[0])


def real32_bits(value: float) -> int:
    """Return the bits of a REAL32. Raises struct.error or OverflowError if out of range."""
    return cast("int", _U32.unpack(_F32.pack(value))[0])


def real64(bits: int) -> float:
    """Return the REAL64 of these bits."""
    return cast("float", _F64.unpack(_U64.pack(bits))[0])


def real64_bits(value: float) -> int:
    """Return the bits of a REAL64. Raises struct.error if out of range."""
    return cast("int", _U64.unpack(_F64.pack(value))[0])


def octets(name: str, value: bytes, size: int) -> bytes:
    """Check that there are at most `size` octets; struct pads with zeros."""
    if len(value) > size:
        raise PdoError(f"{name} has {len(value)} octets, not up to {size}")
    return value


def within(name: str, value: int, low: int, high: int) -> int:
    """Check the value of a field that is longer than its type."""
    if not low <= value <= high:
        raise outside(name, value, low, high)
    return value


def terminated(value: str) -> str:
    """Return text up to its first zero, which no string of IDL can hold."""
    return value.partition("\0")[0]


def field_text(data: bytes) -> str:
    """Decode a VISIBLE_STRING up to its first zero."""
    return visible_text(data.partition(b"\0")[0])


def text(name: str, value: str, size: int) -> bytes:
    """Encode a VISIBLE_STRING of at most `size` octets."""
    try:
        return octets(name, visible_octets(value), size)
    except UnicodeEncodeError:
        raise PdoError(f"{name} has half a character of UTF-16") from None


def wide_text(name: str, data: bytes) -> str:
    """Decode a UNICODE_STRING up to its first zero."""
    text = terminated(data[: len(data) & ~1].decode("utf-16-le", "surrogatepass"))
    wide_octets(name, text)
    return text


def wide_octets(name: str, value: str) -> bytes:
    """Encode text as UTF-16."""
    try:
        return value.encode("utf-16-le")
    except UnicodeEncodeError:
        raise PdoError(f"{name} has half a character of UTF-16") from None


def unscaled(name: str, value: float, factor: float) -> int:
    """Return the integer nearest to `value / factor`."""
    try:
        return round(value / factor)
    except (OverflowError, ValueError, TypeError):
        raise PdoError(f"{name} is {value!r}, no number") from None


def quotient(value: float, factor: float) -> float:
    """Return a physical value divided by its factor."""
    return value / factor


def nanoseconds(time: Time) -> int:
    """Return a time in ns."""
    return time.sec * SECOND + time.nsec


def seconds(name: str, raw: int, epoch: int = 0) -> tuple[int, int]:
    """Return a TIME_DIFFERENCE (48 bits) in seconds and nanoseconds, those of `RTC::Time`.

    Raises PdoError beyond 2**32 seconds.
    """
    total = milliseconds_of(raw)
    return _seconds(name, total // 1000 + epoch), total % 1000 * 1_000_000


def seconds_of_day(name: str, raw: int) -> tuple[int, int]:
    """Return a TIME_OF_DAY (48 bits) in seconds since 1970 (UTC) and nanoseconds.

    Raises PdoError beyond 2106-02-07T06:28:15.
    """
    return seconds(name, raw, _EPOCH_SECONDS)


def seconds_of(name: str, time: int) -> tuple[int, int]:
    """Return a time in ns as `RTC::Time` has it. Raises PdoError beyond 2**32 seconds."""
    whole, rest = divmod(time, SECOND)
    return _seconds(name, whole), rest


def _seconds(name: str, whole: int) -> int:
    if not 0 <= whole <= _MAX_SECONDS:
        raise PdoError(f"{name} is {whole} s; RTC::Time has 0 to {_MAX_SECONDS} s")
    return whole


def time_bits(name: str, sec: int, nsec: int) -> int:
    """Return the 48 bits of a TIME_DIFFERENCE: milliseconds, then days."""
    days, milliseconds = divmod(sec * 1000 + nsec // 1_000_000, DAY)
    if not 0 <= days <= MAX_DAYS:
        raise outside(name, days, 0, MAX_DAYS)
    return days << 32 | milliseconds


def day_bits(name: str, sec: int, nsec: int) -> int:
    """Return the 48 bits of a TIME_OF_DAY, of a time since 1970 (UTC)."""
    return time_bits(name, sec - _EPOCH_SECONDS, nsec)
