"""Numeric sequences and arrays in Python: lists, `NumericArray`s, numpy arrays.

The form of each is settled when types are generated (`[python] numeric`, `@numeric`), and stands
in its descriptor. When a value is encoded, each form is accepted, and any other object with a
buffer of the right format.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal, Self, TypeAlias, TypeVar

from rtgen.facts.numeric import Numeric as Numeric

_A = TypeVar("_A", bound="array[Any]")
_N = TypeVar("_N", int, float)

Order: TypeAlias = Literal["<", ">"]
"""A byte order, as `struct` has it."""

_SWAPPED_BY_NUMPY = 1000

_SWAPPED = {"<": sys.byteorder == "big", ">": sys.byteorder == "little"}
_ORDERS = {**_SWAPPED, "!": sys.byteorder == "little"}
"""Whether octets in a byte order are not those of the machine."""

_KINDS = {
    **dict.fromkeys("bhilqn", "int"),
    **dict.fromkeys("BHILQN", "unsigned int"),
    **dict.fromkeys("fd", "float"),
}


if TYPE_CHECKING:
    _Array: TypeAlias = array
else:

    class _Array(array):
        """Subscripted by type checkers only: Python 3.11's array is no generic class."""

        __slots__ = ()

        def __class_getitem__(cls, item):
            return cls


class NumericArray(_Array[_N]):
    """An `array.array` that equals lists and tuples of the same numbers.

    A slice of one is an `array.array`.
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


def is_swapped(order: Order) -> bool:
    """Whether the byte order (`<`, `>`) is not that of the machine."""
    return _SWAPPED[order]


def swapped(numbers: _A, octets: Any) -> _A:
    """The same array with the octets of each number in the other order; `octets` are those it has.

    numpy does it in an eighth of the time, if it has been imported already.
    """
    numpy = sys.modules.get("numpy")
    if numpy is None or len(numbers) < _SWAPPED_BY_NUMPY:
        numbers.byteswap()
    else:
        items = numpy.frombuffer(numbers, f"u{numbers.itemsize}")
        items[...] = numpy.frombuffer(octets, items.dtype.newbyteorder())
    return numbers


def buffer_of(items: Any, code: str, size: int) -> memoryview | None:
    """The buffer of numbers of a `struct` code, one behind the other; None for other objects.

    Raises ValueError for a buffer of another format or number of dimensions.
    """
    if isinstance(items, list | tuple):
        return None
    try:
        view = memoryview(items)
    except TypeError:
        return None
    kind = _KINDS.get(view.format[-1:])
    if kind != _KINDS[code] or view.itemsize != size or len(view.format) > 2:
        wanted = f"{_KINDS[code]} of {8 * size} bits (format {code!r})"
        raise ValueError(f"a buffer of {wanted} is needed, not of {view.format!r}")
    if view.ndim != 1:
        raise ValueError(f"a buffer of 1 dimension is needed, not of {view.ndim}")
    return view


def octets_of(view: memoryview, code: str, order: Order) -> bytes:
    """The numbers of a buffer in a byte order."""
    if _ORDERS.get(view.format[0], False) == _SWAPPED[order]:
        return view.tobytes()
    octets = view.tobytes()
    return swapped(array(code, octets), octets).tobytes()


def array_of(octets: bytes, code: str, order: Order) -> NumericArray[Any]:
    """The array of the octets of numbers."""
    made = NumericArray(code, octets)
    return swapped(made, octets) if _SWAPPED[order] else made


def packed(items: Any, code: str, size: int, order: Order) -> bytes:
    """The octets of numbers in any form.

    Raises ValueError or a related error for what the type does not have.
    """
    view = buffer_of(items, code, size)
    if view is not None:
        return octets_of(view, code, order)
    return struct.pack(f"{order}{len(items)}{code}", *items)


def copied(items: Any) -> Any:
    """A copy of numbers in any form, of the same form."""
    if isinstance(items, array):
        return NumericArray(items.typecode, items)
    if isinstance(items, list):
        return items[:]
    copy = getattr(items, "copy", None)
    return list(items) if copy is None else copy()
