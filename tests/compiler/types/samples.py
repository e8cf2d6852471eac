"""Random values of a descriptor: plain trees, from which the objects of any mapping are built.

A struct is a dict, a union a (discriminator, value) pair, an enum its number.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Any

from hypothesis import strategies as st

from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BitfieldDescriptor,
    BitsetDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.marshalling.octets import ObjectReference

_BITS = {
    "short": 16,
    "long": 32,
    "long long": 64,
    "int8": 8,
    "unsigned short": 16,
    "unsigned long": 32,
    "unsigned long long": 64,
    "uint8": 8,
    "octet": 8,
}
_LATIN = st.characters(max_codepoint=255)
_WIDE = st.characters(max_codepoint=0xFFFF, exclude_categories=["Cs"])
_TEXT = st.characters(exclude_characters="\0", exclude_categories=["Cs"])
_MAX_ITEMS = 4


def values(descriptor: Descriptor, depth: int = 0) -> st.SearchStrategy[Any]:
    """Draw trees of values of the descriptor."""
    match descriptor:
        case PrimitiveDescriptor(name):
            return _primitive(name)
        case StringDescriptor(wide, bound):
            texts = st.text(_TEXT, max_size=min(bound or 6, 6))
            return (
                texts
                if bound is None
                else texts.filter(lambda t: _size(t, wide) <= bound)
            )
        case FixedDescriptor(digits, scale):
            most = 10**digits - 1
            return st.integers(-most, most).map(lambda n: Decimal(n).scaleb(-scale))
        case EnumDescriptor(members=members):
            return st.sampled_from([number for _, number in members])
        case FlagsDescriptor(bound=bound):
            return st.integers(0, (1 << bound) - 1)
        case BitsetDescriptor(fields=bits):
            return st.fixed_dictionaries({b.name: _bitfield(b) for b in bits})
        case SequenceDescriptor(element, bound):
            most = 0 if depth > 3 else min(bound or _MAX_ITEMS, _MAX_ITEMS)
            return _joined(element, st.lists(values(element, depth + 1), max_size=most))
        case ArrayDescriptor(element, dimensions):
            return _array(element, dimensions, depth)
        case MapDescriptor(key, value, bound):
            most = min(bound or _MAX_ITEMS, _MAX_ITEMS)
            return st.dictionaries(values(key), values(value), max_size=most)
        case StructDescriptor(members=fields) | ExceptionDescriptor(members=fields):
            return st.fixed_dictionaries(
                {m.name: values(m.type, depth) for m in fields}
            )
        case UnionDescriptor():
            return values(descriptor.switch).flatmap(
                lambda d: st.tuples(st.just(d), _branch(descriptor, d, depth))
            )
        case AliasDescriptor(target=target):
            return values(target, depth)
        case LinkDescriptor(target=target):
            return st.deferred(lambda: values(target(), depth + 1))
        case InterfaceDescriptor():
            return _reference()
    raise TypeError(descriptor)


def _bitfield(field: BitfieldDescriptor) -> st.SearchStrategy[Any]:
    if field.boolean:
        return st.booleans()
    half = 1 << field.bits - 1
    return (
        st.integers(-half, half - 1) if field.signed else st.integers(0, 2 * half - 1)
    )


def _size(text: str, wide: bool) -> int:
    return len(text.encode("utf-16-le")) // 2 if wide else len(text.encode())


def _reference() -> st.SearchStrategy[Any]:
    profile = st.tuples(st.integers(0, 9), st.binary(max_size=5))
    profiles = st.lists(profile, min_size=1, max_size=2).map(tuple)
    return st.none() | st.builds(ObjectReference, st.just("IDL:X:1.0"), profiles)


def _branch(
    descriptor: UnionDescriptor, discriminator: Any, depth: int
) -> st.SearchStrategy[Any]:
    branch = descriptor.branch(discriminator)
    return st.none() if branch is None else values(branch.type, depth)


def _primitive(name: str) -> st.SearchStrategy[Any]:
    if name in _BITS:
        bits = _BITS[name]
        if name.startswith("unsigned") or name in ("octet", "uint8"):
            return st.integers(0, (1 << bits) - 1)
        return st.integers(-(1 << bits - 1), (1 << bits - 1) - 1)
    match name:
        case "float":
            return st.floats(width=32, allow_nan=False)
        case "double" | "long double":
            return st.floats(allow_nan=False)
        case "boolean":
            return st.booleans()
        case "char":
            return _LATIN
        case "wchar":
            return _WIDE
    assert name == "Object"
    return _reference()


def _joined(
    element: Descriptor, lists: st.SearchStrategy[Any]
) -> st.SearchStrategy[Any]:
    element = plain(element)
    if isinstance(element, PrimitiveDescriptor):
        if element.name in ("octet", "uint8"):
            return lists.map(bytes)
        if element.name == "char":
            return lists.map("".join)
    return lists


def _array(
    element: Descriptor, dimensions: tuple[int, ...], depth: int
) -> st.SearchStrategy[Any]:
    first, *rest = dimensions
    if rest:
        inner = _array(element, tuple(rest), depth)
        return st.lists(inner, min_size=first, max_size=first)
    items = st.lists(values(element, depth), min_size=first, max_size=first)
    return _joined(element, items)


def build(descriptor: Descriptor, tree: Any, types: dict[str, type[Any]]) -> Any:
    """Return the object of a tree; `types` are the generated classes by repository id."""
    match descriptor:
        case SequenceDescriptor(element) if isinstance(tree, list):
            return [build(element, item, types) for item in tree]
        case ArrayDescriptor(element, dimensions) if isinstance(tree, list):
            inner = element
            if len(dimensions) > 1:
                inner = ArrayDescriptor(element, dimensions[1:])
            return [build(inner, item, types) for item in tree]
        case MapDescriptor(key, value):
            return {
                build(key, k, types): build(value, v, types) for k, v in tree.items()
            }
        case StructDescriptor(members=fields) | ExceptionDescriptor(members=fields):
            parts = [build(m.type, tree[m.name], types) for m in fields]
            return types[descriptor.repository_id](*parts)
        case BitsetDescriptor(fields=bits):
            return types[descriptor.repository_id](*(tree[b.name] for b in bits))
        case EnumDescriptor() | FlagsDescriptor():
            return types[descriptor.repository_id](tree)
        case UnionDescriptor():
            discriminator, value = tree
            branch = descriptor.branch(discriminator)
            inner = None if branch is None else build(branch.type, value, types)
            chosen = build(descriptor.switch, discriminator, types)
            return types[descriptor.repository_id](chosen, inner)
        case LinkDescriptor() | AliasDescriptor():
            return build(plain(descriptor), tree, types)
    return tree
