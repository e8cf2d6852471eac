"""Encodes values of objects for SDO and PDO (data types of CiA 301, 7.1.6).

Times are integers in ns (time of day: since 1970, UTC); on the wire they count milliseconds.
"""

from __future__ import annotations

import operator
import struct
import sys
from typing import Final

from rtgen.facts.canopen import (
    CHARACTER_ENCODING,
    DAY,
    EPOCH,
    EPOCH_DAYS,
    KIND_BITS,
    MAX_DAYS,
    MILLISECOND,
    REAL_CODES,
    SIGNED_KINDS,
    UNSIGNED_KINDS,
    WIDE_ENCODING,
    Kind,
    milliseconds_of,
    visible_octets,
    visible_text,
)
from rtgen.facts.primitives import FLOAT_LIMITS, Primitive
from rtgen.runtime.canopen.description import ObjectValue
from rtgen.runtime.canopen.wire import sdo

_TIMES: Final[tuple[Kind, ...]] = ("time_of_day", "time_difference")
_REALS: Final[dict[Kind, tuple[struct.Struct, float]]] = {
    "r32": (struct.Struct(REAL_CODES["r32"]), FLOAT_LIMITS[Primitive.FLOAT]),
    "r64": (struct.Struct(REAL_CODES["r64"]), sys.float_info.max),
}
_ENCODINGS: Final[dict[Kind, str]] = {
    "char": CHARACTER_ENCODING, "string": "utf-8", "wstring": WIDE_ENCODING,
}  # fmt: skip


class ObjectValueError(ValueError):
    """An invalid value of an object; `code` is the corresponding SDO abort code."""

    def __init__(self, message: str, code: int = sdo.VALUE_INVALID) -> None:
        super().__init__(message)
        self.code = code


_SIZES: Final = {kind: (bits + 7) // 8 for kind, bits in KIND_BITS.items()}
_LIMITS: Final = {
    **{k: (-1 << bits - 1, (1 << bits - 1) - 1) for k, bits in SIGNED_KINDS.items()},
    **{kind: (0, (1 << bits) - 1) for kind, bits in UNSIGNED_KINDS.items()},
}


def size(kind: Kind) -> int | None:
    """Return the size of a value in SDO in octets; None for variable length."""
    return _SIZES.get(kind)


def limits(kind: Kind) -> tuple[int, int] | None:
    """Return the range of an integer kind, None for others."""
    return _LIMITS.get(kind)


def zero(kind: Kind) -> ObjectValue:
    """Return the value of an object without a default."""
    if kind == "bool":
        return False
    if kind in _REALS:
        return 0.0
    if kind == "char":
        return "\0"
    if kind in ("string", "wstring"):
        return ""
    if kind == "octets":
        return b""
    return EPOCH * MILLISECOND if kind == "time_of_day" else 0


def encode(kind: Kind, value: ObjectValue) -> bytes:
    """Encode a value. Raises ObjectValueError if it does not fit the kind."""
    own = _LIMITS.get(kind)
    if own is not None:
        number = value if type(value) is int else _integer(kind, value)
        if not own[0] <= number <= own[1]:
            checked(kind, number)
        return number.to_bytes(_SIZES[kind], "little", signed=own[0] < 0)
    if kind == "bool":
        return bytes((_boolean(value),))
    if kind in _REALS:
        return _encode_real(kind, value)
    if kind == "char" and len(_text(kind, value)) != 1:
        raise _foreign(kind, value)
    if kind in _ENCODINGS:
        return _encode_text(kind, value)
    if kind in _TIMES:
        return _encode_time(kind, _integer(kind, value))
    if not isinstance(value, (bytes, bytearray, memoryview)):
        raise _foreign(kind, value)
    return bytes(value)


def decode(kind: Kind, octets: bytes) -> ObjectValue:
    """Decode a value. Raises ObjectValueError for a wrong number of octets.

    Trailing zeros of text are padding. Any octet other than 0 is True.
    """
    expected = _SIZES.get(kind)
    if expected is not None and len(octets) != expected:
        code = sdo.LENGTH_TOO_HIGH if len(octets) > expected else sdo.LENGTH_TOO_LOW
        raise ObjectValueError(f"{kind} has {expected} octets, not {len(octets)}", code)
    own = _LIMITS.get(kind)
    if own is not None:
        return int.from_bytes(octets, "little", signed=own[0] < 0)
    if kind == "bool":
        return octets != b"\0"
    if kind in _REALS:
        return float(_REALS[kind][0].unpack(octets)[0])
    if kind == "char":
        return octets.decode("latin-1")
    if kind == "string":
        return visible_text(octets.rstrip(b"\0"))
    if kind == "wstring":
        return _decode_wide(octets)
    if kind in _TIMES:
        return _decode_time(kind, octets)
    return bytes(octets)


def uploaded(kind: Kind, octets: bytes) -> ObjectValue:
    """Return the value of octets uploaded by SDO. Raises ObjectValueError as `decode` does."""
    expected = size(kind)
    return decode(kind, octets if expected is None else octets[:expected])


def checked(
    kind: Kind,
    value: ObjectValue,
    low: int | float | None = None,
    high: int | float | None = None,
) -> ObjectValue:
    """Check a value against limits and the range of its kind. Raises ObjectValueError."""
    if isinstance(value, (str, bytes)):
        return value
    own = _LIMITS.get(kind)
    if own is not None:
        low = own[0] if low is None else max(low, own[0])
        high = own[1] if high is None else min(high, own[1])
    if high is not None and value > high:
        raise ObjectValueError(f"{value} is over {high}", sdo.VALUE_TOO_HIGH)
    if low is not None and value < low:
        raise ObjectValueError(f"{value} is under {low}", sdo.VALUE_TOO_LOW)
    return value


def to_bits(kind: Kind, value: ObjectValue, bits: int) -> int:
    """Encode a value in a PDO field of `bits` bits: its least significant ones.

    Longer fields are filled with the sign, or with zeros.
    """
    octets = encode(kind, value)
    raw = int.from_bytes(octets, "little", signed=kind in SIGNED_KINDS)
    return raw & (1 << bits) - 1


def from_bits(kind: Kind, raw: int, bits: int) -> ObjectValue:
    """Decode a PDO field of `bits` bits.

    Raises ObjectValueError for a value outside the kind's range.
    """
    if kind in SIGNED_KINDS:
        sign = 1 << bits - 1
        return checked(kind, (raw ^ sign) - sign)
    if kind in UNSIGNED_KINDS:
        return checked(kind, raw)
    if kind == "bool":
        return raw != 0
    octets = size(kind) or (bits + 7) // 8
    if raw >> 8 * octets:
        raise ObjectValueError(f"{kind} has no {bits} bits", sdo.LENGTH_TOO_HIGH)
    return decode(kind, raw.to_bytes(octets, "little"))


def _foreign(kind: Kind, value: object) -> ObjectValueError:
    return ObjectValueError(f"{value!r} is not a value of kind {kind}")


def _integer(kind: Kind, value: ObjectValue) -> int:
    if isinstance(value, bool):
        raise _foreign(kind, value)
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise _foreign(kind, value) from None


def _boolean(value: ObjectValue) -> bool:
    if isinstance(value, (str, bytes)) or value not in (0, 1):
        raise _foreign("bool", value)
    return bool(value)


def _text(kind: Kind, value: ObjectValue) -> str:
    if not isinstance(value, str):
        raise _foreign(kind, value)
    return value


def _encode_real(kind: Kind, value: ObjectValue) -> bytes:
    if isinstance(value, (str, bytes, bool)):
        raise _foreign(kind, value)
    letter, largest = _REALS[kind]
    try:
        return letter.pack(float(value))
    except OverflowError:
        code = sdo.VALUE_TOO_HIGH if value > 0 else sdo.VALUE_TOO_LOW
        raise ObjectValueError(f"{kind} goes up to {largest:g}", code) from None


def _encode_text(kind: Kind, value: ObjectValue) -> bytes:
    text = _text(kind, value)
    try:
        if kind == "string":
            return visible_octets(text)
        return text.encode(_ENCODINGS[kind])
    except UnicodeEncodeError:
        raise _foreign(kind, value) from None


def _decode_wide(octets: bytes) -> str:
    if len(octets) % 2:
        raise ObjectValueError(
            f"wstring has octets in pairs, not {len(octets)}", sdo.LENGTH_MISMATCH
        )
    try:
        return octets.decode("utf-16-le").rstrip("\0")
    except UnicodeDecodeError:
        raise ObjectValueError("wstring has half a character") from None


def _encode_time(kind: Kind, value: int) -> bytes:
    days, milliseconds = divmod(value // MILLISECOND, DAY)
    if kind == "time_of_day":
        days -= EPOCH_DAYS
    if not 0 <= days <= MAX_DAYS:
        code = sdo.VALUE_TOO_LOW if days < 0 else sdo.VALUE_TOO_HIGH
        raise ObjectValueError(f"{kind} has 0 to {MAX_DAYS} days, not {days}", code)
    return milliseconds.to_bytes(4, "little") + days.to_bytes(2, "little")


def _decode_time(kind: Kind, octets: bytes) -> int:
    time = milliseconds_of(int.from_bytes(octets, "little"))
    return (time + EPOCH if kind == "time_of_day" else time) * MILLISECOND
