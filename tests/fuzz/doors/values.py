"""Doors for encoded values: CDR, XCDR1, XCDR2, and values of `any` with their type codes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from itertools import chain
from pathlib import Path
from random import Random
from typing import Any

import octets
from octets import Encoding

from doors import Door
from rtgen.runtime import idl
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.values import decoded, encoded

_HEADER_LENGTH = 2
"""Octets before an input: the number of the encoding that reads the rest."""
_COUNTS = (0, 0, 1, 1, 1, 2, 3, 4, 5, 8, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 1)


@cache
def _types() -> tuple[type[Any], ...]:
    modules = (*octets._reference(), *octets._constructs())
    return tuple(chain.from_iterable(map(octets.types, modules)))


@cache
def _encoding(name: str, number: int) -> Encoding | None:
    """Return an encoding of a type, big- or little-endian; None if it has none of that name."""
    type_ = _types()[number // 2 % len(_types())]
    found = Encoding(type_, name, bool(number % 2))
    least = octets._least(found)
    return None if least is None else replace(found, least=least)


def _door(name: str, _folder: Path) -> Door:
    def enter(data: bytes) -> bool:
        encoding = _encoding(name, int.from_bytes(data[:_HEADER_LENGTH], "little"))
        if encoding is None:
            return False
        return octets._tried(encoding, data[_HEADER_LENGTH:]).endswith("value")

    def make(chance: Random) -> bytes:
        number = chance.randrange(2 * len(_types()))
        head = number.to_bytes(_HEADER_LENGTH, "little")
        if (encoding := _encoding(name, number)) is None:
            return head
        grown = encoding.least
        for _ in range(chance.randrange(12)):
            grown = octets.changed(chance, grown, encoding.little_endian)
        return head + grown

    return Door(enter, make)


def _type_code(_folder: Path) -> Door:
    """Return the door for values of `any`, little-endian: the type code, then the value."""

    def enter(data: bytes) -> bool:
        try:
            value = decoded(idl.ANY, data, True)
        except CdrError:
            return False
        try:
            written = encoded(idl.ANY, value, True)
        except CdrError:
            return False
        if encoded(idl.ANY, decoded(idl.ANY, written, True), True) != written:
            raise octets.ViolationError(f"{written.hex()} is read as another value")
        return True

    return Door(enter, partial(_any, depth=0))


def _any(chance: Random, depth: int) -> bytes:
    """Return words: mostly kinds of type codes, lengths of encapsulations, texts and ids."""
    parts: list[bytes] = []
    for _ in range(chance.randrange(1, 12)):
        match chance.randrange(5):
            case 0 | 1:
                parts.append(struct.pack("<I", chance.randrange(36)))
            case 2:
                parts.append(struct.pack("<I", chance.choice(_COUNTS)))
            case 3:
                text = chance.choice((b"", b"IDL:RTC/Time:1.0", b"a", b"\xff")) + b"\0"
                padding = bytes(-len(text) % 4)
                parts.append(struct.pack("<I", len(text)) + text + padding)
            case _ if depth < 4:
                inner = b"\1\0\0\0" + _any(chance, depth + 1)
                parts.append(struct.pack("<I", len(inner)) + inner)
            case _:
                parts.append(struct.pack("<i", -chance.randrange(64)))
    return b"".join(parts)


DOORS: dict[str, Callable[[Path], Door]] = {
    "cdr": partial(_door, "CDR"),
    "xcdr1": partial(_door, "XCDR1"),
    "xcdr2": partial(_door, "XCDR2"),
    "type-code": _type_code,
}
