"""Numeric sequences and arrays in Python: lists, `NumericArray`s, numpy arrays.

The form of each is determined when types are generated (`[python] numeric`, `@numeric`), and is
part of its descriptor. When a value is encoded, every form is accepted, and any other object with a
buffer of the right format.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Iterable, Mapping, Sequence, Set
from functools import cache
from typing import TYPE_CHECKING, Any, Literal, Self, TypeAlias, TypeVar

from rtgen.facts.numeric import Numeric as Numeric
from rtgen.runtime.marshalling.errors import Buffer
from rtgen.runtime.marshalling.last_arrays import LastArrays
from rtgen.runtime.marshalling.layouts.packers import LARGE
from rtgen.runtime.marshalling.octets import nested

_N = TypeVar("_N", int, float)

Order: TypeAlias = Literal["<", ">"]
"""A byte order in the notation of `struct`."""

_NUMPY_SWAP_THRESHOLD = 2500
_ALLOCATED_ANEW = 100_000
"""From about this number of octets, the C library maps memory again for each allocation."""

_SWAPPED = {"<": sys.byteorder == "big", ">": sys.byteorder == "little"}
_ORDERS = {**_SWAPPED, "!": sys.byteorder == "little"}
"""Whether a byte order differs from the machine's."""

_WORDS = {array(code).itemsize: code for code in "BHIQ"}
"""Codes of `array` by the size of an item."""

_KINDS = {
    **dict.fromkeys("bhilqn", "int"),
    **dict.fromkeys("cBHILQN", "unsigned int"),
    **dict.fromkeys("fd", "float"),
    "?": "bool",
}
_CODES = {(_KINDS[code], struct.calcsize(f"={code}")): code for code in "bBhHiIqQfd?"}
"""Codes of `struct` in standard sizes, by kind and size."""


if TYPE_CHECKING:
    _Array: TypeAlias = array
else:

    class _Array(array):
        """Subscripted by type checkers only: array is not a generic class in Python 3.11."""

        __slots__ = ()

        def __class_getitem__(cls, item):
            return cls


class NumericArray(_Array[_N]):
    """An `array.array` that equals lists and tuples of the same numbers.

    Slicing it gives an `array.array`.
    """

    __slots__ = ()
    __hash__ = None

    def __eq__(self, other: object) -> bool:
        if isinstance(other, list | tuple):
            return len(self) == len(other) and self.tolist() == list(other)
        return array.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        equal = self.__eq__(other)
        return equal if equal is NotImplemented else not equal

    def __iadd__(self, other: Iterable[_N]) -> Self:
        self.extend(other)
        return self

    def __copy__(self) -> Self:
        return type(self)(self.typecode, self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.__copy__()


_LAST: LastArrays[NumericArray[Any]] = LastArrays()
_LAST_ENCODED: LastArrays[NumericArray[Any]] = LastArrays()


def is_swapped(order: Order) -> bool:
    """Return whether a byte order (`<`, `>`) differs from the machine's."""
    return _SWAPPED[order]


def _numpy_for(count: int) -> Any:
    """Return numpy for that many numbers, if it is already imported: it swaps faster."""
    numpy = sys.modules.get("numpy") if count >= _NUMPY_SWAP_THRESHOLD else None
    return numpy if hasattr(numpy, "frombuffer") else None  # not while it is imported


@cache
def _words(size: int) -> tuple[Any, Any]:
    """Return numpy's types of words of this size: in the machine's byte order, in the other one."""
    words = sys.modules["numpy"].dtype(f"u{size}")
    return words, words.newbyteorder()


def _swap(numpy: Any, array: Any, numbers: Any, size: int) -> None:
    """Fill a buffer (without numpy an array) with numbers of this size, each swapped."""
    if numpy is None:
        memoryview(array).cast("B")[:] = numbers
        array.byteswap()
        return
    words, swapped = _words(size)
    numpy.frombuffer(array, words)[...] = numpy.frombuffer(numbers, swapped)


def _zeros(zeros: NumericArray[Any], count: int) -> NumericArray[Any]:
    """Fill an empty array, which is faster than copying octets into it."""
    zeros.append(0)
    zeros *= count
    return zeros


def _swapped(
    last: LastArrays[NumericArray[Any]], numpy: Any, octets: Any, code: str, count: int
) -> NumericArray[Any]:
    """Return an array of that many numbers, each swapped; numpy may be None."""
    array = last.unused(code, count) or _zeros(NumericArray(code), count)
    _swap(numpy, array, octets, array.itemsize)
    last.keep(array)
    return array


def swapped_array(octets: Any, code: str) -> NumericArray[Any]:
    """Return the array of numbers in the other byte order; `octets` are bytes or a view."""
    array = NumericArray(code)
    count = len(octets) // array.itemsize
    numpy = _numpy_for(count)
    if numpy is not None:
        return _swapped(_LAST, numpy, octets, code, count)
    array.frombytes(octets)
    array.byteswap()
    return array


def swapped_octets(numbers: Any) -> bytes | memoryview:
    """Return the swapped octets of an array, or of a view of numbers; many are a view."""
    count, size = len(numbers), numbers.itemsize
    code = _WORDS[size]
    numpy = _numpy_for(count)
    is_short = count * size < _ALLOCATED_ANEW
    if numpy is None and is_short:
        copy = array(code, numbers.tobytes())
        copy.byteswap()
        return copy.tobytes() if count * size < LARGE else memoryview(copy)
    if numpy is None or not memoryview(numbers).c_contiguous:
        numbers = numbers.tobytes()
    if not is_short:
        return memoryview(_swapped(_LAST_ENCODED, numpy, numbers, code, count))
    octets = bytearray(count * size)
    _swap(numpy, octets, numbers, size)
    return octets_or_view(memoryview(octets))


def buffer_of(
    items: Any, code: str, size: int, shape: tuple[int, ...] | None = None
) -> memoryview | None:
    """Return the buffer of numbers of a `struct` code; None for other ordered collections.

    Raises ValueError for a buffer of another format or shape (by default: one dimension), and for
    objects without an order.
    """
    if isinstance(items, list | tuple):
        return None
    try:
        view = memoryview(items)
    except TypeError:
        if isinstance(items, Mapping | Set):
            message = f"a list is needed, not {type(items).__name__}"
            raise ValueError(message) from None
        return None
    kind = _KINDS.get(view.format[-1:])
    if kind != _KINDS[code] or view.itemsize != size or len(view.format) > 2:
        expectation = f"{_KINDS[code]} of {8 * size} bits (format {code!r})"
        raise ValueError(f"a buffer of {expectation} is needed, not of {view.format!r}")
    if shape is None and view.ndim != 1:
        raise ValueError(f"a buffer of 1 dimension is needed, not of {view.ndim}")
    if shape is not None and view.shape != shape:
        raise ValueError(f"the shape {view.shape} instead of {shape}")
    if hasattr(items, "mask"):
        raise ValueError("a masked array is not marshalled: call its method filled")
    return view


def octets_or_view(view: memoryview) -> bytes | memoryview:
    """Return the octets of a view; if they are many and contiguous, the view itself."""
    return view if view.nbytes >= LARGE and view.c_contiguous else view.tobytes()


def octets_of(view: memoryview, order: Order) -> Buffer:
    """Return the numbers of a buffer in a byte order; many may be a view."""
    if _ORDERS.get(view.format[0], False) == _SWAPPED[order]:
        return octets_or_view(view)
    if view.ndim != 1:
        return swapped_octets(array(_WORDS[view.itemsize], view.tobytes()))
    return swapped_octets(view)


def numbers_in(view: memoryview) -> list[Any]:
    """Return the numbers of a buffer in either byte order, flattened."""
    if view.ndim == len(view.format) == 1 and view.format != "c":
        return view.tolist()
    order = view.format[0] if view.format[0] in "<>!" else "="
    code = _CODES[_KINDS[view.format[-1]], view.itemsize]
    octets = view.tobytes()
    return [*struct.unpack(f"{order}{len(octets) // view.itemsize}{code}", octets)]


def flattened(
    items: Any, code: str, size: int, dimensions: tuple[int, ...]
) -> Sequence[Any]:
    """Return the numbers of an array in any form as one sequence. Raises ValueError."""
    if items.__class__ is not list:
        view = buffer_of(items, code, size, dimensions)
        if view is not None:
            return numbers_in(view)
    if len(items) != dimensions[0]:
        raise ValueError(f"{len(items)} items instead of {dimensions[0]}")
    if len(dimensions) == 1:
        numbers: Sequence[Any] = items
        return numbers
    inner = dimensions[1:]
    return [n for row in items for n in flattened(row, code, size, inner)]


def array_of(octets: bytes, code: str, order: Order) -> NumericArray[Any]:
    """Return the array of the octets of numbers."""
    return (
        swapped_array(octets, code) if _SWAPPED[order] else NumericArray(code, octets)
    )


def packed(items: Any, code: str, size: int, order: Order) -> Buffer:
    """Return the octets of numbers in any form; many may be a view.

    Raises ValueError or a related error for invalid values.
    """
    view = buffer_of(items, code, size)
    if view is not None:
        return octets_of(view, order)
    return struct.pack(f"{order}{len(items)}{code}", *items)


def copied(items: Any) -> Any:
    """Return a copy of numbers in any form, of the same form."""
    if isinstance(items, array):
        return NumericArray(items.typecode, items)
    if isinstance(items, list):
        return items[:]
    copy = getattr(items, "copy", None)
    return listed(items) if copy is None else copy()


def listed(items: Any, depth: int = 1) -> list[Any]:
    """Return a new list of numbers in any form; of rows, if they have that many dimensions."""
    if items.__class__ is not list:
        tolist = getattr(items, "tolist", None)
        if tolist is not None and not isinstance(items, memoryview):
            numbers_list: list[Any] = tolist()
            return numbers_list
        try:
            view = memoryview(items)
        except TypeError:
            pass
        else:
            return nested(numbers_in(view), view.shape or ())
    return [*items] if depth == 1 else [listed(row, depth - 1) for row in items]
