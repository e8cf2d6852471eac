"""Converts texts to values; values of data types, their time stamps and octets."""

from __future__ import annotations

import time
from typing import Any

import omniORB
from omniORB import CORBA, cdrMarshal, cdrUnmarshal, tcInternal

NUMBERS = {
    tcInternal.tv_short,
    tcInternal.tv_long,
    tcInternal.tv_ushort,
    tcInternal.tv_ulong,
    tcInternal.tv_boolean,
    tcInternal.tv_char,
    tcInternal.tv_octet,
    tcInternal.tv_longlong,
    tcInternal.tv_enum,
}


def split(text: str) -> list[str]:
    """Return the trimmed items of a list of texts; none of an empty text."""
    return [item.strip() for item in text.split(",")] if text.strip() else []


def toBool(text: str, yes: str, no: str, default: bool) -> bool:
    word = text.strip().upper()
    return {yes.upper(): True, no.upper(): False}.get(word, default)


def stringTo(value: Any, text: str) -> tuple[bool, Any]:
    """Convert a text to the type of a parameter; return whether it succeeded, and the value.

    A bool is an int here, and an int accepts plain decimals only.
    """
    if not text:
        return False, value
    try:
        if isinstance(value, list):
            kind = type(value[0])
            return True, [_plain(kind, item) for item in split(text)]
        return True, _plain(type(value), text)
    except (ValueError, TypeError, IndexError):
        return False, value


def _plain(kind: type, text: str) -> Any:
    if issubclass(kind, int):
        return int(text)
    if kind in (float, str):
        return kind(text)
    raise TypeError(kind)


def instantiateDataType(kind: Any) -> Any:
    """Return a value of a data type with zeros and empty texts and lists.

    It cannot be marshalled if the type contains octet or char sequences, chars or enums.
    """
    if isinstance(kind, int):
        descriptor: Any = (kind,)
    elif isinstance(kind, tuple):
        descriptor = kind
    else:
        descriptor = omniORB.findType(kind._NP_RepositoryId)
    code = descriptor[0]
    if code == tcInternal.tv_alias:
        return instantiateDataType(descriptor[3])
    if code in NUMBERS or code == tcInternal.tv_ulonglong:
        return 0
    if code in (tcInternal.tv_float, tcInternal.tv_double, tcInternal.tv_longdouble):
        return 0.0
    if code in (tcInternal.tv_sequence, tcInternal.tv_array):
        return []
    if code in (tcInternal.tv_string, tcInternal.tv_wstring, tcInternal.tv_wchar):
        return ""
    if code == tcInternal.tv_struct:
        made = descriptor[1]
        return made(*(instantiateDataType(item) for item in descriptor[5::2]))
    return None


def setTimestamp(data: Any) -> None:
    """Set `tm` to the wall clock."""
    now = time.time_ns()
    data.tm.sec, data.tm.nsec = divmod(now, 1_000_000_000)


def type_code(value: Any) -> Any:
    return CORBA.TypeCode(CORBA.id(type(value)))


def to_octets(value: Any, little_endian: bool) -> bytes:
    octets: bytes = cdrMarshal(type_code(value), value, little_endian)
    return octets


def from_octets(like: Any, octets: bytes, little_endian: bool) -> Any:
    return cdrUnmarshal(type_code(like), octets, little_endian)
