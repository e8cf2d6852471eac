"""Conversions between the two views of a value: CDL's types, used by codecs, and IDL's.

Each is the text of an expression; if the views are equal, the value itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    FixedArray,
    Item,
    Node,
    Octets,
    Record,
)
from rtgen.compiler.typemap.tecs.python import member_name, struct_class
from rtgen.facts.tdr import Scalar

_CHARACTERS = (Scalar.CHAR, Scalar.UCHAR)
_OCTETS = (Scalar.INT8, Scalar.UINT8, Scalar.SCHAR)
_SIGNED_OCTETS = (Scalar.INT8, Scalar.SCHAR)


def to_codec(item: Item, value: str) -> str:
    """Return the value of an IDL parameter, converted to CDL's types."""
    if not item.nullable:
        return _to_codec(item.node, value, 0)
    if isinstance(item.node, Basic) and item.node.scalar in _CHARACTERS:
        return f"ord({value}) if {value} else None"
    # The truth of an array is that of its only number.
    return f"{_to_codec(item.node, f'{value}[0]', 0)} if len({value}) else None"


def to_idl(item: Item, value: str) -> str:
    """Return a value in CDL's types, converted to the type of the IDL parameter."""
    if not item.nullable:
        return _to_idl(item.node, value, 0)
    inner = _to_idl(item.node, value, 0)
    empty, held = "[]", f"[{inner}]"
    if isinstance(item.node, Basic) and item.node.scalar in _CHARACTERS:
        empty, held = '""', inner
    elif isinstance(item.node, Basic) and item.node.scalar in _OCTETS:
        empty, held = 'b""', f"bytes([{inner}])"
    return f"{empty} if {value} is None else {held}"


def _to_codec(node: Node, value: str, depth: int) -> str:
    match node:
        case Basic(scalar) if scalar in _CHARACTERS:
            return f"ord({value})"
        case Octets(scalar) if scalar in _CHARACTERS:
            return f'{value}.encode("latin-1")'
        case Counted() if node.scalar in _CHARACTERS:
            return f'{value}.encode("latin-1")'
        case FixedArray(Basic(Scalar.INT8)) | Counted(Basic(Scalar.INT8)):
            return f"list({value})"
        case FixedArray(element) | Counted(element):
            return _each(_to_codec, element, value, depth)
        case Record(struct):
            return f"codec_{struct_class(struct.name)}({value})"
    return value


def _to_idl(node: Node, value: str, depth: int) -> str:
    match node:
        case Basic(scalar) if scalar in _CHARACTERS:
            return f"chr({value} & 255)"
        case Basic(scalar) if scalar in _SIGNED_OCTETS:
            return f"{value} & 255"
        case Octets(scalar) if scalar in _CHARACTERS:
            return f'{value}.decode("latin-1")'
        case Counted() if node.scalar in _CHARACTERS:
            return f'{value}.decode("latin-1")'
        case Counted() if node.is_octets:
            return value  # bytes in both views
        case FixedArray(Basic(Scalar.INT8)) | Counted(Basic(Scalar.INT8)):
            name = f"v{depth + 1}"
            return f"bytes([{name} & 255 for {name} in {value}])"
        case FixedArray(element) | Counted(element):
            return _each(_to_idl, element, value, depth)
        case Record(struct):
            return f"idl_{struct_class(struct.name)}({value})"
    return value


def _each(
    convert: Callable[[Node, str, int], str], element: Node, value: str, depth: int
) -> str:
    name = f"v{depth + 1}"
    inner = convert(element, name, depth + 1)
    return value if inner == name else f"[{inner} for {name} in {value}]"


def used_structs(node: Node) -> Iterator[Record]:
    """Yield the structs whose conversion functions a value's conversion calls."""
    match node:
        case Record():
            yield node
        case FixedArray(element) | Counted(element):
            yield from used_structs(element)


@dataclass(frozen=True, slots=True)
class StructViews:
    """The two functions of a struct, `codec_<class>` and `idl_<class>`.

    `to_codec` and `to_idl` are the expressions that they convert.
    """

    name: str
    idl: str
    to_codec: str
    to_idl: str


def struct_views(record: Record, idl: str, idl_members: tuple[str, ...]) -> StructViews:
    """Return the functions of a struct; `idl` is the expression of its class in IDL's view."""
    given = [
        to_codec(item, f"value.{member}")
        for item, member in zip(record.items, idl_members, strict=True)
    ]
    made = [to_idl(item, f"value.{member_name(item.name)}") for item in record.items]
    return StructViews(
        struct_class(record.struct.name), idl, ", ".join(given), ", ".join(made)
    )
