"""Key hashes of DDS instances (DDS-XTypes 1.3, 7.6.8; DDSI-RTPS 2.5, 9.6.4.8).

The key consists of the members marked `@key`, by member id, each nested struct by its own key
or, without one, as a whole. Its octets are those of PLAIN_CDR2, most significant octet first. A
key that never takes more than 16 octets is its own hash; any other is hashed by MD5.
"""

from __future__ import annotations

from hashlib import md5
from math import prod
from typing import Any

from rtgen.runtime.cdr import FAILURES, CdrError, encoding_error
from rtgen.runtime.descriptors import (
    ArrayDescriptor,
    BitsetDescriptor,
    Descriptor,
    EnumDescriptor,
    FlagsDescriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.xcdr_codecs import Codec, Format, UnsupportedError, primitive
from rtgen.runtime.xcdr_compiler import codec_of, holder
from rtgen.runtime.xcdr_structs import key_members

SIZE = 16
"""The size of a hash in octets."""

_FORMAT = Format(2, False, True)


class _TooLongError(Exception):
    """The key can be longer than a hash."""


def key_hash(type_: Any, value: object) -> bytes:
    """The hash of a value's key; raises CdrError, also if the type has none."""
    descriptor = type_._descriptor_
    name = descriptor.name.rpartition("::")[2]
    try:
        codec, short = _kept(descriptor)
        out = bytearray()
        codec.write(out, value)
    except UnsupportedError as failure:
        raise CdrError(name + failure.path, str(failure)) from failure
    except FAILURES as failure:
        raise encoding_error(type_._descriptor_, value, failure) from failure
    return bytes(out).ljust(SIZE, b"\0") if short else md5(out).digest()


def _kept(descriptor: Any) -> tuple[Codec, bool]:
    """The codec of the key, and whether the key never exceeds 16 octets."""
    kept: tuple[Codec, bool] | None = descriptor.codecs.get(key_hash)
    if kept is None:
        members = getattr(descriptor, "members", ())
        if not any(member.key for member in members):
            raise UnsupportedError("the type has no key")
        codec = codec_of(descriptor, _FORMAT)
        kept = descriptor.codecs[key_hash] = (codec, _is_short(descriptor))
    return kept


def _is_short(descriptor: Descriptor) -> bool:
    try:
        _end(descriptor, 0)
    except _TooLongError:
        return False
    return True


def _end(descriptor: Descriptor, offset: int) -> int:
    """The greatest offset at which a value that begins at `offset` can end."""
    descriptor = plain(descriptor)
    match descriptor:
        case PrimitiveDescriptor(name):
            scalar = primitive(name, False)
            assert scalar is not None
            return _behind(offset, scalar.size)
        case EnumDescriptor(bound=bound):
            return _behind(offset, holder(bound)[1])
        case FlagsDescriptor(bound=bound) | BitsetDescriptor(bound=bound):
            return _behind(offset, holder(bound)[1])
        case StringDescriptor(wide=wide, bound=bound):
            length = _bound(bound)
            return _limited(_behind(offset, 4) + (2 * length if wide else length + 1))
        case SequenceDescriptor(element=element, bound=bound):
            offset = _behind(_delimited(element, offset), 4)
            return _repeated((element,), _bound(bound), offset)
        case ArrayDescriptor(element=element, dimensions=dimensions):
            offset = _delimited(element, offset)
            return _repeated((element,), prod(dimensions), offset)
        case MapDescriptor(key=key, value=value, bound=bound):
            offset = _delimited(value if _is_primitive(key) else key, offset)
            return _repeated((key, value), _bound(bound), _behind(offset, 4))
        case StructDescriptor():
            for member in key_members(descriptor):
                offset = _end(member.type, _limited(offset + member.optional))
            return offset
        case UnionDescriptor(switch=switch, branches=branches):
            offset = _end(switch, offset)
            return max(offset, *(_end(branch.type, offset) for branch in branches))
    raise UnsupportedError(f"{descriptor} cannot be a key")


def _limited(offset: int) -> int:
    if offset > SIZE:
        raise _TooLongError
    return offset


def _behind(offset: int, size: int) -> int:
    return _limited(offset + -offset % min(size, 4) + size)


def _bound(bound: int | None) -> int:
    if bound is None:
        raise _TooLongError
    return bound


def _delimited(element: Descriptor, offset: int) -> int:
    return offset if _is_primitive(element) else _behind(offset, 4)


def _is_primitive(descriptor: Descriptor) -> bool:
    descriptor = plain(descriptor)
    while isinstance(descriptor, ArrayDescriptor):
        descriptor = plain(descriptor.element)
    return isinstance(descriptor, PrimitiveDescriptor)


def _repeated(elements: tuple[Descriptor, ...], count: int, offset: int) -> int:
    for _ in range(count):
        before = offset
        for element in elements:
            offset = _end(element, offset)
        if offset == before:
            break
    return offset
