"""Numeric sequences and arrays in one piece: functions that compiled codecs call."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable
from functools import cache
from math import prod
from typing import Any, TypeAlias

from rtgen.runtime.marshalling.errors import Buffer
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Form,
    Records,
)
from rtgen.runtime.marshalling.layouts.packers import LARGE
from rtgen.runtime.marshalling.numeric import (
    NumericArray,
    Order,
    array_of,
    buffer_of,
    flattened,
    is_swapped,
    numbers_in,
    octets_of,
    packed,
    swapped_array,
    swapped_octets,
)
from rtgen.runtime.marshalling.octets import exact

_Put: TypeAlias = Callable[[Any], tuple[int, Any]]
_Take: TypeAlias = Callable[[Buffer, int, int], tuple[Any, int]]

_SLICED = 1024
"""Up to this number of octets, slicing `bytes` is faster than a view."""


def buffer_code(atom: Atom) -> str:
    """Return the `struct` code of buffers of an atom's values; empty if there is none."""
    codes = {Form.NUMBER: atom.code, Form.BOOLEAN: "?"}
    return codes.get(atom.form, "")


@cache
def lister(code: str, size: int) -> Callable[[Any], Any]:
    """Return the function that returns the numbers of a buffer as a list, lists unchanged.

    It raises ValueError.
    """

    def listed(items: Any) -> Any:
        view = buffer_of(items, code, size)
        return items if view is None else numbers_in(view)

    return listed


@cache
def flattener(
    code: str, size: int, dimensions: tuple[int, ...]
) -> Callable[[Any], Any]:
    """Return `flattened` for arrays of these numbers."""
    return lambda items: flattened(items, code, size, dimensions)


class Sequences:
    """Functions of a numeric sequence.

    `put_*` returns the key by which a table of shapes packs the items (a number of octets as the
    negative number of items), and the data to pack. `take_*` returns the value of a number of items
    at an offset, and the next offset. Both raise ValueError.
    """

    __slots__ = ("put_big", "put_little", "take_big", "take_little")

    def __init__(self, node: AtomSequence) -> None:
        atom = node.atom
        taker = _numpy_taker if node.form == "numpy" else _array_taker
        self.put_little, self.put_big = _putter(atom, "<"), _putter(atom, ">")
        self.take_little, self.take_big = taker(atom, "<"), taker(atom, ">")


class Arrays:
    """Functions of a numeric array: to a fixed number of octets, and back."""

    __slots__ = ("made_big", "made_little", "octets_big", "octets_little")

    def __init__(self, node: AtomArray) -> None:
        self.octets_little, self.octets_big = _array_octets(node, "<"), _array_octets(
            node, ">"
        )
        self.made_little, self.made_big = _array_maker(node, "<"), _array_maker(
            node, ">"
        )


class Structured:
    """Functions of a sequence of records that is a structured numpy array."""

    __slots__ = ("octets_big", "octets_little", "take_big", "take_little")

    def __init__(self, node: Records) -> None:
        from rtgen.runtime.marshalling.structured import octets, taker

        self.octets_little, self.octets_big = octets(node, "<"), octets(node, ">")
        self.take_little, self.take_big = taker(node, "<"), taker(node, ">")


def _putter(atom: Atom, order: Order) -> _Put:
    code, size = atom.code, atom.size
    other = is_swapped(order)
    many = LARGE // size

    def put(items: Any) -> tuple[int, Any]:
        if isinstance(items, array) and items.typecode == code and items:
            if other:
                return -len(items), (swapped_octets(items),)
            count = len(items)
            return -count, (items if count >= many else items.tobytes(),)
        view = buffer_of(items, code, size)
        if view is None or not len(view):
            return len(items), items
        return -len(view), (octets_of(view, order),)

    return put


def _array_taker(atom: Atom, order: Order) -> _Take:
    code, size, padding = atom.code, atom.size, atom.align - 1
    other = is_swapped(order)

    def take(data: Buffer, offset: int, count: int) -> tuple[Any, int]:
        if not count:
            return NumericArray(code), offset
        start = offset + (-offset & padding)
        end = start + count * size
        if end > len(data):
            raise ValueError("a length beyond the end")
        short = end - start <= _SLICED and type(data) is bytes
        octets: Buffer = data[start:end] if short else memoryview(data)[start:end]
        if other:
            return swapped_array(octets, code), end
        if short:
            return NumericArray(code, octets), end
        array = NumericArray(code)
        array.frombytes(octets)
        return array, end

    return take


def _numpy_taker(atom: Atom, order: Order) -> _Take:
    import numpy

    code, size, padding = atom.code, atom.size, atom.align - 1
    here = numpy.dtype(code)
    there = here.newbyteorder(order)

    def take(data: Buffer, offset: int, count: int) -> tuple[Any, int]:
        if not count:
            return numpy.empty(0, here), offset
        start = offset + (-offset & padding)
        end = start + count * size
        if end > len(data):
            raise ValueError("a length beyond the end")
        if there == here:
            owned = bytearray(memoryview(data)[start:end])
            return numpy.frombuffer(owned, here), end
        return numpy.frombuffer(data, there, count, start).astype(here), end

    return take


def _array_octets(node: AtomArray, order: Order) -> Callable[[Any], Buffer]:
    code, size = node.atom.code, node.atom.size
    if len(node.dimensions) > 1:
        return _nested_octets(node, order)
    (length,) = node.dimensions
    return lambda items: packed(exact(items, length), code, size, order)


def _nested_octets(node: AtomArray, order: Order) -> Callable[[Any], Buffer]:
    code, size, dimensions = node.atom.code, node.atom.size, node.dimensions
    pack = struct.Struct(f"{order}{prod(dimensions)}{code}").pack

    def octets(items: Any) -> Buffer:
        view = buffer_of(items, code, size, dimensions)
        if view is not None:
            return octets_of(view, order)
        return pack(*flattened(items, code, size, dimensions))

    return octets


def _array_maker(node: AtomArray, order: Order) -> Callable[[bytes], Any]:
    code = node.atom.code
    if node.form == "array":
        return lambda octets: array_of(octets, code, order)
    import numpy

    here = numpy.dtype(code)
    there = here.newbyteorder(order)
    return lambda octets: (
        numpy.frombuffer(octets, there).astype(here).reshape(node.dimensions)
    )
