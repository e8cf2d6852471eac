"""Converts numbers between the forms of a sequence, for codecs that interpret descriptors."""

from __future__ import annotations

from typing import Any

from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.facts.primitives import NUMBERS
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.marshalling.numeric import NumericArray, buffer_of
from rtgen.runtime.marshalling.octets import nested


def listed(descriptor: SequenceDescriptor | ArrayDescriptor, value: Any) -> Any:
    """Return the items of a buffer as a list; other objects unchanged.

    Raises ValueError for a buffer of another format, or with other dimensions.
    """
    if descriptor.numeric == "list" or isinstance(value, list):
        return value
    element = plain(descriptor.element)
    if isinstance(element, StructDescriptor):
        from rtgen.runtime.marshalling import structured

        structured.check(value, structured.dtype_of(element))
        return structured.values_of(value, element)
    shape = getattr(value, "shape", None)
    if isinstance(descriptor, ArrayDescriptor) and shape is not None:
        if shape != descriptor.dimensions:
            raise ValueError(f"the shape {shape} instead of {descriptor.dimensions}")
        value = value.reshape(-1)
    assert isinstance(element, PrimitiveDescriptor)
    scalar = NUMBERS[element.name]
    view = buffer_of(value, scalar.code, scalar.size)
    if view is None:
        return value
    items = value.tolist() if hasattr(value, "tolist") else view.tolist()
    if isinstance(descriptor, ArrayDescriptor):
        return nested(items, descriptor.dimensions)
    return items


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
