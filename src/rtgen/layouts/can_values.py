"""Values of objects as SDO carries them (CiA 301, 7.1.6): little endian, a BOOLEAN in one octet."""

from __future__ import annotations

import struct

from rtgen.model.canopen import BITS, SIGNED, DataType, NodeRelative, Value

_REALS = {DataType.REAL32: "<f", DataType.REAL64: "<d"}
_ENCODINGS = {
    DataType.VISIBLE_STRING: "utf-8",
    DataType.VISIBLE_CHAR: "latin-1",
    DataType.UNICODE_STRING: "utf-16-le",
}


class CanValueError(ValueError):
    """There are no such octets; the message says why."""


def octets(data_type: int, value: Value) -> bytes:
    """The octets of a value. Raises CanValueError for one that its data type does not have."""
    if isinstance(value, bytes):
        return value
    try:
        code = DataType(data_type)
        if isinstance(value, str):
            if code == DataType.VISIBLE_STRING:
                return _visible(value)
            return value.encode(_ENCODINGS[code])
        if code in _REALS:
            return struct.pack(_REALS[code], value)
        if isinstance(value, int):
            size = (BITS[code] + 7) // 8
            return value.to_bytes(size, "little", signed=code in SIGNED)
    except UnicodeEncodeError as error:
        encoding = "Latin-1" if error.encoding == "latin-1" else "UTF-16"
        message = f"{value!r} has a character that is not of {encoding}"
        raise CanValueError(message) from None
    except (KeyError, ValueError, OverflowError, struct.error):
        pass
    if isinstance(value, NodeRelative):
        raise CanValueError(f"{value} depends on the node-id, which is not known")
    raise CanValueError(f"{value!r} is no value of data type {data_type:04X}h")


def _visible(text: str) -> bytes:
    """Latin-1 unless that would be read back as UTF-8; as the runtime sends strings."""
    try:
        octets = text.encode("latin-1")
    except UnicodeEncodeError:
        return text.encode("utf-8")
    try:
        read_back = octets.decode("utf-8")
    except UnicodeDecodeError:
        return octets
    return octets if read_back == text else text.encode("utf-8")
