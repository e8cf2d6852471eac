"""Offsets and sizes of the members of a struct in CDR.

CORBA 3.3 part 2, 9.3 for classic CDR; DDS-XTypes 1.3, 7.4 for XCDR2. The start of the struct is
aligned like that of a top-level value. After a value of variable length, offsets are unknown.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import prod

from rtgen.compiler.layouts.cdr_types import bit_count
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Enum,
    Extensibility,
    FixedType,
    Member,
    Model,
    NamedType,
    PrimitiveType,
    ScopedName,
    Struct,
    Type,
    Union,
)
from rtgen.facts.primitives import SCALARS, Primitive

_WIDEST = 8
_WIDEST_IN_XCDR2 = 4
_HEADER = 4
"""Size and alignment of the header of an appendable struct in XCDR2 (DHEADER)."""
_MAX_ELEMENTS = 4096
"""Maximum number of structs in an array whose size is computed."""


@dataclass(frozen=True, slots=True)
class MemberPlace:
    """A member with its octets; None for an offset or size that depends on values."""

    holder: Struct
    member: Member
    offset: int | None
    size: int | None

    @property
    def end(self) -> int | None:
        """The offset after the member."""
        if self.offset is None or self.size is None:
            return None
        return self.offset + self.size


@dataclass(frozen=True, slots=True)
class StructLayout:
    """The members of a struct in wire order, and its size; None if that depends on values."""

    members: tuple[MemberPlace, ...]
    size: int | None
    xcdr2: bool


class Layouts:
    """The layouts of the structs of a model; each type is measured once."""

    def __init__(self, model: Model, representations: Representations) -> None:
        self._representations = representations
        self._measures = {
            xcdr2: _Measure(model, representations, xcdr2) for xcdr2 in (False, True)
        }

    def of(self, struct: Struct) -> StructLayout:
        """Compute the layout of a struct."""
        xcdr2 = self._representations.is_xcdr2(struct)
        measure = self._measures[xcdr2]
        members = tuple(measure.members(struct))
        end = members[-1].end if members else measure.begin(struct, 0)
        return StructLayout(members, end, xcdr2)


class _Measure:
    def __init__(
        self, model: Model, representations: Representations, xcdr2: bool
    ) -> None:
        self._model = model
        self._representations = representations
        self._xcdr2 = xcdr2
        self._widest = _WIDEST_IN_XCDR2 if xcdr2 else _WIDEST
        self._lengths: dict[tuple[Type, int], int | None] = {}
        """Octets of a value, including padding before it, by its type and offset modulo _WIDEST."""
        self._alignments: dict[Type, int] = {}

    def members(self, struct: Struct) -> Iterator[MemberPlace]:
        """Yield the members with their places, those of bases first."""
        offset = self.begin(struct, 0)
        for holder, member in self._all(struct):
            if offset is None or member.optional or member.external:
                yield MemberPlace(holder, member, None, self._after(0, member.type))
                offset = None
                continue
            begin = self._aligned(offset, member.type)
            offset = self._after(begin, member.type)
            size = None if offset is None else offset - begin
            yield MemberPlace(holder, member, begin, size)

    def begin(self, holder: Struct | Union, offset: int) -> int | None:
        """Return the offset of the first member of a struct or union at an aligned offset."""
        match self._representations.extensibility(holder):
            case Extensibility.MUTABLE:
                return None
            case Extensibility.APPENDABLE if self._xcdr2:
                return offset + _HEADER
        return offset

    def _all(self, struct: Struct) -> Iterator[tuple[Struct, Member]]:
        for each in self._model.lineage(struct):
            for member in each.members:
                yield each, member

    def _aligned(self, offset: int, type_: Type) -> int:
        return offset + -offset % self._alignment(type_)

    def _alignment(self, type_: Type) -> int:
        """Return the alignment of the first octet of a value."""
        passed: dict[Type, None] = {}
        first: int | Type = type_
        while not isinstance(first, int):
            if first in passed:
                first = 1  # A struct that begins with itself has no values.
            elif first in self._alignments:
                first = self._alignments[first]
            else:
                passed[first] = None
                first = self._first(first)
        self._alignments |= dict.fromkeys(passed, first)
        return first

    def _first(self, type_: Type) -> int | Type:
        """Return the alignment of a type, or the type with which its values begin."""
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(kind) if kind in SCALARS:
                return min(SCALARS[kind].align, self._widest)
            case PrimitiveType(Primitive.WCHAR):
                return 2 if self._xcdr2 else 1
            case ArrayType(element):
                return _HEADER if self._has_header(element) else element
            case FixedType():
                return 1
            case NamedType(name):
                return self._first_of_named(name)
        return 4

    def _first_of_named(self, name: ScopedName) -> int | Type:
        match self._model.find(name):
            case Struct() | Union() as holder if self.begin(holder, 0) != 0:
                return _HEADER
            case Struct() as struct:
                first = next(iter(self._model.members(struct)), None)
                if first is None:
                    return 1
                if first.optional:
                    return 1 if self._xcdr2 else _HEADER
                return first.type
            case Union(switch=switch):
                return switch
            case Enum(bound=bound):
                return _octets(bound) if self._xcdr2 else 4
            case Bitmask(bound=bound):
                return min(_octets(bound), self._widest)
            case Bitset() as bitset:
                return min(_octets(bit_count(self._model, bitset)), self._widest)
        return 4

    def _has_header(self, element: Type) -> bool:
        """Return whether arrays of these elements have a header (DHEADER)."""
        plain = self._model.unalias(element)
        return self._xcdr2 and not isinstance(plain, PrimitiveType)

    def _after(self, offset: int, type_: Type) -> int | None:
        """Return the offset after a value; None if its length varies."""
        key = type_, offset % _WIDEST
        if key not in self._lengths:
            end = self._measured(self._aligned(offset, type_), type_)
            self._lengths[key] = None if end is None else end - offset
        length = self._lengths[key]
        return None if length is None else offset + length

    def _measured(self, start: int, type_: Type) -> int | None:
        """Return the offset after a value at an aligned offset."""
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(kind) if kind in SCALARS:
                return start + SCALARS[kind].size
            case PrimitiveType(Primitive.WCHAR):
                return start + 2 if self._xcdr2 else None
            case FixedType(digits):
                return start + digits // 2 + 1
            case ArrayType(element, dimensions):
                return self._after_array(start, element, prod(dimensions))
            case NamedType(name):
                return self._after_named(start, name)
        return None

    def _after_array(self, start: int, element: Type, count: int) -> int | None:
        if isinstance(self._model.unalias(element), PrimitiveType):
            end = self._after(start, element)
            return None if end is None else start + count * (end - start)
        if count > _MAX_ELEMENTS:
            return None
        offset: int | None = start + _HEADER if self._xcdr2 else start
        for _ in range(count):
            if offset is None:
                return None
            offset = self._after(offset, element)
        return offset

    def _after_named(self, start: int, name: ScopedName) -> int | None:
        match self._model.find(name):
            case Enum(bound=bound):
                return start + (_octets(bound) if self._xcdr2 else 4)
            case Bitmask(bound=bound):
                return start + _octets(bound)
            case Bitset() as bitset:
                return start + _octets(bit_count(self._model, bitset))
            case Struct() as struct:
                offset = self.begin(struct, start)
                for member in self._model.members(struct):
                    if offset is None or member.optional or member.external:
                        return None
                    offset = self._after(offset, member.type)
                return offset
        return None


def _octets(bits: int) -> int:
    """Return the octets of an integer with at least that many bits; 8 for more than 64."""
    return next((size for size in (1, 2, 4) if bits <= 8 * size), 8)
