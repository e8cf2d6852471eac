"""Fuzzing of generated decoders: any octets give a value, or CdrError."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from itertools import chain
from pathlib import Path
from random import Random
from types import ModuleType
from typing import Any

from fuzzing import ViolationError, log_uniform
from generated import Generated, generate

from rtgen.compiler.frontends.idl import load
from rtgen.runtime import Servant, xcdr
from rtgen.runtime.cdr import CdrError

ROOT = Path(__file__).parents[2]
CONSTRUCTS = (
    ROOT / "tests/fuzz/octets.idl",
    ROOT / "tests/compiler/types/constructs.idl",
)
VERSIONS = {"CDR": None, "XCDR1": 1, "XCDR2": 2}
"""The encodings, with the version of XCDR."""

_MAX_OCTETS = 1000
_CHANGES = 40
_COUNTS = (0, 0, 1, 1, 1, 2, 3, 4, 5, 8, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 1)


@dataclass(frozen=True)
class Encoding:
    """A type, one of its encodings, and octets that decode to a value."""

    type: type[Any]
    name: str
    little_endian: bool
    least: bytes = b""

    def read(self, data: bytes) -> Any:
        """Decode a value; raises CdrError."""
        version = VERSIONS[self.name]
        if version is None:
            return self.type.from_cdr(data, self.little_endian)
        return xcdr.decode(self.type, data, version, self.little_endian)

    def write(self, value: Any) -> bytes:
        """Encode a value; raises CdrError."""
        version = VERSIONS[self.name]
        if version is None:
            return bytes(self.type.to_cdr(value, self.little_endian))
        return xcdr.encode(self.type, value, version, self.little_endian)


class OctetsTarget:
    """The types of the reference package, and of packages with every construct."""

    def __init__(self, folder: Path) -> None:
        del folder
        found = chain.from_iterable(map(types, (*_reference(), *_constructs())))
        self.encodings = list(chain.from_iterable(map(encodings, found)))

    def make(self, number: int) -> bytes:
        """Return octets to decode as the type that the number selects."""
        chance = Random(number)
        return chance.randbytes(log_uniform(1, 300, chance.random()))

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Decode the octets, and variants of them."""
        chance = Random(number)
        encoding = chance.choice(self.encodings)
        yield _tried(encoding, data)
        for _, outcome in explore(encoding, chance, _CHANGES):
            yield outcome


def explore(
    encoding: Encoding, chance: Random, changes: int
) -> Iterator[tuple[bytes, str]]:
    """Decode variants of the encoding of the type's least value; yield each with its outcome.

    Octets that decode are the start of the next change, so that values become deep.
    """
    octets = encoding.least
    for _ in range(changes):
        altered = changed(chance, octets, encoding.little_endian)
        outcome = _tried(encoding, altered)
        if outcome.endswith("value"):
            octets = altered
        yield altered, outcome


def _tried(encoding: Encoding, data: bytes) -> str:
    """Decode octets; a value, once encoded, must decode to the same value."""
    try:
        value = encoding.read(data)
    except CdrError:
        return f"{encoding.name} CdrError"
    if value is None:  # a null value
        return f"{encoding.name} read-only value"
    try:
        written = encoding.write(value)
    except CdrError:
        return f"{encoding.name} read-only value"
    if encoding.write(encoding.read(written)) != written:
        name = f"{encoding.type.__name__} in {encoding.name}"
        raise ViolationError(f"{name} reads {written.hex()} as another value")
    return f"{encoding.name} value"


def changed(chance: Random, octets: bytes, little_endian: bool) -> bytes:
    """Return changed octets: a count with octets for its elements, a number, or a few anywhere."""
    data = bytearray(octets)
    place = chance.randrange(len(data) + 1)
    order = "<" if little_endian else ">"
    match chance.randrange(8):
        case 0 | 1 | 2:
            place &= ~3
            count = chance.choice((1, 1, 2, 3))
            size = chance.choice((0, 1, 2, 3, 4, 7, 8, 12, 16, 20, 24, 32, 40, 48, 56))
            data[place : place + 4] = struct.pack(f"{order}I", count) + bytes(size)
        case 3:
            place &= ~3
            data[place : place + 4] = struct.pack(f"{order}I", chance.choice(_COUNTS))
        case 4:
            text = (
                chance.choice((b"", b"a", b"abc", "\u3042".encode(), b"\xff")) + b"\0"
            )
            padding = bytes(-len(text) % 4)
            data[place : place + 4] = (
                struct.pack(f"{order}I", len(text)) + text + padding
            )
        case 5:
            data[place : place + 1] = chance.randbytes(1)
        case 6:
            del data[place : place + chance.choice((1, 2, 4, 8))]
        case _:
            data[place:place] = chance.randbytes(chance.randint(1, 8))
    return bytes(data[:_MAX_OCTETS])


def encodings(type_: type[Any]) -> Iterator[Encoding]:
    """Yield the encodings of a type, in both byte orders."""
    for name in VERSIONS:
        for little_endian in (False, True):
            encoding = Encoding(type_, name, little_endian)
            least = _least(encoding)
            if least is not None:
                yield Encoding(type_, name, little_endian, least)


def _least(encoding: Encoding) -> bytes | None:
    """Return the encoding of a default or empty value, or the fewest zeros that decode to one."""
    for make in (encoding.type, list):
        with suppress(AttributeError, CdrError, TypeError):
            written = encoding.write(make())
            encoding.read(written)
            return written
    for length in range(300):
        with suppress(CdrError):
            encoding.read(bytes(length))
            return bytes(length)
    return None


def types(module: ModuleType) -> Iterator[type[Any]]:
    """Yield the types and codecs that a generated module defines."""
    for value in vars(module).values():
        own = getattr(value, "__module__", "") == module.__name__
        reads = callable(getattr(value, "from_cdr", None))
        if not (own and reads and isinstance(value, type)):
            continue
        if not issubclass(value, Servant):  # may have an operation of that name
            yield value


_REFERENCE = (
    *("basic_data_type", "extended_data_types", "intellirobot", "interface_data_types"),
    *("obstacles", "ref_hard_rh3_pro", "timed_velocity"),
)


def _reference() -> Iterator[ModuleType]:
    for name in _REFERENCE:
        yield import_module(f"refrobots._idl.{name}")


def _constructs() -> Iterator[ModuleType]:
    for path in CONSTRUCTS:
        model = load([path], root=path.parent).model
        modules = Generated(generate(model)).load()
        yield from modules.values()
