"""Parts of object references (IORs): CORBA 3.3 part 2, 9.7.2 (IIOP profiles)."""

from __future__ import annotations

import struct
from typing import Final, NamedTuple

from rtgen.runtime.marshalling.octets import read_reference

_IIOP: Final = 0
"""The tag of a profile that has the object key."""
_MAX_COMPONENTS: Final = 64


class Profile(NamedTuple):
    """The IIOP profile of a reference; `components` are the octets of its tagged components."""

    place: str
    key: bytes
    components: dict[int, bytes]


def place(ior: str) -> str:
    """Return the address of the process of an IOR, `HOST:PORT`; empty without."""
    found = _profile(ior)
    return "" if found is None else found.place


def key(ior: str) -> bytes:
    """Return the object key of an IOR, which equivalent references share; empty without."""
    found = _profile(ior)
    return b"" if found is None else found.key


def components(ior: str) -> dict[int, bytes]:
    """Return the tagged components of an IOR by their tags."""
    found = _profile(ior)
    return {} if found is None else found.components


def _profile(ior: str) -> Profile | None:
    """Return the IIOP profile of an IOR; None without, or if its octets are cut off."""
    octets = bytes.fromhex(ior.removeprefix("IOR:"))
    try:
        reference, _ = read_reference(octets, 4, bool(octets[0]))
        profiles = () if reference is None else reference.profiles
        found = next((each for tag, each in profiles if tag == _IIOP), None)
        return None if found is None else _read(found)
    except (IndexError, ValueError, struct.error):
        return None


def _read(octets: bytes) -> Profile:
    """Read an IIOP profile. Raises struct.error if it is cut off."""
    order = "<" if octets[:1] == b"\1" else ">"
    at = 4

    def number(form: str, size: int) -> int:
        nonlocal at
        at += -at % size
        (found,) = struct.unpack_from(f"{order}{form}", octets, at)
        at += size
        return int(found)

    def sequence() -> bytes:
        nonlocal at
        size = number("I", 4)
        at += size
        if at > len(octets):
            raise struct.error("a sequence is cut off")
        return octets[at - size : at]

    host = sequence().rstrip(b"\0").decode("latin-1")
    port = number("H", 2)
    object_key = sequence()
    tagged: dict[int, bytes] = {}
    if octets[2:3] > b"\0":  # IIOP 1.1 and later
        for _ in range(min(number("I", 4), _MAX_COMPONENTS)):
            tag = number("I", 4)
            tagged[tag] = sequence()
    return Profile(f"{host}:{port}", object_key, tagged)
