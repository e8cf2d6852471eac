"""Test arguments of functions at the limits of their types, as JSON of `rtgen rpc`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    FixedArray,
    Item,
    Node,
    Octets,
    Record,
    String,
    references,
    sizes_of,
)
from rtgen.facts.tdr import BITS, LETTERS, WIDTH_NAMES, Scalar
from rtgen.runtime.opaque_rpc import Tdr
from rtgen.tools.rpc.codecs import Function
from rtgen.tools.rpc.values import Json

Pick: TypeAlias = Callable[[Scalar], Json]

_LARGEST_FLOAT: Final = {
    Scalar.FLOAT32: 3.4028234663852886e38,
    Scalar.DOUBLE64: 1.7976931348623157e308,
}
_UNBOUNDED_LENGTH: Final = 16
"""Test length of unbounded arrays and texts, in elements or units."""
MAX_LENGTH: Final = 4096
"""Maximum length tested, in elements or units."""


def zero(scalar: Scalar) -> Json:
    """Return the zero value: 0 or false."""
    return scalar is not Scalar.BOOL and 0


def ends(scalar: Scalar, tdr: Tdr) -> tuple[Json, Json]:
    """Return the minimum and maximum of a type in a data representation."""
    if scalar is Scalar.BOOL:
        return False, True
    if scalar in _LARGEST_FLOAT:
        return -_LARGEST_FLOAT[scalar], _LARGEST_FLOAT[scalar]
    letter = LETTERS[scalar]
    width = WIDTH_NAMES.get(letter.lower())
    bits = BITS[letter.lower()] if width is None else int(getattr(tdr, width))
    if letter.isupper():
        return 0, (1 << bits) - 1
    return -(1 << bits - 1), (1 << bits - 1) - 1


@dataclass(frozen=True, slots=True)
class Values:
    """Test values: numbers, lengths that others depend on, texts, and NULL."""

    number: Pick = zero
    length: int = 0
    full: bool = False
    null: bool = False


def lengths(function: Function) -> frozenset[str]:
    """Return the parameters that sizes of others refer to."""
    return frozenset(
        name
        for item in function.layout.items
        for size in sizes_of(item.node)
        for name in references(size)
    )


def arguments(
    function: Function, values: Values, fixed: Mapping[str, Json] | None = None
) -> dict[str, Json]:
    """Return the arguments of a call; `fixed` by name. Raises ArgumentError for bad sizes."""
    values_by_name: dict[str, Json] = {}
    sized = lengths(function)
    stated = fixed or {}
    # Numbers come first, since sizes refer to them.
    listed = sorted(function.layout.arguments, key=lambda item: item.name not in sized)
    for item in listed:
        if item.name in stated:
            values_by_name[item.name] = stated[item.name]
        elif item.asked:
            values_by_name[item.name] = None if values.null else {"want": True}
        elif item.nullable and values.null:
            values_by_name[item.name] = None
        elif item.name in sized and isinstance(item.node, Basic):
            values_by_name[item.name] = values.length
        else:
            values_by_name[item.name] = _value(
                function, item.node, values, values_by_name
            )
    return {item.name: values_by_name[item.name] for item in function.layout.arguments}


def _value(
    function: Function, node: Node, values: Values, values_by_name: Mapping[str, object]
) -> Json:
    def of(inner: Node) -> Json:
        return _value(function, inner, values, values_by_name)

    match node:
        case Basic(scalar):
            return values.number(scalar)
        case Octets(scalar, count):
            return [values.number(scalar)] * count
        case FixedArray(element, count):
            return [of(element) for _ in range(count)]
        case Counted(element):
            return [
                of(element)
                for _ in range(function.evaluated(node.count, values_by_name))
            ]
        case String():
            return "x" * (_units(function, node, values_by_name) if values.full else 0)
        case Record(items=items):
            return _members(function, items, values)
    return None


def _units(
    function: Function, node: String, values_by_name: Mapping[str, object]
) -> int:
    """Return the length of the longest text without its terminator."""
    if node.length is None:
        return _UNBOUNDED_LENGTH
    return min(MAX_LENGTH, max(0, function.evaluated(node.length, values_by_name) - 1))


def _members(
    function: Function, items: Sequence[Item], values: Values
) -> dict[str, Json]:
    sized = {n for i in items for size in sizes_of(i.node) for n in references(size)}
    members: dict[str, Json] = {}
    for item in sorted(items, key=lambda item: item.name not in sized):
        if item.name in sized and isinstance(item.node, Basic):
            members[item.name] = values.length
        else:
            inner = _value(function, item.node, values, members)
            members[item.name] = [inner] if item.pointer else inner
    return {item.name: members[item.name] for item in items}


def scalars(function: Function) -> Iterator[tuple[str, Scalar]]:
    """Yield the numeric arguments on which no size depends."""
    sized = lengths(function)
    for item in function.layout.arguments:
        if item.name not in sized and not item.asked and isinstance(item.node, Basic):
            yield item.name, item.node.scalar


def longest(function: Function) -> int | None:
    """Return the greatest length within the bounds of all arrays; None without arrays."""
    arrays = [i.node for i in function.layout.items if isinstance(i.node, Counted)]
    if not arrays or not lengths(function):
        return None
    most = max(
        (a.most for a in arrays if a.most is not None), default=_UNBOUNDED_LENGTH
    )
    for length in range(min(most, MAX_LENGTH), -1, -1):
        if not exceeds(function, length):
            return length
    return None


def exceeds(function: Function, length: int) -> bool:
    """Return whether the length exceeds an array's bound, or the type of its length."""
    sizes = dict.fromkeys(lengths(function), length)
    for item in function.layout.items:
        node = item.node
        if isinstance(node, Counted):
            size = function.evaluated(node.size, sizes)
            if size < 0 or (node.most is not None and size > node.most):
                return True
    return False
