"""From a descriptor to the XCDR codec of its type (DDS-XTypes 1.3, 7.4.3)."""

from __future__ import annotations

from functools import partial
from operator import methodcaller
from typing import Any

from rtgen.runtime.cdr_values import flags_number
from rtgen.runtime.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    Descriptor,
    EnumDescriptor,
    FlagsDescriptor,
    LinkDescriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.xcdr_codecs import (
    Codec,
    Format,
    Octets,
    Scalar,
    UnsupportedError,
    primitive,
    scalar_codec,
)
from rtgen.runtime.xcdr_collections import (
    array_codec,
    map_codec,
    sequence_codec,
    string_codec,
)
from rtgen.runtime.xcdr_structs import struct_codec
from rtgen.runtime.xcdr_unions import union_codec

_Declared = (
    EnumDescriptor
    | FlagsDescriptor
    | BitsetDescriptor
    | StructDescriptor
    | UnionDescriptor
)


def codec_of(descriptor: Descriptor, format_: Format) -> Codec:
    """The codec of a type, compiled once; raises UnsupportedError for types that XTypes lacks."""
    if isinstance(descriptor, AliasDescriptor):
        return codec_of(descriptor.target, format_)
    if isinstance(descriptor, LinkDescriptor):
        return _linked(descriptor, format_)
    if isinstance(descriptor, _Declared):
        codec: Codec | None = descriptor.codecs.get(format_)
        if codec is None:
            codec = descriptor.codecs[format_] = _compiled(descriptor, format_)
        return codec
    return _compiled(descriptor, format_)


def _compiled(descriptor: Descriptor, format_: Format) -> Codec:
    of = partial(codec_of, format_=format_)
    match descriptor:
        case PrimitiveDescriptor(name):
            scalar = primitive(name, format_.little)
            if scalar is not None:
                return scalar_codec(format_, scalar, True)
        case StringDescriptor():
            return string_codec(format_, descriptor)
        case SequenceDescriptor():
            return sequence_codec(format_, descriptor, of)
        case ArrayDescriptor():
            return array_codec(format_, descriptor, of)
        case MapDescriptor():
            return map_codec(format_, descriptor, of)
        case EnumDescriptor():
            return scalar_codec(format_, _enumeration(descriptor), False)
        case FlagsDescriptor():
            return scalar_codec(format_, _flags(descriptor), False)
        case BitsetDescriptor():
            return scalar_codec(format_, _bitset(descriptor), False)
        case StructDescriptor():
            return struct_codec(format_, descriptor, of)
        case UnionDescriptor():
            return union_codec(format_, descriptor, of)
    raise UnsupportedError(f"XCDR has no representation of {descriptor}")


def _linked(descriptor: LinkDescriptor, format_: Format) -> Codec:
    """A placeholder for the codec of a type under compilation, resolved at first use."""

    def write(out: bytearray, value: Any) -> None:
        codec_of(descriptor.target(), format_).write(out, value)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        return codec_of(descriptor.target(), format_).read(data, offset)

    return Codec(write, read, 1)


def holder(bound: int, signed: bool = False) -> tuple[str, int]:
    """The code and size of the integer for a number of bits (7.2.2.4.1.2)."""
    for bits, code, size in ((8, "B", 1), (16, "H", 2), (32, "I", 4)):
        if bound <= bits:
            return code.lower() if signed else code, size
    return "Q", 8


def _enumeration(descriptor: EnumDescriptor) -> Scalar:
    numbers = [number for _, number in descriptor.members]
    code, size = holder(descriptor.bound, min(numbers) < 0)
    members = {number: descriptor.class_(number) for number in numbers}
    return Scalar(code, size, size, members.__getitem__, members.__getitem__)


def _flags(descriptor: FlagsDescriptor) -> Scalar:
    code, size = holder(descriptor.bound)
    encode = partial(flags_number, bound=descriptor.bound)
    class_ = descriptor.class_

    def decode(number: int) -> Any:
        return class_(encode(number))

    return Scalar(code, size, size, encode, decode)


def _bitset(descriptor: BitsetDescriptor) -> Scalar:
    code, size = holder(descriptor.bound)
    class_: Any = descriptor.class_
    return Scalar(code, size, size, methodcaller("to_number"), class_.from_number)
