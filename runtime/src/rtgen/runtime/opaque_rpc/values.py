"""Values of OpaqueRPC messages, for generated codecs: texts, checks of sizes, C arithmetic."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence, Sized
from typing import Final, TypeVar

from rtgen.runtime.opaque_rpc.channel import More
from rtgen.runtime.opaque_rpc.errors import (
    E_NOMEM,
    E_PAR,
    E_RPC,
    ArgumentError,
    ProtocolError,
)
from rtgen.runtime.opaque_rpc.tdr import Items, Tdr

_T = TypeVar("_T")
_S = TypeVar("_S", bound=Sized)

FAILURES: Final = (
    struct.error,
    ArithmeticError,
    AttributeError,
    LookupError,
    TypeError,
    ValueError,
)
"""Exceptions raised for a value of a wrong type, range or length."""


class ByteBudget:
    """The remaining octets for arrays and texts of a message."""

    __slots__ = ("_left",)

    def __init__(self, size: int) -> None:
        self._left = size

    def take(self, count: int, width: int, most: int | None = None) -> int:
        """Subtract `count` elements from the budget; return their size in octets.

        Raises ProtocolError: E_PAR if the count is negative or over `most`, E_NOMEM if the budget
        is exceeded.
        """
        if count < 0:
            raise ProtocolError(E_PAR, f"a size of {count}")
        if most is not None and count > most:
            raise ProtocolError(E_PAR, f"a size of {count}, at most {most} allowed")
        size = count * width
        if size > self._left:
            raise ProtocolError(E_NOMEM, f"{size} bytes, {self._left} are left")
        self._left -= size
        return size


class Text:
    """Strings of 8-bit units."""

    def __init__(self, tdr: Tdr, encoding: str) -> None:
        self._order = tdr.byte_order
        self._encoding = encoding

    def units(self, text: str, most: int | None = None) -> bytes:
        """Return the octets after the length: code units and a zero.

        With `most`, the size of the buffer, C peers send another zero if there is room, and none if
        the text fills it. Raises ValueError if the text is longer or contains NUL.
        """
        data = text.encode(self._encoding)
        if 0 in data:
            raise ValueError("a NUL inside a text")
        if most is None:
            return data + b"\0"
        return (data + b"\0\0")[: _sent(len(data), most)]

    def whole(self, text: str, most: int | None = None) -> bytes:
        """Return the length, and the octets of `units`."""
        data = self.units(text, most)
        return len(data).to_bytes(4, self._order) + data

    def text(self, data: bytes) -> str:
        """Return the text up to the first zero; octets invalid in the encoding become U+FFFD."""
        return data.partition(b"\0")[0].decode(self._encoding, "replace")

    def read(self, more: More, budget: ByteBudget, most: int | None = None) -> str:
        """Return a text after its length; raises ProtocolError."""
        count = int.from_bytes(more(4), self._order, signed=True)
        return self.text(more(budget.take(count, 1, most)))


class WideText:
    """Strings of 16, 32 or 64-bit units, as lists of numbers."""

    def __init__(self, tdr: Tdr, kind: str) -> None:
        self._order = tdr.byte_order
        self._items = Items(tdr, kind)
        self.width: Final = self._items.width

    def units(self, text: Sequence[int], most: int | None = None) -> bytes:
        """As `Text.units`."""
        if 0 in text:
            raise ValueError("a zero inside a text")
        sent = len(text) + 1 if most is None else _sent(len(text), most)
        return self._items.pack([*text, 0, 0][:sent])

    def whole(self, text: Sequence[int], most: int | None = None) -> bytes:
        """As `Text.whole`."""
        data = self.units(text, most)
        return (len(data) // self.width).to_bytes(4, self._order) + data

    def text(self, data: bytes) -> list[int]:
        """Return the units up to the first zero."""
        units = self._items.integers(data, len(data) // self.width)
        return units[: units.index(0)] if 0 in units else units

    def read(
        self, more: More, budget: ByteBudget, most: int | None = None
    ) -> list[int]:
        """As `Text.read`."""
        count = int.from_bytes(more(4), self._order, signed=True)
        return self.text(more(budget.take(count, self.width, most)))


def _sent(length: int, most: int) -> int:
    """Return the number of units sent for a text of `length` from a buffer of `most` units."""
    if length > most:
        raise ValueError(f"a text of {length} units, at most {most} fit")
    return min(length + 2, most)


def exactly(values: _S, count: int) -> _S:
    """Return the values. Raises ValueError unless their number is `count`."""
    if len(values) != count:
        raise ValueError(f"{len(values)} elements, {count} are needed")
    return values


def leading(values: Sequence[_T], count: int, most: int) -> Sequence[_T]:
    """Return the first `count` values of an array with at most `most`. Raises ValueError."""
    if not count <= len(values) <= max(count, most) or not 0 <= count <= most:
        raise ValueError(f"{len(values)} elements, {count} to be sent, {most} fit")
    return values if len(values) == count else values[:count]


def leading_bytes(data: bytes, count: int, most: int) -> bytes:
    """As `leading`, for an array of octets."""
    leading(data, count, most)
    return data[:count]


def within(count: int, most: int) -> int:
    """Return the count. Raises ValueError unless it is 0 to `most`."""
    if not 0 <= count <= most:
        raise ValueError(f"a size of {count}, at most {most} allowed")
    return count


def present(value: _T | None) -> _T:
    """Return the value. Raises ValueError for NULL."""
    if value is None:
        raise ValueError("NULL where a value is needed")
    return value


def element(values: Sequence[_T], index: int) -> _T:
    """Implement C's subscript. Raises ValueError for an index out of range."""
    return values[within(index, len(values) - 1)]


def quotient(left: int, right: int) -> int:
    """Implement C's `/`, rounding towards zero. Raises ZeroDivisionError."""
    size = abs(left) // abs(right)
    return size if (left < 0) == (right < 0) else -size


def remainder(left: int, right: int) -> int:
    """Implement C's `%`, with the sign of the dividend. Raises ZeroDivisionError."""
    return left - right * quotient(left, right)


def shifted_left(value: int, bits: int) -> int:
    """Implement C's `<<` of a value of at most 64 bits. Raises ValueError."""
    return value << within(bits, 63)


def shifted_right(value: int, bits: int) -> int:
    """Implement C's `>>`. Raises ValueError."""
    return value >> within(bits, 63)


def cast(value: float, bits: int, signed: bool) -> int:
    """Implement C's conversion to an integer type."""
    low = int(value) & ((1 << bits) - 1)
    return low - (1 << bits) if signed and low >> (bits - 1) else low


def argument_error(
    function: str, failure: Exception, values: Mapping[str, object]
) -> ArgumentError:
    """Return the exception for values that cannot be encoded."""
    arguments = ", ".join(f"{name}={_short(value)}" for name, value in values.items())
    what = f"{failure} is out of range" if isinstance(failure, KeyError) else failure
    return ArgumentError(f"{function}({arguments}): {what}")


def size_error(function: str, failure: Exception) -> ProtocolError:
    """Return the exception for message sizes that cannot be computed from the values."""
    return ProtocolError(E_PAR, f"{function}: {failure}")


def is_rpc_error(code: int) -> bool:
    """Return whether the main code is E_RPC, so that outs are omitted."""
    return code & 0xFF == E_RPC & 0xFF


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
