"""What generated codecs of classic CDR stand on: layouts, conversions, `CdrError`.

CORBA 3.3 part 2, 9.3 (CDR), with strings in UTF-8 and `char` in ISO 8859-1; `wchar` and `wstring`
in UTF-16 as omniORB 4.3 sends them under GIOP 1.2. Padding is written as zero and not looked at.

A layout is printed into the generated module as sections of tokens. `I`, `3d`, `*i` stand for
`struct` codes: one, three, as many as the next count says; `*48s/8` for 48 octets each, aligned
to 8. `@4` in front says that the section begins at an offset of 4 modulo 8; `=` that padding is
settled and the rest is a `struct` format.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from enum import IntEnum, IntFlag
from struct import Struct
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias, TypeVar

from rtgen.runtime.cdr_values import flags_number

if TYPE_CHECKING:
    from rtgen.runtime.descriptors import (
        BitsetDescriptor,
        EnumDescriptor,
        ExceptionDescriptor,
        FlagsDescriptor,
        UnionDescriptor,
    )

Buffer: TypeAlias = bytes | bytearray | memoryview
"""What can be decoded."""

_E = TypeVar("_E", bound=IntEnum)
_WORD = (1 << 32) - 1
_V = TypeVar("_V")
_Reader: TypeAlias = tuple[Callable[..., tuple[Any, ...]], int]

BOOLEAN = {0: False, 1: True}
"""The octets of a boolean, and the values that can be one."""

SHAPES_KEPT = 512
"""How many shapes a table keeps before it begins anew."""

FAILURES = (
    struct.error,
    ArithmeticError,
    AttributeError,
    BufferError,
    LookupError,
    RecursionError,
    TypeError,
    ValueError,
)
"""What a codec meets when a value or the input is wrong."""

_TOKEN = re.compile(r"(\*?)(\d*)([a-zA-Z])(?:/(\d+))?(?: |$)")
_SIZES = {"b": 1, "B": 1, "c": 1, "s": 1, "h": 2, "H": 2, "i": 4, "I": 4, "f": 4}


class CdrError(ValueError):
    """A value that cannot be marshalled, or octets that cannot be unmarshalled.

    `path` names the place: `TimedPose2D.data.position.x`, `Path.points[3].y`.
    """

    def __init__(self, path: str, message: str) -> None:
        self.path = path
        self.message = message
        super().__init__(f"{path}: {message}")

    def __reduce__(self) -> tuple[type[CdrError], tuple[str, str]]:
        return (CdrError, (self.path, self.message))


def encoding_error(type_: Any, value: object, failure: Exception) -> CdrError:
    """The error for a value whose encoding failed; looks for the place only now."""
    from rtgen.runtime.cdr_faults import fault_in_value

    return fault_in_value(type_._descriptor_, _name(type_), value, failure)


def decoding_error(
    type_: Any, data: Buffer, little_endian: bool, failure: Exception
) -> CdrError:
    """The error for octets whose decoding failed; looks for the place only now."""
    from rtgen.runtime.cdr_faults import fault_in_octets

    name = _name(type_)
    return fault_in_octets(type_._descriptor_, name, data, little_endian, failure)


def to_xcdr2(type_: Any, value: object, little_endian: bool) -> bytes:
    """The XCDR2 body of a value of a generated type or typedef; raises CdrError."""
    from rtgen.runtime.xcdr import encode

    return encode(type_, value, 2, little_endian)


def from_xcdr2(type_: Any, data: Buffer, little_endian: bool) -> Any:
    """The value of an XCDR2 body; raises CdrError."""
    from rtgen.runtime.xcdr import decode

    return decode(type_, data, 2, little_endian)


def to_xcdr1(type_: Any, value: object, little_endian: bool) -> bytes:
    """The XCDR1 body of a value of a generated type or typedef; raises CdrError."""
    from rtgen.runtime.xcdr import encode

    return encode(type_, value, 1, little_endian)


def from_xcdr1(type_: Any, data: Buffer, little_endian: bool) -> Any:
    """The value of an XCDR1 body; raises CdrError."""
    from rtgen.runtime.xcdr import decode

    return decode(type_, data, 1, little_endian)


def _name(type_: Any) -> str:
    """The unscoped name of a generated type, or of the typedef that a codec is for."""
    return str(type_._descriptor_.name).rpartition("::")[2]


class Fixed:
    """The layout of a value that always has the same size: one `Struct` for each byte order."""

    __slots__ = (
        "pack_big",
        "pack_little",
        "records_big",
        "records_little",
        "unpack_big",
        "unpack_little",
    )

    def __init__(self, format_: str) -> None:
        little, big = Struct(f"<{format_}"), Struct(f">{format_}")
        self.pack_little: Callable[..., bytes] = little.pack
        self.pack_big: Callable[..., bytes] = big.pack
        self.unpack_little: Callable[[Buffer], tuple[Any, ...]] = little.unpack
        self.unpack_big: Callable[[Buffer], tuple[Any, ...]] = big.unpack
        self.records_little: Callable[[Buffer], Iterator[tuple[Any, ...]]] = (
            little.iter_unpack
        )
        self.records_big: Callable[[Buffer], Iterator[tuple[Any, ...]]] = (
            big.iter_unpack
        )


class Settled:
    """The layout of a run without counts that is read in several sections.

    `read_*` has the `unpack_from` of each section.
    """

    __slots__ = ("pack_big", "pack_little", "read_big", "read_little")

    def __init__(self, *sections: str) -> None:
        whole = "".join(section[1:] for section in sections)
        self.pack_little: Callable[..., bytes] = Struct(f"<{whole}").pack
        self.pack_big: Callable[..., bytes] = Struct(f">{whole}").pack
        self.read_little = tuple(_reader("<", s) for s in sections)
        self.read_big = tuple(_reader(">", s) for s in sections)


class Layout:
    """The layout of a run of values whose size follows from the counts in it.

    `pack_*` is a table: counts (one alone, or a tuple) to the packer of that shape. `read_*` has
    one reader for each section: of a settled one `unpack_from`, else a table of
    (`unpack_from`, size) by count (0 if the section has none).
    """

    __slots__ = ("pack_big", "pack_little", "read_big", "read_little")

    def __init__(self, *sections: str) -> None:
        self.pack_little: Mapping[Any, Callable[..., bytes]] = _Shapes("<", *sections)
        self.pack_big: Mapping[Any, Callable[..., bytes]] = _Shapes(">", *sections)
        self.read_little = tuple(_reader("<", s) for s in sections)
        self.read_big = tuple(_reader(">", s) for s in sections)


class PhasedLayout:
    """The same for a run that begins at an offset known only when it is reached.

    `pack_*` takes the offset modulo 8 before the counts. A table of `read_*` is by count if its
    section says where it begins (`@`), else by `count << 3 | offset & 7`.
    """

    __slots__ = ("pack_big", "pack_little", "read_big", "read_little")

    def __init__(self, *sections: str) -> None:
        little, big = _PhasedShapes("<", *sections), _PhasedShapes(">", *sections)
        self.pack_little: Mapping[Any, Callable[..., bytes]] = little
        self.pack_big: Mapping[Any, Callable[..., bytes]] = big
        self.read_little = tuple(_reader("<", s) for s in sections)
        self.read_big = tuple(_reader(">", s) for s in sections)


def _reader(order: str, section: str) -> Any:
    if section[0] == "=":
        return Struct(order + section[1:]).unpack_from
    kind = _Readers if section[0] == "@" else _PhasedReaders
    return kind(order, section)


class _Table(dict[Any, _V]):
    """A table that is filled as keys are asked for, and emptied when it is full."""

    def __init__(self, order: str, *sections: str) -> None:
        self._order = order
        self._sections = sections

    def __missing__(self, key: Any) -> _V:
        if len(self) >= SHAPES_KEPT:
            self.clear()
        value = self[key] = self._made(key)
        return value

    def _made(self, key: Any) -> _V:
        raise NotImplementedError

    def _struct(self, phase: int, counts: Iterable[int]) -> Struct:
        return Struct(self._order + _arranged(self._sections, phase, iter(counts)))


class _Shapes(_Table[Callable[..., bytes]]):
    def _made(self, key: Any) -> Callable[..., bytes]:
        return self._struct(0, key if isinstance(key, tuple) else (key,)).pack


class _PhasedShapes(_Table[Callable[..., bytes]]):
    def _made(self, key: Any) -> Callable[..., bytes]:
        phase, *counts = key if isinstance(key, tuple) else (key,)
        return self._struct(phase, counts).pack


class _Readers(_Table[_Reader]):
    def _made(self, key: int) -> _Reader:
        made = self._struct(int(self._sections[0][1]), (key,))
        return made.unpack_from, made.size


class _PhasedReaders(_Table[_Reader]):
    def _made(self, key: int) -> _Reader:
        made = self._struct(key & 7, (key >> 3,))
        return made.unpack_from, made.size


def _arranged(sections: Iterable[str], phase: int, counts: Iterator[int]) -> str:
    """The `struct` format of the sections from an offset of `phase` on."""
    texts: list[str] = []
    offset = phase
    for section in sections:
        if section[0] == "=":
            texts.append(section[1:])
            offset += struct.calcsize(f"<{section[1:]}")
            continue
        for star, digits, code, align in _TOKEN.findall(section):
            number = int(digits or 1) * (next(counts) if star else 1)
            size = _SIZES.get(code, 8)
            padding = -offset % int(align or size) if number or not star else 0
            texts.append(f"{padding}x{number}{code}")
            offset += padding + number * size
    return "".join(texts)


def _register(cls: type[Any]) -> None:
    """The class is what values of its own descriptor are made as."""
    if "_descriptor_" in cls.__dict__:
        from rtgen.runtime.descriptors import register

        register(cls, cls._descriptor_)


def members(enum: type[_E]) -> dict[int, _E]:
    """The members of an enumeration by number; refuses every other value with KeyError."""
    return {member.value: member for member in enum}


class _Described:
    """What has a descriptor that XCDR codecs can be compiled from."""

    __slots__ = ()

    _descriptor_: ClassVar[Any]

    def __init_subclass__(cls) -> None:
        _register(cls)

    def to_xcdr2(self, little_endian: bool = True) -> bytes:
        """The value as an XCDR2 body; raises CdrError."""
        return to_xcdr2(type(self), self, little_endian)

    @classmethod
    def from_xcdr2(cls, data: Buffer, little_endian: bool = True) -> Self:
        """The value of an XCDR2 body; raises CdrError."""
        value: Self = from_xcdr2(cls, data, little_endian)
        return value

    def to_xcdr1(self, little_endian: bool = True) -> bytes:
        """The value as an XCDR1 body; raises CdrError."""
        return to_xcdr1(type(self), self, little_endian)

    @classmethod
    def from_xcdr1(cls, data: Buffer, little_endian: bool = True) -> Self:
        """The value of an XCDR1 body; raises CdrError."""
        value: Self = from_xcdr1(cls, data, little_endian)
        return value


class _Number(_Described):
    """What stands on the wire as one unsigned integer."""

    __slots__ = ()

    def to_cdr(self, little_endian: bool = True) -> bytes:
        """The number as an unsigned integer; raises CdrError."""
        try:
            size = self._octet_count()
            return self.to_number().to_bytes(size, "little" if little_endian else "big")
        except FAILURES as failure:
            raise encoding_error(type(self), self, failure) from failure

    @classmethod
    def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
        """The value of an unsigned integer; raises CdrError."""
        try:
            octets = bytes(memoryview(data))
            if len(octets) != cls._octet_count():
                raise ValueError("wrong length")
            number = int.from_bytes(octets, "little" if little_endian else "big")
            return cls.from_number(number)
        except FAILURES as failure:
            raise decoding_error(cls, data, little_endian, failure) from failure

    @classmethod
    def _octet_count(cls) -> int:
        return next(n for n in (1, 2, 4, 8) if cls._descriptor_.bound <= 8 * n)

    def to_number(self) -> int:
        """The number on the wire. Raises ValueError for one that has too many bits."""
        raise NotImplementedError

    @classmethod
    def from_number(cls, number: int) -> Self:
        """The value of a number on the wire. Raises ValueError."""
        raise NotImplementedError


class Enumeration(_Number, IntEnum):
    """The base of generated enums."""

    _descriptor_: ClassVar[EnumDescriptor]

    @classmethod
    def _octet_count(cls) -> int:
        return 4

    def to_number(self) -> int:
        """The number of the member, a negative one in two's complement of 32 bits."""
        return int(self) & _WORD

    @classmethod
    def from_number(cls, number: int) -> Self:
        """The member of that number, a negative one in two's complement; raises ValueError."""
        if number >> 31 and cls._descriptor_.code == "i":
            number -= _WORD + 1
        return cls(number)


class Flags(_Number, IntFlag):
    """The base of generated bitmasks."""

    _descriptor_: ClassVar[FlagsDescriptor]

    def to_number(self) -> int:
        """The flags, each at its position; raises ValueError."""
        return flags_number(self, self._descriptor_.bound)

    @classmethod
    def from_number(cls, number: int) -> Self:
        """The flags of a number; raises ValueError."""
        return cls(flags_number(number, cls._descriptor_.bound))


class Bitset(_Number):
    """The base of generated bitsets: immutable, the fields as attributes (OMG IDL 4.2, 7.4.13)."""

    __slots__ = ()

    _descriptor_: ClassVar[BitsetDescriptor]

    def to_number(self) -> int:
        """The fields side by side, the first one lowest; raises ValueError."""
        number = 0
        for field in self._descriptor_.fields:
            number |= field.packed(getattr(self, field.attribute)) << field.position
        return number

    @classmethod
    def from_number(cls, number: int) -> Self:
        """The fields of a number; raises ValueError."""
        flags_number(number, cls._descriptor_.bound)
        return cls(*(f.unpacked(number) for f in cls._descriptor_.fields))


class Aggregated(_Described):
    """The base of generated structs and unions."""

    __slots__ = ()

    def key_hash(self) -> bytes:
        """The 16 octets that tell DDS instances apart; raises CdrError if there is no key.

        DDSI-RTPS 2.5, 9.6.4.8, of the key in XCDR2 (DDS-XTypes 1.3, 7.6.8).
        """
        from rtgen.runtime.xcdr_keys import key_hash

        return key_hash(type(self), self)


class Composite(Aggregated):
    """The base of generated types that other codecs call: unions, recursive structs.

    `_shares_`: it holds what is marshalled along its descriptor, and may be shared in a body.
    """

    __slots__ = ()

    _shares_: ClassVar[bool] = False

    def to_cdr(self, little_endian: bool = True) -> bytes:
        """The value as a CDR body; raises CdrError."""
        try:
            out = bytearray()
            if self._shares_:
                from rtgen.runtime.cdr_writer import Output

                out = Output()
            self._write_(out, little_endian)
            return bytes(out)
        except FAILURES as failure:
            raise encoding_error(type(self), self, failure) from failure

    @classmethod
    def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
        """The value of a CDR body; raises CdrError."""
        try:
            if cls._shares_:
                from rtgen.runtime.cdr_reader import Input

                data = Input(data)
            value, offset = cls._read_(data, 0, little_endian)
            if offset != len(data):
                raise ValueError("octets too many")
            return value
        except FAILURES as failure:
            raise decoding_error(cls, data, little_endian, failure) from failure

    def _write_(self, out: bytearray, little_endian: bool) -> None:
        """Appends the value to a body."""
        raise NotImplementedError

    @classmethod
    def _read_(cls, data: Buffer, offset: int, little_endian: bool) -> tuple[Self, int]:
        """The value at `offset` of a body, and the offset behind it."""
        raise NotImplementedError


class Union(Composite):
    """The base of generated unions."""

    __slots__ = ()

    _descriptor_: ClassVar[UnionDescriptor]
    discriminator: Any
    value: Any

    def _selected_(self, name: str) -> Any:
        """The value, if the discriminator selects the branch of that name (as in IDL)."""
        branch = self._descriptor_.branch(self.discriminator)
        if branch is None or branch.name != name:
            raise AttributeError(f"{self.discriminator!r} does not select {name}")
        return self.value


class UserException(Exception):
    """The base of generated exceptions: equal if of one class with equal members."""

    _descriptor_: ClassVar[ExceptionDescriptor]

    def __init_subclass__(cls) -> None:
        _register(cls)

    def _values(self) -> tuple[object, ...]:
        return tuple(getattr(self, m.attribute) for m in self._descriptor_.members)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)) or not isinstance(self, type(other)):
            return NotImplemented
        return self._values() == other._values()

    def __hash__(self) -> int:
        return hash(type(self))

    def __str__(self) -> str:
        pairs = zip(self._descriptor_.members, self._values(), strict=True)
        return ", ".join(f"{member.attribute}={value!r}" for member, value in pairs)

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return (type(self), self._values())
