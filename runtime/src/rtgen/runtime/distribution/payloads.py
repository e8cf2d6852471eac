"""Payloads received from programs of all kinds."""

from __future__ import annotations

from typing import TypeVar

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.xcdr import deserialize

_T = TypeVar("_T", bound=DataType)
_UNIT = 4
"""Payloads of RTPS are padded to a multiple of this number of octets (DDSI-RTPS 2.5, 9.4.5.4)."""


def received(type_: type[_T], octets: bytes) -> _T:
    """Return the value of a payload. Raises CdrError.

    Programs older than DDS-XTypes 1.3 do not send the number of padding octets (7.6.3.1.2).
    """
    try:
        return deserialize(type_, octets)
    except CdrError:
        if len(octets) % _UNIT or len(octets) <= _UNIT or octets[3] & 3:
            raise
        for padding in range(1, _UNIT):
            try:
                return deserialize(type_, octets[:-padding])
            except CdrError:
                continue
        raise
