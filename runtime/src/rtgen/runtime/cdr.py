"""Base classes of generated types, and `CdrError`.

CORBA 3.3 part 2, 9.3 (CDR), with strings in UTF-8 and `char` in ISO 8859-1; `wchar` and `wstring`
in UTF-16 as omniORB 4.3 sends them under GIOP 1.2. Padding is written as zeros, and ignored when
read.

Codecs and copiers are compiled from a type's descriptor at first use (`rtgen.runtime.marshalling`).
"""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import TYPE_CHECKING, Any, ClassVar, Final, Generic, Self, TypeVar

import msgspec
from msgspec import field as field

from rtgen.runtime.marshalling.descriptors import DataType, register
from rtgen.runtime.marshalling.dynamic.faults import decoding_error, encoding_error
from rtgen.runtime.marshalling.equality import holds_numpy, same, same_members
from rtgen.runtime.marshalling.errors import FAILURES
from rtgen.runtime.marshalling.errors import Buffer as Buffer
from rtgen.runtime.marshalling.errors import CdrError as CdrError
from rtgen.runtime.marshalling.octets import flags_number

if TYPE_CHECKING:
    from rtgen.runtime.marshalling.descriptors import (
        AliasDescriptor,
        BitsetDescriptor,
        EnumDescriptor,
        ExceptionDescriptor,
        FlagsDescriptor,
        UnionDescriptor,
    )

_T = TypeVar("_T")
_WORD = (1 << 32) - 1


class _Compiled:
    """Descriptor of a method that is compiled for its class at first lookup.

    `Time.from_cdr` returns the compiled function itself, so a caller that keeps it has no overhead.
    """

    def __init__(self, kind: str) -> None:
        self._kind = kind

    def __get__(self, instance: object, owner: type[Any]) -> Any:
        described = (c for c in owner.__mro__ if "_descriptor_" in vars(c))
        home: Any = next(described, None)
        if home is None:
            return self
        method = self._method(home._descriptor_)
        setattr(home, self._kind, method)
        return method.__get__(instance, owner)

    def _method(self, descriptor: Any) -> Any:
        from rtgen.runtime.marshalling.compiler import compiled
        from rtgen.runtime.marshalling.layouts.formats import Format
        from rtgen.runtime.marshalling.layouts.trees import classic_format

        if self._kind in ("_read_", "_write_"):
            return staticmethod(compiled(self._kind.strip("_"), descriptor))
        way, _, form = self._kind.partition("_")
        if way not in ("to", "from"):
            return compiled(self._kind, descriptor)
        version = descriptor.representation if form == "cdr" else int(form[-1])
        format_ = Format(version) if version else classic_format(descriptor)
        function = compiled(f"{way}_cdr", descriptor, format_)
        # A codec in C becomes a method, and is unwrapped to Python, unlike the function of it.
        codec = getattr(function, "__self__", function)
        return classmethod(codec) if way == "from" else codec


_KINDS = ("to_cdr", "from_cdr", "to_xcdr1", "from_xcdr1", "to_xcdr2", "from_xcdr2")
_COMPILED = {
    kind: _Compiled(kind) for kind in (*_KINDS, "_snapshot_", "_read_", "_write_")
}


def _register(cls: type[Any]) -> None:
    """Register the class for values of its descriptor."""
    descriptor = cls.__dict__.get("_descriptor_")
    if descriptor is None:
        return
    register(cls, descriptor)
    if not hasattr(cls.__base__, "_descriptor_"):
        return
    for kind, method in _COMPILED.items():
        if any(vars(base).get(kind) is method for base in cls.__mro__[2:]):
            setattr(cls, kind, method)


if TYPE_CHECKING:

    class _Xcdr:
        """Methods for both versions of XCDR."""

        def to_xcdr2(self, little_endian: bool = True) -> bytes:
            """Return the value as an XCDR2 body; raises CdrError."""

        @classmethod
        def from_xcdr2(cls, data: Buffer, little_endian: bool = True) -> Self:
            """Return the value of an XCDR2 body; raises CdrError."""

        def to_xcdr1(self, little_endian: bool = True) -> bytes:
            """Return the value as an XCDR1 body; raises CdrError."""

        @classmethod
        def from_xcdr1(cls, data: Buffer, little_endian: bool = True) -> Self:
            """Return the value of an XCDR1 body; raises CdrError."""

    class _Struct(_Xcdr, msgspec.Struct): ...

else:
    # Each base of a class delays its creation.
    _Xcdr, _Struct = object, msgspec.Struct


class _Number(_Xcdr):
    """A type marshalled as one unsigned integer."""

    __slots__ = ()

    _descriptor_: ClassVar[Any]

    if not TYPE_CHECKING:
        to_xcdr1 = _COMPILED["to_xcdr1"]
        from_xcdr1 = _COMPILED["from_xcdr1"]
        to_xcdr2 = _COMPILED["to_xcdr2"]
        from_xcdr2 = _COMPILED["from_xcdr2"]

    def __init_subclass__(cls) -> None:
        _register(cls)

    def to_cdr(self, little_endian: bool = True) -> bytes:
        """Return the number as an unsigned integer; raises CdrError."""
        try:
            size = self._octet_count()
            return self.to_number().to_bytes(size, "little" if little_endian else "big")
        except FAILURES as failure:
            raise encoding_error(self._descriptor_, self, failure) from failure

    @classmethod
    def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
        """Return the value of an unsigned integer; raises CdrError."""
        try:
            octets = bytes(memoryview(data))
            if len(octets) != cls._octet_count():
                raise ValueError("wrong length")
            number = int.from_bytes(octets, "little" if little_endian else "big")
            return cls.from_number(number)
        except FAILURES as failure:
            described = cls._descriptor_
            raise decoding_error(described, data, little_endian, failure) from failure

    @classmethod
    def _octet_count(cls) -> int:
        return next(n for n in (1, 2, 4, 8) if cls._descriptor_.bound <= 8 * n)

    def to_number(self) -> int:
        """Return the number on the wire. Raises ValueError for one that has too many bits."""
        raise NotImplementedError

    @classmethod
    def from_number(cls, number: int) -> Self:
        """Return the value of a number on the wire. Raises ValueError."""
        raise NotImplementedError


class Enumeration(_Number, IntEnum):
    """Base class of generated enums."""

    _descriptor_: ClassVar[EnumDescriptor]

    @classmethod
    def _octet_count(cls) -> int:
        return 4

    def to_number(self) -> int:
        """Return the number of the member; negative numbers in two's complement of 32 bits."""
        return int(self) & _WORD

    @classmethod
    def from_number(cls, number: int) -> Self:
        """Return the member of a number, negative ones as in `to_number`. Raises ValueError."""
        if number >> 31 and cls._descriptor_.code == "i":
            number -= _WORD + 1
        return cls(number)


class Flags(_Number, IntFlag):
    """Base class of generated bitmasks."""

    _descriptor_: ClassVar[FlagsDescriptor]

    def to_number(self) -> int:
        """Return the flags as a number. Raises ValueError."""
        return flags_number(self, self._descriptor_.bound)

    @classmethod
    def from_number(cls, number: int) -> Self:
        """Return the flags of a number. Raises ValueError."""
        return cls(flags_number(number, cls._descriptor_.bound))


class Bitset(_Number, msgspec.Struct, frozen=True, gc=False):
    """Base class of generated bitsets: immutable, fields as attributes (OMG IDL 4.2, 7.4.13)."""

    _descriptor_: ClassVar[BitsetDescriptor]

    def to_number(self) -> int:
        """Return the fields as a number, the first one lowest. Raises ValueError."""
        number = 0
        for bits in self._descriptor_.fields:
            number |= bits.packed(getattr(self, bits.attribute)) << bits.position
        return number

    @classmethod
    def from_number(cls, number: int) -> Self:
        """Return the bitset of a number. Raises ValueError."""
        flags_number(number, cls._descriptor_.bound)
        return cls(*(f.unpacked(number) for f in cls._descriptor_.fields))


class Aggregated(_Struct, gc=False):
    """Base class of generated structs and unions."""

    _descriptor_: ClassVar[Any]

    def __init_subclass__(cls) -> None:
        _register(cls)
        if holds_numpy(getattr(cls, "_descriptor_", None)):
            cls.__eq__ = same_members  # type: ignore[method-assign]

    if TYPE_CHECKING:

        def to_cdr(self, little_endian: bool = True) -> bytes:
            """Return the value as a CDR body; raises CdrError."""

        @classmethod
        def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
            """Return the value of a CDR body; raises CdrError."""

        def _snapshot_(self) -> Self: ...

    else:
        to_cdr = _COMPILED["to_cdr"]
        from_cdr = _COMPILED["from_cdr"]
        to_xcdr1 = _COMPILED["to_xcdr1"]
        from_xcdr1 = _COMPILED["from_xcdr1"]
        to_xcdr2 = _COMPILED["to_xcdr2"]
        from_xcdr2 = _COMPILED["from_xcdr2"]
        _snapshot_ = _COMPILED["_snapshot_"]
        _read_ = _COMPILED["_read_"]
        _write_ = _COMPILED["_write_"]

    def key_hash(self) -> bytes:
        """Return the 16 octets that identify a DDS instance. Raises CdrError without a key."""
        from rtgen.runtime.marshalling.keys import key_hash

        return key_hash(type(self), self)


class Union(Aggregated):
    """Base class of generated unions."""

    _descriptor_: ClassVar[UnionDescriptor]
    if TYPE_CHECKING:
        discriminator: Any
        value: Any

    def _selected_(self, name: str) -> Any:
        """Return the value, if the discriminator selects the branch of that name (as in IDL)."""
        branch = self._descriptor_.branch(self.discriminator)
        if branch is None or branch.name != name:
            raise AttributeError(f"{self.discriminator!r} does not select {name}")
        return self.value


_SDO_ABORT: Final = "CANopen::SdoAbort"
"""The exception whose codes people know in hexadecimal (CiA 301, table 22)."""


class UserException(Exception):
    """Base class of generated exceptions, equal if class and members are equal."""

    _descriptor_: ClassVar[ExceptionDescriptor]
    _raised_: ClassVar[type[DataType]]

    if TYPE_CHECKING:

        def to_cdr(self, little_endian: bool = True) -> bytes:
            """Return the value as a CDR body; raises CdrError."""

        @classmethod
        def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
            """Return the value of a CDR body; raises CdrError."""

    else:
        to_cdr = _COMPILED["to_cdr"]
        from_cdr = _COMPILED["from_cdr"]

    def __init_subclass__(cls) -> None:
        _register(cls)

    def _values(self) -> tuple[object, ...]:
        return tuple(getattr(self, m.attribute) for m in self._descriptor_.members)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)) or not isinstance(self, type(other)):
            return NotImplemented
        if holds_numpy(self._descriptor_):
            return all(map(same, self._values(), other._values()))
        return self._values() == other._values()

    def __hash__(self) -> int:
        return hash(type(self))

    def __str__(self) -> str:
        pairs = zip(self._descriptor_.members, self._values(), strict=True)
        is_abort = self._descriptor_.name == _SDO_ABORT
        return ", ".join(
            (
                f"{member.attribute}={value:#010x}"
                if is_abort and isinstance(value, int)
                else f"{member.attribute}={value!r}"
            )
            for member, value in pairs
        )

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return (type(self), self._values())


if TYPE_CHECKING:

    class _Subscripted(Generic[_T]): ...

else:

    class _Subscripted:
        def __class_getitem__(cls, item):
            # Only type checkers need the subscript, and `Generic` makes imports slow.
            return cls


class AliasCodec(_Subscripted[_T]):
    """Base class of the codecs of typedefs, whose values have no class of their own."""

    _descriptor_: ClassVar[AliasDescriptor]

    if TYPE_CHECKING:

        @classmethod
        def to_cdr(cls, value: _T, little_endian: bool = True) -> bytes:
            """Return the value as a CDR body; raises CdrError."""

        @classmethod
        def from_cdr(cls, data: Buffer, little_endian: bool = True) -> _T:
            """Return the value of a CDR body; raises CdrError."""

        @classmethod
        def to_xcdr2(cls, value: _T, little_endian: bool = True) -> bytes:
            """Return the value as an XCDR2 body; raises CdrError."""

        @classmethod
        def from_xcdr2(cls, data: Buffer, little_endian: bool = True) -> _T:
            """Return the value of an XCDR2 body; raises CdrError."""

    else:
        to_cdr = _COMPILED["to_cdr"]
        from_cdr = _COMPILED["from_cdr"]
        to_xcdr2 = _COMPILED["to_xcdr2"]
        from_xcdr2 = _COMPILED["from_xcdr2"]
