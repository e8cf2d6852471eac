"""Code sets of other processes, for messages on texts that they cannot have.

CORBA 3.3 part 2, 7.10.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from typing import Any, Final

import msgspec
import omniORB
from omniORB import CORBA

from rtgen.runtime.corba.iors import components

_TAG_CODE_SETS: Final = 1
_CODE_SETS: Final = {
    0x00010001: ("ISO 8859-1", "latin-1"),
    0x00010020: ("ISO 646", "ascii"),
    0x05010001: ("UTF-8", "utf-8"),
}
"""Registered code sets of omniORB (OSF registry): names, and Python's codecs."""
_REMEDY: Final = (
    "start it with -ORBnativeCharCodeSet UTF-8 (OpenRTM: corba.args in rtc.conf)"
)


def unsendable(reference: Any, arguments: Iterable[object]) -> str:
    """Return why a call with these arguments, or its reply, raised DATA_CONVERSION."""
    number = _native(omniORB.orb.object_to_string(reference))
    name, codec = _CODE_SETS.get(number, (f"{number:#010x}", "ascii"))
    where = f"the other process has the code set {name}; {_REMEDY}"
    for text in _texts(arguments):
        try:
            text.encode(codec)
        except UnicodeEncodeError as error:
            return f"{text[:80]!r} has {text[error.start]!r}, and {where}"
    return f"a text cannot be converted: {where}"


def _native(ior: str) -> int:
    """Return the native code set of the characters of an object; 0 if it states none."""
    octets = components(ior).get(_TAG_CODE_SETS, b"")
    order = "<" if octets[:1] == b"\1" else ">"
    try:
        (number,) = struct.unpack_from(f"{order}I", octets, 4)
    except struct.error:
        return 0
    return int(number)


def _texts(values: Iterable[object]) -> Iterator[str]:
    """Yield the texts in arguments."""
    for value in values:
        if isinstance(value, str):
            yield value
        elif isinstance(value, list | tuple):
            yield from _texts(value)
        elif isinstance(value, CORBA.Any):
            yield from _texts([value.value()])
        elif isinstance(value, msgspec.Struct):
            fields: Any = value.__struct_fields__
            yield from _texts(getattr(value, name) for name in fields)
        elif isinstance(getattr(value, "__dict__", None), dict):
            yield from _texts(vars(value).values())
