"""Offsets and sizes of the members of a struct in CDR.

CORBA 3.3 part 2, 9.3 for classic CDR; DDS-XTypes 1.3, 7.4 for XCDR2. The start of the struct is
aligned like that of a top-level value. After a value of variable length, offsets are unknown.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import prod

from rtgen.facts.primitives import SCALARS, Primitive
from rtgen.layouts.cdr_types import bit_count
from rtgen.layouts.representations import Representations
from rtgen.model import (
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
    Struct,
    Type,
    Union,
)

_WIDEST = 8
_WIDEST_IN_XCDR2 = 4
_HEADER = 4
"""Size of the header of an appendable struct in XCDR2 (DHEADER)."""
_MAX_ELEMENTS = 4096
"""Maximum number of structs in an array whose size is computed."""
_MAX_DEPTH = 64


@dataclass(frozen=True, slots=True)
class MemberPlace:
    """A member with its octets; None for an offset or size that depends on values."""

    holder: Struct
    member: Member
    offset: int | None
    size: int | None


@dataclass(frozen=True, slots=True)
class StructLayout:
    """The members of a struct in wire order, and its size; None if that depends on values."""

    members: tuple[MemberPlace, ...]
    size: int | None
    xcdr2: bool


def layout(
    model: Model, struct: Struct, representations: Representations
) -> StructLayout:
    """Compute the layout of a struct."""
    xcdr2 = representations.is_xcdr2(struct)
    measure = _Measure(model, representations, xcdr2)
    members = tuple(measure.members(struct))
    known = [*members, None][-2 if members else 0]
    end: int | None = 0
    if known is not None:
        complete = known.offset is not None and known.size is not None
        end = (known.offset or 0) + (known.size or 0) if complete else None
    if representations.extensibility(struct) is Extensibility.MUTABLE:
        end = None
    return StructLayout(members, end, xcdr2)


class _Measure:
    def __init__(
        self, model: Model, representations: Representations, xcdr2: bool
    ) -> None:
        self._model = model
        self._representations = representations
        self._xcdr2 = xcdr2
        self._widest = _WIDEST_IN_XCDR2 if xcdr2 else _WIDEST
        self._depth = 0

    def members(self, struct: Struct) -> Iterator[MemberPlace]:
        """Yield the members with their places, those of bases first."""
        start = self._begin(struct, 0)
        offset = start
        for holder, member in self._all(struct):
            if offset is None or member.optional or member.external:
                yield MemberPlace(holder, member, None, self._size(member.type))
                offset = None
                continue
            begin = self._aligned(offset, member.type)
            offset = self._after(begin, member.type)
            size = None if offset is None else offset - begin
            yield MemberPlace(holder, member, begin, size)

    def _all(self, struct: Struct) -> Iterator[tuple[Struct, Member]]:
        bases = [struct]
        while (base := bases[-1].base) is not None and len(bases) < _MAX_DEPTH:
            found = self._model.find(base)
            assert isinstance(found, Struct)
            bases.append(found)
        for each in reversed(bases):
            for member in each.members:
                yield each, member

    def _begin(self, struct: Struct | Union, offset: int) -> int | None:
        """Return the offset of the first member of a struct or union at an offset."""
        match self._representations.extensibility(struct):
            case Extensibility.MUTABLE:
                return None
            case Extensibility.APPENDABLE if self._xcdr2:
                return offset + -offset % _HEADER + _HEADER
        return offset

    def _size(self, type_: Type) -> int | None:
        """Return the size of a value at an aligned offset."""
        return self._after(0, type_)

    def _aligned(self, offset: int, type_: Type) -> int:
        return offset + -offset % self._alignment(type_)

    def _alignment(self, type_: Type) -> int:
        """Return the alignment of the first octet of a value."""
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(kind) if kind in SCALARS:
                return min(SCALARS[kind].align, self._widest)
            case PrimitiveType(Primitive.WCHAR):
                return 2 if self._xcdr2 else 1
            case ArrayType(element):
                if self._xcdr2 and not self._is_primitive(element):
                    return _HEADER
                return self._alignment(element)
            case FixedType():
                return 1
            case NamedType(name):
                return self._named_alignment(name)
        return 4

    def _named_alignment(self, name: tuple[str, ...]) -> int:
        match self._model.find(name):
            case Struct() as struct:
                if self._begin(struct, 0) != 0 or self._depth > _MAX_DEPTH:
                    return _HEADER
                first = next(self._all(struct), None)
                if first is None or first[1].optional:
                    return 1
                self._depth += 1
                found = self._alignment(first[1].type)
                self._depth -= 1
                return found
            case Union() as union:
                if self._begin(union, 0) != 0:
                    return _HEADER
                return self._alignment(union.switch)
            case Enum(bound=bound):
                return _octets(bound) if self._xcdr2 else 4
            case Bitmask(bound=bound):
                return min(_octets(bound), self._widest)
            case Bitset() as bitset:
                return min(_octets(bit_count(self._model, bitset)), self._widest)
        return 4

    def _is_primitive(self, type_: Type) -> bool:
        return isinstance(self._model.unalias(type_), PrimitiveType)

    def _after(self, offset: int, type_: Type) -> int | None:
        """Return the offset after a value; None if its length varies."""
        type_ = self._model.unalias(type_)
        start = self._aligned(offset, type_)
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
        plain = self._model.unalias(element)
        if self._xcdr2 and not self._is_primitive(element):
            start += _HEADER
        if isinstance(plain, PrimitiveType):
            begin = self._aligned(start, plain)
            end = self._after(begin, plain)
            return None if end is None else begin + count * (end - begin)
        if count > _MAX_ELEMENTS:
            return None
        offset: int | None = start
        for _ in range(count):
            if offset is None:
                return None
            offset = self._after(offset, plain)
        return offset

    def _after_named(self, start: int, name: tuple[str, ...]) -> int | None:
        match self._model.find(name):
            case Enum(bound=bound):
                return start + (_octets(bound) if self._xcdr2 else 4)
            case Bitmask(bound=bound):
                return start + _octets(bound)
            case Bitset() as bitset:
                return start + _octets(bit_count(self._model, bitset))
            case Struct() as struct:
                self._depth += 1
                offset = self._begin(struct, start)
                for _, member in self._all(struct):
                    if offset is None or member.optional or member.external:
                        offset = None
                        break
                    if self._depth > _MAX_DEPTH:
                        offset = None
                        break
                    offset = self._after(offset, member.type)
                self._depth -= 1
                return offset
        return None


def _octets(bits: int) -> int:
    """Return the octets of an integer with at least that many bits."""
    return next(size for size in (1, 2, 4, 8) if bits <= 8 * size or size == 8)
