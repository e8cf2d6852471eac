"""Values of messages and files that others write, which may have any form."""

from __future__ import annotations

from typing import TypeVar

import msgspec

_T = TypeVar("_T")
_TOO_DEEP = "values are nested too deep"


def from_json(octets: bytes | str, type_: type[_T]) -> _T:
    """Return the value of a JSON text. Raises ValueError if it is none of the type."""
    try:
        return msgspec.json.decode(octets, type=type_)
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error


def from_msgpack(octets: bytes, type_: type[_T]) -> _T:
    """Return the value of octets in MessagePack. Raises ValueError as `from_json` does."""
    try:
        return msgspec.msgpack.decode(octets, type=type_)
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error
