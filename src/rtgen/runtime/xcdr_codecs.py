"""Parts of XCDR codecs: formats, scalars, runs of scalars, faults.

DDS-XTypes 1.3, 7.4. A codec appends a value to a buffer, and reads one from octets that start
at an origin of alignment. Delimited content (after a DHEADER, or of a parameter) is sliced and
read from 0: it starts at a multiple of 4, and nothing in it is aligned to more.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice
from operator import attrgetter
from struct import Struct
from typing import Any, NamedTuple, NoReturn, TypeAlias

from rtgen.runtime.cdr import BOOLEAN
from rtgen.runtime.cdr_values import (
    quad_octets,
    quad_value,
    unit_character,
    unit_number,
)
from rtgen.runtime.faults import LOCATED, Fault, located

Octets: TypeAlias = bytes | memoryview
"""The input; slices of it are views, so that nesting costs no copies."""

Write: TypeAlias = Callable[[bytearray, Any], None]
Read: TypeAlias = Callable[[Octets, int], tuple[Any, int]]
Step: TypeAlias = Callable[[Octets, int, list[Any]], int]
Build: TypeAlias = Callable[[Iterator[Any]], Any]

PADDING = (b"", bytes(3), bytes(2), bytes(1))
"""Padding to a multiple of 4 by the offset modulo 4."""


class Format(NamedTuple):
    """The format of a codec: XCDR version 1 or 2, byte order, or the form of keys."""

    version: int
    little: bool
    key: bool = False

    @property
    def order(self) -> str:
        """The prefix of `struct` formats."""
        return "<" if self.little else ">"

    @property
    def widest(self) -> int:
        """The largest alignment."""
        return 8 if self.version == 1 else 4


class UnsupportedError(TypeError):
    """A type that XCDR does not define; `path` is that of the member."""

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.path = ""


def refuse(failure: Exception, part: str) -> NoReturn:
    """Raises the failure with its path, or with one more component of the path."""
    if isinstance(failure, struct.error):
        failure = Fault("truncated")
    elif isinstance(failure, KeyError):
        failure = Fault(f"{failure.args[0]!r} is not one of its values")
    raise located(failure, part)


def left(data: Octets, offset: int, size: int) -> None:
    """Raises Fault when fewer octets remain than are read."""
    if size > len(data) - offset:
        rest = max(len(data) - offset, 0)
        raise ValueError(f"truncated: {size} octets are needed, {rest} are left")


@dataclass(frozen=True, slots=True)
class Scalar:
    """A value of fixed size: its `struct` code, its alignment, the conversions both ways."""

    code: str
    size: int
    align: int
    encode: Callable[[Any], Any] | None = None
    decode: Callable[[Any], Any] | None = None


@dataclass(frozen=True, slots=True)
class Codec:
    """Writer and reader of the values of a type.

    `least` is the minimum size of a value in octets. `length_code` is that of the EMHEADER
    (7.4.3.4.2). A `primitive` type needs no DHEADER as an element. A `run` consists of scalars
    only, so that it can be merged into a longer one.
    """

    write: Write
    read: Read
    least: int
    length_code: int = 4
    primitive: bool = False
    run: Run | None = None


class Run:
    """Consecutive scalars, packed and unpacked by one `struct` call.

    `paths` lead from the value to each (empty: the value itself), `labels` say so with the names
    of the definition. `builds` make the members from
    the unpacked scalars; `build` makes the value itself, if the run is all of it.
    """

    def __init__(
        self,
        format_: Format,
        scalars: Sequence[Scalar],
        paths: Sequence[str],
        builds: Sequence[Build],
        labels: Sequence[str],
        build: Build | None = None,
    ) -> None:
        self.scalars = tuple(scalars)
        self.paths = tuple(paths)
        self.builds = tuple(builds)
        self.labels = tuple(labels)
        self.build = build
        self.format = format_
        widest = format_.widest
        self.mask = widest - 1
        self.structs = tuple(
            Struct(format_.order + _arranged(scalars, phase, widest))
            for phase in range(widest)
        )
        self.least = sum(scalar.size for scalar in scalars)

    @property
    def plain(self) -> bool:
        """Whether reading needs no conversion."""
        return all(build is next for build in self.builds)

    def size(self, offset: int) -> int:
        """The number of octets of the run at an offset."""
        return self.structs[offset & self.mask].size

    def values(self) -> Callable[[Any], Sequence[Any]]:
        """The function that gets the scalars of a value, converted for `struct`."""
        get = _getter(self.paths)
        encodes = [(i, s.encode) for i, s in enumerate(self.scalars) if s.encode]
        if not encodes:
            return get

        def converted(value: Any) -> Sequence[Any]:
            items = list(get(value))
            for index, encode in encodes:
                items[index] = encode(items[index])
            return items

        return converted

    def writer(self) -> Write:
        """The function that writes the run of a value."""
        values, mask = self.values(), self.mask
        packs = [s.pack for s in self.structs]

        def write(out: bytearray, value: Any) -> None:
            out += packs[len(out) & mask](*values(value))

        return write

    def reader(self) -> Step:
        """The function that reads the run and appends the members."""
        mask = self.mask
        readers = [(s.unpack_from, s.size) for s in self.structs]
        builds = self.builds

        def read_plain(data: Octets, offset: int, values: list[Any]) -> int:
            unpack, size = readers[offset & mask]
            try:
                values += unpack(data, offset)
            except LOCATED as failure:
                self._refuse(data, offset, failure)
            return offset + size

        def read(data: Octets, offset: int, values: list[Any]) -> int:
            unpack, size = readers[offset & mask]
            try:
                scalars = iter(unpack(data, offset))
                for build in builds:
                    values.append(build(scalars))
            except LOCATED as failure:
                self._refuse(data, offset, failure)
            return offset + size

        return read_plain if self.plain else read

    def many(self, build: Build) -> Callable[[Octets, int, int], tuple[list[Any], int]]:
        """The function that reads a number of values that consist of the run."""
        mask, structs = self.mask, self.structs

        def read(data: Octets, offset: int, count: int) -> tuple[list[Any], int]:
            values: list[Any] = []
            try:
                if (offset + structs[offset & mask].size) & mask == offset & mask:
                    one = structs[offset & mask]
                    end = offset + count * one.size
                    left(data, offset, count * one.size)
                    for scalars in one.iter_unpack(data[offset:end]):
                        values.append(build(iter(scalars)))
                    return values, end
                for _ in range(count):
                    one = structs[offset & mask]
                    values.append(build(iter(one.unpack_from(data, offset))))
                    offset += one.size
            except LOCATED as failure:
                at = offset
                if (offset + structs[offset & mask].size) & mask == offset & mask:
                    at += len(values) * structs[offset & mask].size
                try:
                    self._refuse(data, at, failure)
                except Fault as fault:
                    refuse(fault, f"[{len(values)}]")
            return values, offset

        return read

    def _refuse(self, data: Octets, offset: int, failure: Exception) -> NoReturn:
        """Raises the fault of the scalar that cannot be read."""
        for scalar, label in zip(self.scalars, self.labels, strict=True):
            offset += -offset % min(scalar.align, self.format.widest)
            try:
                left(data, offset, scalar.size)
                code = self.format.order + scalar.code
                (value,) = struct.unpack_from(code, data, offset)
                if scalar.decode is not None:
                    scalar.decode(value)
            except LOCATED as found:
                refuse(found, label)
            offset += scalar.size
        refuse(failure, "")


def _getter(paths: Sequence[str]) -> Callable[[Any], Sequence[Any]]:
    if not paths:
        return lambda value: ()
    if len(paths) > 1:
        return attrgetter(*paths)
    if not paths[0]:
        return lambda value: (value,)
    one = attrgetter(paths[0])
    return lambda value: (one(value),)


def _arranged(scalars: Sequence[Scalar], phase: int, widest: int) -> str:
    """The `struct` format of scalars that start at offset `phase`."""
    texts = []
    offset = phase
    for scalar in scalars:
        padding = -offset % min(scalar.align, widest)
        texts.append(f"{padding}x{scalar.code}" if padding else scalar.code)
        offset += padding + scalar.size
    return "".join(texts)


def scalar_codec(format_: Format, scalar: Scalar, primitive: bool) -> Codec:
    """The codec of a scalar by itself."""
    build: Build = next if scalar.decode is None else partial(_decoded, scalar.decode)
    run = Run(format_, [scalar], [""], [build], [""])
    step = run.reader()

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        values: list[Any] = []
        offset = step(data, offset, values)
        return values[0], offset

    code = {1: 0, 2: 1, 4: 2, 8: 3}.get(scalar.size, 4)
    return Codec(run.writer(), read, scalar.size, code, primitive, run)


def _decoded(decode: Callable[[Any], Any], scalars: Iterator[Any]) -> Any:
    return decode(next(scalars))


def made(class_: Callable[..., Any], builds: Sequence[Build]) -> Build:
    """The function that makes an object of a class from scalars."""
    if all(build is next for build in builds):
        count = len(builds)
        if count == 2:
            return lambda scalars: class_(next(scalars), next(scalars))
        return lambda scalars: class_(*islice(scalars, count))
    if len(builds) == 2:
        first, second = builds
        return lambda scalars: class_(first(scalars), second(scalars))
    return lambda scalars: class_(*[build(scalars) for build in builds])


def _boolean(value: Any) -> bool:
    return BOOLEAN[value]


def _character(value: str) -> bytes:
    return value.encode("latin-1")


def _character_value(octet: bytes) -> str:
    return octet.decode("latin-1")


_NUMBERS = {
    "int8": "b",
    "uint8": "B",
    "octet": "B",
    "short": "h",
    "unsigned short": "H",
    "long": "i",
    "unsigned long": "I",
    "long long": "q",
    "unsigned long long": "Q",
    "float": "f",
    "double": "d",
}


def primitive(name: str, little: bool) -> Scalar | None:
    """The scalar of a basic type, or None for one that XTypes lacks."""
    if name in _NUMBERS:
        code = _NUMBERS[name]
        size = struct.calcsize(f"<{code}")
        return Scalar(code, size, size)
    match name:
        case "boolean":
            return Scalar("B", 1, 1, _boolean, BOOLEAN.__getitem__)
        case "char":
            return Scalar("c", 1, 1, _character, _character_value)
        case "wchar":
            return Scalar("H", 2, 2, unit_number, unit_character)
        case "long double":
            encode = partial(quad_octets, little_endian=little)
            decode = partial(quad_value, little_endian=little)
            return Scalar("16s", 16, 8, encode, decode)
    return None
