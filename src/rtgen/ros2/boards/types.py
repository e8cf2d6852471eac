"""Types of CDL in ROS 2 interface files, by their layout on the wire.

Unlike at service ports, no number loses its sign: an `int8_t` is an `int8`, characters are `uint8`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Final

from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    FixedArray,
    Item,
    Node,
    Octets,
    Record,
    String,
)
from rtgen.compiler.typemap.tecs.idl import Widths
from rtgen.facts.tdr import Scalar
from rtgen.ros2.backend.fields import InexpressibleError, field_name, free_name

_SCALARS: Final[Mapping[Scalar, str]] = {
    Scalar.BOOL: "bool",
    Scalar.CHAR: "uint8",
    Scalar.UCHAR: "uint8",
    Scalar.SCHAR: "int8",
    Scalar.INT8: "int8",
    Scalar.UINT8: "uint8",
    Scalar.INT16: "int16",
    Scalar.UINT16: "uint16",
    Scalar.INT32: "int32",
    Scalar.UINT32: "uint32",
    Scalar.INT64: "int64",
    Scalar.UINT64: "uint64",
    Scalar.LONG_LONG: "int64",
    Scalar.ULONG_LONG: "uint64",
    Scalar.FLOAT32: "float32",
    Scalar.DOUBLE64: "float64",
}


def item_type(item: Item, widths: Widths, reference: Callable[[Record], str]) -> str:
    """Return the type of a parameter or member; NULL is an empty sequence.

    `reference` returns the name of a struct's message. Raises InexpressibleError.
    """
    if not item.nullable:
        return _type(item.node, widths, reference)
    try:
        return f"{_element(item.node, widths, reference)}[<=1]"
    except _NestedError:
        raise InexpressibleError("sequences and arrays that may be NULL") from None


def field_names(names: Iterable[str], taken: Iterable[str]) -> dict[str, str]:
    """Return the names of fields: `minAngle` is `min_angle`; `_value` follows a keyword, and a
    name of `taken`.

    Raises InexpressibleError for a name that ROS 2 has not, or a second time.
    """
    fields: dict[str, str] = {}
    reserved = {*taken}
    for name in names:
        field = free_name(field_name(name), reserved)
        if field in fields.values():
            raise InexpressibleError(f"the name {name} beside the others")
        if not field[:1].isalpha():
            raise InexpressibleError(f"the name {name}, which begins with no letter")
        fields[name] = field
    return fields


class _NestedError(InexpressibleError):
    """A sequence or an array in another one."""

    def __init__(self) -> None:
        super().__init__("sequences and arrays in each other")


def _type(node: Node, widths: Widths, reference: Callable[[Record], str]) -> str:
    match node:
        case Octets(scalar, count):
            return f"{_scalar(scalar, widths)}[{count}]"
        case FixedArray(element, count):
            return f"{_element(element, widths, reference)}[{count}]"
        case Counted(element, _, _, most):
            bound = "" if most is None else f"<={most}"
            return f"{_element(element, widths, reference)}[{bound}]"
        case String(scalar) if node.is_wide:
            return f"{_scalar(scalar, widths)}[]"
    return _element(node, widths, reference)


def _element(node: Node, widths: Widths, reference: Callable[[Record], str]) -> str:
    match node:
        case Basic(scalar):
            return _scalar(scalar, widths)
        case Record():
            return reference(node)
        case String() if not node.is_wide:
            return "string"
    raise _NestedError


def _scalar(scalar: Scalar, widths: Widths) -> str:
    width = widths.of(scalar)
    if width is not None:
        bits, signed = width
        return f"{'' if signed else 'u'}int{bits}"
    if scalar not in _SCALARS:
        raise InexpressibleError(f"numbers of the width of {scalar}")
    return _SCALARS[scalar]
