"""Marshals an `any`: generated structs and unions by their codecs, after a cached type code."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

from rtgen.runtime.marshalling.descriptors import (
    ANY,
    UNKNOWN,
    Descriptor,
    PrimitiveDescriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.marshalling.dynamic.direct import compiled_class
from rtgen.runtime.marshalling.dynamic.octet_reader import Input
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.writer import Writer
from rtgen.runtime.marshalling.errors import Buffer
from rtgen.runtime.marshalling.type_codes import (
    AGGREGATED,
    known_type,
    type_code_octets,
)

_ByteOrder: TypeAlias = Literal["little", "big"]


def write_any(out: bytearray, value: Any, _: Descriptor, little_endian: bool) -> None:
    """Append an `any`. Raises ValueError or a related error."""
    type_ = value.type
    if isinstance(type_, StructDescriptor | UnionDescriptor):
        class_ = compiled_class(type_)
        inner = value.value
        if type(inner) is class_ and value._descriptor_ is ANY:
            kind, parameters = type_code_octets(type_, little_endian)
            order: _ByteOrder = "little" if little_endian else "big"
            head = kind.to_bytes(4, order)
            out += bytes(-len(out) & 3) + head + parameters
            class_._write_(inner, out, little_endian)
            return
    Writer(out, little_endian).any(value)


def read_any(
    data: Buffer, offset: int, _: Descriptor, little_endian: bool
) -> tuple[Any, int]:
    """Return the `any` at `offset`, and the next offset. Raises ValueError."""
    start = offset + (-offset & 3)
    order: _ByteOrder = "little" if little_endian else "big"
    kind = int.from_bytes(data[start : start + 4], order)
    if kind in AGGREGATED and type(data) is Input and data.work:
        place = start + 8
        end = place + int.from_bytes(data[start + 4 : place], order)
        type_ = known_type(kind, data[place:end]) if end <= len(data) else None
        if isinstance(type_, StructDescriptor | UnionDescriptor):
            class_ = compiled_class(type_)
            if class_ is not None:
                data.work -= 1
                value, offset = class_._read_(data, end, little_endian)
                return UNKNOWN[PrimitiveDescriptor](type_, value), offset
    reader = Reader(data, little_endian, offset)
    return reader.any(), reader.offset
