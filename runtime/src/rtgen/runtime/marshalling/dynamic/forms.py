"""Converts numbers between the forms of a sequence, for codecs that interpret descriptors."""

from __future__ import annotations

from typing import Any

from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.facts.primitives import NUMBERS, OCTET_TYPES
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.checks import TEXTS
from rtgen.runtime.marshalling.numeric import NumericArray, buffer_of, numbers_in
from rtgen.runtime.marshalling.octets import nested

_IN_BUFFERS = {
    **{name: (s.code, s.size) for name, s in NUMBERS.items() if name not in TEXTS},
    "boolean": ("?", 1),
}
"""Code of `struct` and size of each type whose collections are encoded from buffers."""


def is_octet(element: Descriptor) -> bool:
    """Return whether collections of an element are `bytes`, or buffers of octets."""
    return _primitive(element) in OCTET_TYPES


def is_in_buffers(element: Descriptor) -> bool:
    """Return whether collections of an element are encoded from buffers of numbers."""
    return _primitive(element) in _IN_BUFFERS


def _primitive(element: Descriptor) -> str:
    element = plain(element)
    return element.name if isinstance(element, PrimitiveDescriptor) else ""


def listed(descriptor: SequenceDescriptor | ArrayDescriptor, value: Any) -> Any:
    """Return the items of a buffer as a list; other objects unchanged.

    Raises ValueError for a buffer of another format, or with other dimensions.
    """
    if isinstance(value, list):
        return value
    element = plain(descriptor.element)
    if isinstance(element, StructDescriptor) and descriptor.numeric != "list":
        from rtgen.runtime.marshalling import structured

        structured.check(value, structured.dtype_of(element))
        return structured.values_of(value, element)
    scalar = _IN_BUFFERS.get(_primitive(element))
    if scalar is None:
        return value
    shape = None
    if isinstance(descriptor, ArrayDescriptor) and len(descriptor.dimensions) > 1:
        shape = descriptor.dimensions
    view = buffer_of(value, *scalar, shape)
    if view is None:
        return value
    items = numbers_in(view)
    return items if shape is None else nested(items, shape)


def formed(descriptor: SequenceDescriptor | ArrayDescriptor, items: list[Any]) -> Any:
    """Return a list of items in the form of the descriptor."""
    if descriptor.numeric == "list":
        return items
    element = plain(descriptor.element)
    if isinstance(element, StructDescriptor):
        from rtgen.runtime.marshalling import structured

        return structured.records_of(items, element)
    assert isinstance(element, PrimitiveDescriptor)
    code = NUMBERS[element.name].code
    if descriptor.numeric == "array":
        return NumericArray(code, items) if len(items) > MAX_LIST_LENGTH else items
    import numpy

    return numpy.array(items, code)
