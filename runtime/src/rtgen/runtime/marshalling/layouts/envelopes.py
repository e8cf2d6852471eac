"""Headers before bodies: of payloads (DDSI-RTPS 2.5, 10.2; DDS-XTypes 1.3, table 60), DHEADER."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rtgen.runtime.marshalling.layouts.packers import packer, struct_of

_BIG_ENDIAN = {
    (1, "final"): 0x00,
    (1, "appendable"): 0x00,
    (1, "mutable"): 0x02,
    (2, "final"): 0x06,
    (2, "appendable"): 0x08,
    (2, "mutable"): 0x0A,
}


def identifier(descriptor: Any, version: int, little_endian: bool) -> int:
    """Return the identifier of a type's representation, by XCDR version and byte order."""
    extensibility = getattr(descriptor, "extensibility", "final")
    return _BIG_ENDIAN[version, extensibility] | little_endian


def framed(number: int, body: bytes) -> bytes:
    """Return the payload of a body: header, body, and padding to a multiple of 4 octets."""
    padding = -len(body) % 4
    return b"%b%b%b" % (bytes((0, number, 0, padding)), body, bytes(padding))


def framing(
    order: str, format_: str, number: int | None, delimited: bool
) -> Callable[..., bytes]:
    """Return a function that packs a value, given as a `struct` format, with its headers.

    With a `number`, it returns a payload; `delimited`: a DHEADER precedes the value.
    """
    size = struct_of(order, format_).size
    headers = b""
    padding = 0
    if number is not None:
        padding = -size % 4
        headers = bytes((0, number, 0, padding))
    if delimited:
        headers += struct_of(order, "I").pack(size)
    pack = packer(order, f"{len(headers)}s{format_}{padding}x")
    return partial(pack, headers)
