"""How omniORBpy represents the values of types that omniidl generates."""

from __future__ import annotations

from typing import Any, TypeAlias

from rtgen.facts.omniidl import opaque_id
from rtgen.facts.primitives import Primitive
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    BoxDescriptor,
    Descriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    ValueDescriptor,
    plain,
)
from rtgen.runtime.marshalling.layouts.nodes import Text
from rtgen.runtime.marshalling.layouts.trees import TEXTS, parts
from rtgen.runtime.openrtm.wire_objects import BASIC

Items: TypeAlias = SequenceDescriptor | ArrayDescriptor


def identity_of(descriptor: Any) -> str:
    """Return the repository id of a type in omniORB; a placeholder has its own."""
    opaque = isinstance(descriptor, StructDescriptor) and descriptor.opaque
    identity: str = descriptor.repository_id
    return opaque_id(descriptor.name) if opaque else identity


def holds_values(descriptor: Descriptor) -> bool:
    """Return whether the data contain valuetypes, whose sharing makes a value a graph."""
    return any(
        isinstance(part, ValueDescriptor | BoxDescriptor)
        or part == PrimitiveDescriptor(Primitive.VALUE_BASE)
        for part in parts(descriptor)
    )


def kept_struct(type_: Descriptor) -> StructDescriptor | None:
    """Return the struct of a list's items, if their wire objects are reused."""
    match type_:
        case SequenceDescriptor(element, numeric="list") | ArrayDescriptor(
            element, (_,)
        ):
            element = plain(element)
            return element if isinstance(element, StructDescriptor) else None
    return None


def element_of(type_: Items) -> Descriptor:
    """Return the type of a list's items; those of an array of arrays are arrays."""
    if isinstance(type_, ArrayDescriptor) and len(type_.dimensions) > 1:
        return ArrayDescriptor(type_.element, type_.dimensions[1:])
    return type_.element


def text_of(type_: Items) -> Text | None:
    """Return the form of a sequence or array that is `bytes` or `str` in Python."""
    element = plain(element_of(type_))
    return TEXTS.get(element.name) if isinstance(element, PrimitiveDescriptor) else None


def _is_direct(type_: Descriptor, text: Text) -> bool:
    """Return whether items are octets, or characters, without an alias.

    With an alias, omniORBpy has a list of them.
    """
    if not isinstance(type_, Items) or text_of(type_) is not text:
        return False
    return isinstance(element_of(type_), PrimitiveDescriptor)


def is_octets(type_: Descriptor) -> bool:
    """Return whether a value is `bytes` in omniORBpy, and any buffer of octets in rtgen."""
    return _is_direct(type_, Text.OCTETS)


def is_immutable(type_: Descriptor) -> bool:
    """Return whether both sides have the same immutable values."""
    if isinstance(type_, PrimitiveDescriptor):
        return type_.name not in BASIC
    return isinstance(type_, StringDescriptor) or _is_direct(type_, Text.CHARACTERS)


def is_same(type_: Descriptor) -> bool:
    """Return whether omniORB marshals the value as is: immutable values and lists of them."""
    if not isinstance(type_, Items):
        return is_immutable(type_)
    if is_immutable(type_):
        return True
    is_list = type_.numeric == "list" and text_of(type_) is None
    return is_list and is_same(plain(element_of(type_)))
