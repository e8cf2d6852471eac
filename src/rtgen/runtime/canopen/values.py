"""Encodes values of objects for SDO and PDO (data types of CiA 301, 7.1.6).

Times are integers in ns (time of day: since 1970, UTC); on the wire they count milliseconds.
"""

from __future__ import annotations

import operator
import struct
from typing import Final

from rtgen.runtime.canopen import sdo
from rtgen.runtime.canopen.description import Kind, ObjectValue
from rtgen.runtime.canopen.frames import MILLISECOND

SIGNED_BITS: Final[dict[Kind, int]] = {
    "i8": 8, "i16": 16, "i24": 24, "i32": 32,
    "i40": 40, "i48": 48, "i56": 56, "i64": 64,
}  # fmt: skip
UNSIGNED_BITS: Final[dict[Kind, int]] = {
    "u8": 8, "u16": 16, "u24": 24, "u32": 32,
    "u40": 40, "u48": 48, "u56": 56, "u64": 64,
}  # fmt: skip

_TIMES: Final[tuple[Kind, ...]] = ("time_of_day", "time_difference")
_REALS: Final[dict[Kind, tuple[struct.Struct, float]]] = {
    "r32": (struct.Struct("<f"), 3.4028234663852886e38),
    "r64": (struct.Struct("<d"), 1.7976931348623157e308),
}
BITS: Final[dict[Kind, int]] = {
    "bool": 1, "char": 8, "r32": 32, "r64": 64,
    "time_of_day": 48, "time_difference": 48,
    **SIGNED_BITS, **UNSIGNED_BITS,
}  # fmt: skip
"""Size of a value in bits; text and octets have variable length."""

_ENCODINGS: Final[dict[Kind, str]] = {
    "char": "latin-1", "string": "utf-8", "wstring": "utf-16-le",
}  # fmt: skip
_DAY: Final = 86_400_000
_EPOCH_DAYS: Final = 5113
"""1984-01-01 in days since 1970."""
_MILLISECONDS: Final = (1 << 28) - 1
_MAX_DAYS: Final = 0xFFFF


class ObjectValueError(ValueError):
    """An invalid value of an object; `code` is the corresponding SDO abort code."""

    def __init__(self, message: str, code: int = sdo.VALUE_INVALID) -> None:
        super().__init__(message)
        self.code = code


def size(kind: Kind) -> int | None:
    """Size of a value in SDO in octets; None for variable length."""
    bits = BITS.get(kind)
    return None if bits is None else (bits + 7) // 8


def limits(kind: Kind) -> tuple[int, int] | None:
    """The range of an integer kind, None for others."""
    if kind in SIGNED_BITS:
        half = 1 << SIGNED_BITS[kind] - 1
        return -half, half - 1
    if kind in UNSIGNED_BITS:
        return 0, (1 << UNSIGNED_BITS[kind]) - 1
    return None


def zero(kind: Kind) -> ObjectValue:
    """The value of an object without a default."""
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
    return _EPOCH_DAYS * _DAY * MILLISECOND if kind == "time_of_day" else 0


def encode(kind: Kind, value: ObjectValue) -> bytes:
    """Encode a value. Raises ObjectValueError if it does not fit the kind."""
    if kind in SIGNED_BITS or kind in UNSIGNED_BITS:
        number = checked(kind, _integer(kind, value))
        octets = BITS[kind] // 8
        return int(number).to_bytes(octets, "little", signed=kind in SIGNED_BITS)
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
    wanted = size(kind)
    if wanted is not None and len(octets) != wanted:
        code = sdo.LENGTH_TOO_HIGH if len(octets) > wanted else sdo.LENGTH_TOO_LOW
        raise ObjectValueError(f"{kind} has {wanted} octets, not {len(octets)}", code)
    if kind in SIGNED_BITS:
        return int.from_bytes(octets, "little", signed=True)
    if kind in UNSIGNED_BITS:
        return int.from_bytes(octets, "little")
    if kind == "bool":
        return octets != b"\0"
    if kind in _REALS:
        return float(_REALS[kind][0].unpack(octets)[0])
    if kind == "char":
        return octets.decode("latin-1")
    if kind == "string":
        return _decode_visible(octets.rstrip(b"\0"))
    if kind == "wstring":
        return _decode_wide(octets)
    if kind in _TIMES:
        return _decode_time(kind, octets)
    return bytes(octets)


def uploaded(kind: Kind, octets: bytes) -> ObjectValue:
    """The value of octets that SDO gave. Raises ObjectValueError, as `decode`.

    Servers that do not indicate the size of an expedited value send 4 octets.
    """
    wanted = size(kind)
    return decode(kind, octets if wanted is None else octets[:wanted])


def checked(
    kind: Kind,
    value: ObjectValue,
    low: int | float | None = None,
    high: int | float | None = None,
) -> ObjectValue:
    """Check a value against limits and the range of its kind. Raises ObjectValueError."""
    if isinstance(value, (str, bytes)):
        return value
    own = limits(kind)
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
    raw = int.from_bytes(octets, "little", signed=kind in SIGNED_BITS)
    return raw & (1 << bits) - 1


def from_bits(kind: Kind, raw: int, bits: int) -> ObjectValue:
    """Decode a PDO field of `bits` bits.

    Raises ObjectValueError for a value outside the kind's range.
    """
    if kind in SIGNED_BITS:
        sign = 1 << bits - 1
        return checked(kind, (raw ^ sign) - sign)
    if kind in UNSIGNED_BITS:
        return checked(kind, raw)
    if kind == "bool":
        return raw != 0
    octets = size(kind) or (bits + 7) // 8
    if raw >> 8 * octets:
        raise ObjectValueError(f"{kind} has no {bits} bits", sdo.LENGTH_TOO_HIGH)
    return decode(kind, raw.to_bytes(octets, "little"))


def _foreign(kind: Kind, value: object) -> ObjectValueError:
    return ObjectValueError(f"{value!r} is no value of kind {kind}")


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
            return _visible_octets(text)
        return text.encode(_ENCODINGS[kind])
    except UnicodeEncodeError:
        raise _foreign(kind, value) from None


def _visible_octets(text: str) -> bytes:
    """Encode a VISIBLE_STRING: ASCII by CiA 301, else Latin-1, as used by many devices.

    UTF-8 if Latin-1 lacks a character, or would be decoded as UTF-8.
    """
    try:
        octets = text.encode("latin-1")
    except UnicodeEncodeError:
        octets = b""
    if _decode_visible(octets) == text:
        return octets
    return text.encode("utf-8")


def _decode_visible(octets: bytes) -> str:
    """Decode text of a device: UTF-8 if valid, else Latin-1, which never fails."""
    try:
        return octets.decode("utf-8")
    except UnicodeDecodeError:
        return octets.decode("latin-1")


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
    days, milliseconds = divmod(value // MILLISECOND, _DAY)
    if kind == "time_of_day":
        days -= _EPOCH_DAYS
    if not 0 <= days <= _MAX_DAYS:
        code = sdo.VALUE_TOO_LOW if days < 0 else sdo.VALUE_TOO_HIGH
        raise ObjectValueError(f"{kind} has 0 to {_MAX_DAYS} days, not {days}", code)
    return milliseconds.to_bytes(4, "little") + days.to_bytes(2, "little")


def _decode_time(kind: Kind, octets: bytes) -> int:
    milliseconds = int.from_bytes(octets[:4], "little") & _MILLISECONDS
    days = int.from_bytes(octets[4:], "little")
    if kind == "time_of_day":
        days += _EPOCH_DAYS
    return (days * _DAY + milliseconds) * MILLISECOND
