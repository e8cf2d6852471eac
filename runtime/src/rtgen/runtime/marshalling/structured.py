"""Sequences of structs of numbers as structured arrays of numpy."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy

from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    SequenceDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.marshalling.errors import Buffer
from rtgen.runtime.marshalling.layouts.formats import CLASSIC
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    Group,
    Node,
    Records,
    TextArray,
    minimum_size,
)
from rtgen.runtime.marshalling.layouts.trees import tree_of
from rtgen.runtime.marshalling.numeric import Order, octets_or_view

_NATIVE: Order = "<" if sys.byteorder == "little" else ">"

if TYPE_CHECKING:
    from numpy.typing import NDArray

    _Records: TypeAlias = NDArray[numpy.void]


def dtype_of(class_: Any) -> numpy.dtype[Any]:
    """Return the dtype of a generated struct of numbers: its layout in a sequence, with padding.

    The fields have the names of the definition. Raises TypeError for a struct with other members.
    """
    descriptor: Descriptor = getattr(class_, "_descriptor_", class_)
    sequence = tree_of(SequenceDescriptor(descriptor, numeric="numpy"), CLASSIC)
    if isinstance(sequence, Records):
        return _element_dtype(sequence, _NATIVE)
    return _dtype(tree_of(descriptor, CLASSIC), 0, _NATIVE)[0]


def _element_dtype(node: Records, order: Order) -> numpy.dtype[Any]:
    return _dtype(node.element, 0, order, node.padding)[0]


def _dtype(
    node: Node, start: int, order: Order, padding: int = 0
) -> tuple[numpy.dtype[Any], int]:
    """Return the dtype of a value that begins at or after `start`, and its first offset.

    `padding` octets follow a struct.
    """
    match node:
        case Atom(code=code, align=align):
            return numpy.dtype(code).newbyteorder(order), start + -start % align
        case AtomArray(atom=atom, dimensions=dimensions):
            item, first = _dtype(atom, start, order)
            return numpy.dtype((item, dimensions)), first
        case TextArray(length=length):
            return numpy.dtype(("u1", (length,))), start
        case Group(type=described, members=members) if members:
            names = {m.attribute: m.name for m in described.members}
            formats, offsets = [], []
            end = start
            for _, inner in members:
                format_, first = _dtype(inner, end, order)
                formats.append(format_)
                offsets.append(first)
                end = first + format_.itemsize
            begin = offsets[0]
            described = {
                "names": [names[attribute] for attribute, _ in members],
                "formats": formats,
                "offsets": [offset - begin for offset in offsets],
                "itemsize": end - begin + padding,
            }
            return numpy.dtype(described), begin  # type: ignore[call-overload]
    raise TypeError(f"{node} has no dtype")


def octets(node: Records, order: Order) -> Callable[[_Records], Buffer]:
    """Return the function that encodes the records, many as a view. It raises ValueError."""
    there = _element_dtype(node, order)
    value = _value_dtype(node)
    excess = -node.padding or None

    def packed(records: _Records) -> Buffer:
        check(records, value)
        if records.dtype == there and minimum_size(node.element) == there.itemsize:
            array = numpy.ascontiguousarray(records)
        else:
            array = numpy.zeros(len(records), there)
            _assign(array, records)
        return octets_or_view(array.view(numpy.uint8).data[:excess])

    return packed


def taker(
    node: Records, order: Order
) -> Callable[[Buffer, int, int], tuple[_Records, int]]:
    """Return the function that decodes a number of records, and the next offset."""
    there = _element_dtype(node, order)
    here = _value_dtype(node)
    padding = node.align - 1
    after = bytes(node.padding)

    def take(data: Buffer, offset: int, count: int) -> tuple[_Records, int]:
        if not count:
            return numpy.empty(0, here), offset
        start = offset + (-offset & padding)
        end = start + node.octets(count)
        if end > len(data):
            raise ValueError("a length beyond the end")
        if there == here or after:
            owned = bytearray(memoryview(data)[start:end])
            owned += after
            found = numpy.frombuffer(owned, there)
        else:
            found = numpy.frombuffer(data, there, count, start)
        return found if there == here else found.astype(here), end

    return take


def check(records: Any, expected: numpy.dtype[Any]) -> None:
    """Raise ValueError unless the records are contiguous, with these fields."""
    dtype = getattr(records, "dtype", None)
    if dtype is None:
        raise ValueError(f"an array of records is needed, not {type(records).__name__}")
    if records.ndim != 1:
        raise ValueError(f"1 dimension is needed, not {records.ndim}")
    if not _has_same_fields(dtype, expected):
        raise ValueError(f"records of {expected} are needed, not of {dtype}")


def _has_same_fields(one: numpy.dtype[Any], other: numpy.dtype[Any]) -> bool:
    """Return whether both have the same fields, in any layout and byte order."""
    if one.names != other.names or one.shape != other.shape:
        return False
    if one.names is None or other.names is None:
        return one.base.kind == other.base.kind and one.itemsize == other.itemsize
    return all(_has_same_fields(one[name], other[name]) for name in one.names)


def _assign(array: Any, found: Any) -> None:
    """Copy the fields only, so that padding stays zero."""
    if array.dtype.names is None:
        array[...] = found
        return
    for name in array.dtype.names:
        _assign(array[name], found[name])


def _value_dtype(node: Records) -> numpy.dtype[Any]:
    """Return the dtype in Python, independent of the format."""
    element = node.element
    assert isinstance(element, Group)
    return dtype_of(element.type)


def records_of(items: list[Any], struct: Descriptor) -> _Records:
    """Convert a list of structs to a structured array."""
    return numpy.array([_row(item, struct) for item in items], dtype_of(struct))


def _row(value: Any, descriptor: Descriptor) -> Any:
    described = plain(descriptor)
    if not isinstance(described, StructDescriptor):
        return list(value) if isinstance(value, bytes) else value
    return tuple(_row(getattr(value, m.attribute), m.type) for m in described.members)


def values_of(records: _Records, struct: Descriptor) -> list[Any]:
    """Convert a structured array to a list of structs."""
    return [_value(row, struct) for row in records.tolist()]


def _value(row: Any, descriptor: Descriptor) -> Any:
    described = plain(descriptor)
    if isinstance(described, ArrayDescriptor):
        return row.tobytes() if row.dtype == numpy.uint8 else row.tolist()
    if not isinstance(described, StructDescriptor):
        return row
    members = zip(row, described.members, strict=True)
    return described.class_(*(_value(part, m.type) for part, m in members))
