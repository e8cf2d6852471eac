"""Key hashes of DDS instances (DDS-XTypes 1.3, 7.6.8; DDSI-RTPS 2.5, 9.6.4.8).

The key consists of the members marked `@key`, by member id, each nested struct by its own key
or, without one, as a whole. Its octets are those of PLAIN_CDR2, most significant octet first. A
key that never takes more than 16 octets is its own hash; any other is hashed by MD5.
"""

from __future__ import annotations

from hashlib import md5
from math import prod
from typing import Any

from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.descriptors import UnionDescriptor
from rtgen.runtime.marshalling.errors import CdrError
from rtgen.runtime.marshalling.layouts.formats import Format, UnsupportedError
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Delimited,
    Group,
    Node,
    Optional,
    Records,
    Repeat,
    TextArray,
    TextSequence,
)
from rtgen.runtime.marshalling.layouts.trees import body_of, tree_of

SIZE = 16
"""The size of a hash in octets."""

_FORMAT = Format(2, key=True)


class _TooLongError(Exception):
    """Raised if the key can be longer than a hash."""


def key_hash(type_: Any, value: object) -> bytes:
    """Return the hash of a value's key. Raises CdrError, also without a key."""
    descriptor = type_._descriptor_
    cached = descriptor.codecs.get(key_hash)
    if cached is None:
        cached = descriptor.codecs[key_hash] = _key_codec(descriptor)
    codec, short = cached
    key: bytes = codec(value, False)
    return key.ljust(SIZE, b"\0") if short else md5(key).digest()


def _key_codec(descriptor: Any) -> tuple[Any, bool]:
    """Return the encoder of the key, and whether keys never exceed 16 octets."""
    if not any(member.key for member in getattr(descriptor, "members", ())):
        name = descriptor.name.rpartition("::")[2]
        raise CdrError(name, "the type has no key")
    return compiled("to_cdr", descriptor, _FORMAT), _is_short(descriptor)


def _is_short(descriptor: Any) -> bool:
    try:
        _end(body_of(descriptor, _FORMAT), 0)
    except (_TooLongError, UnsupportedError):
        return False
    return True


def _end(node: Node, offset: int) -> int:
    """Return the greatest possible end of a value that begins at `offset`."""
    match node:
        case Atom(size=size, align=align):
            return _end_of(offset, size, align)
        case AtomArray(atom=atom, dimensions=dimensions):
            return _end_of(offset, atom.size * prod(dimensions), atom.align)
        case TextArray(length=length):
            return _limited(offset + length)
        case TextSequence():
            return _limited(_end_of(offset, 4, 4) + _bound(node.most))
        case AtomSequence(atom=atom, bound=bound):
            return _repeated((atom,), _bound(bound), _end_of(offset, 4, 4))
        case Records(element, length=None, bound=bound):
            return _repeated((element,), _bound(bound), _end_of(offset, 4, 4))
        case Records(element, length=int(length)):
            return _repeated((element,), length, offset)
        case Repeat(element, _, bound, length, key):
            elements = (element,) if key is None else (key, element)
            if length is None:
                length, offset = _bound(bound), _end_of(offset, 4, 4)
            return _repeated(elements, length, offset)
        case Group(members=members):
            for _, member in members:
                offset = _end(member, offset)
            return offset
        case Call(type=UnionDescriptor(switch=switch, branches=branches)):
            offset = _end(tree_of(switch, _FORMAT), offset)
            return max(
                offset, *(_end(tree_of(b.type, _FORMAT), offset) for b in branches)
            )
        case Call(type=type_):
            return _end(body_of(type_, _FORMAT), offset)
        case Delimited(node=inner):
            return _end(inner, _end_of(offset, 4, 4))
        case Optional(node=inner):
            return _end(inner, _limited(offset + 1))
    raise TypeError(node)


def _limited(offset: int) -> int:
    if offset > SIZE:
        raise _TooLongError
    return offset


def _end_of(offset: int, size: int, align: int) -> int:
    return _limited(offset + -offset % align + size)


def _bound(bound: int | None) -> int:
    if bound is None:
        raise _TooLongError
    return bound


def _repeated(elements: tuple[Node, ...], count: int, offset: int) -> int:
    for _ in range(count):
        before = offset
        for element in elements:
            offset = _end(element, offset)
        if offset == before:
            break
    return offset
