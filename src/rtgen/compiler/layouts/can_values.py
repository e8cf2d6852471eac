"""Encoding of values for SDO (CiA 301, 7.1.6): little endian, a BOOLEAN in one octet."""

from __future__ import annotations

import struct

from rtgen.compiler.model.canopen import NodeRelative, Value
from rtgen.facts.canopen import (
    BITS,
    CHARACTER_ENCODING,
    KINDS,
    REAL_CODES,
    SIGNED,
    WIDE_ENCODING,
    DataType,
    visible_octets,
)

_ENCODINGS = {
    DataType.VISIBLE_CHAR: CHARACTER_ENCODING,
    DataType.UNICODE_STRING: WIDE_ENCODING,
}


class CanValueError(ValueError):
    """A value that cannot be encoded; the message is the reason."""


def octets(data_type: int, value: Value) -> bytes:
    """Encode a value. Raises CanValueError if it is not a value of the data type."""
    if isinstance(value, bytes):
        return value
    try:
        code = DataType(data_type)
        if isinstance(value, str):
            if code == DataType.VISIBLE_STRING:
                return visible_octets(value)
            return value.encode(_ENCODINGS[code])
        if KINDS[code] in REAL_CODES:
            return struct.pack(REAL_CODES[KINDS[code]], value)
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
    raise CanValueError(f"{value!r} is not a value of data type {data_type:04X}h")
