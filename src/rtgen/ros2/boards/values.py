"""Values of CDL's types, as proxies of boards have them, and those of messages of ROS 2."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

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
from rtgen.facts.tdr import Scalar
from rtgen.ros2.boards.types import field_names

Convert: TypeAlias = Callable[[Any], Any]
Classes: TypeAlias = Mapping[tuple[str, ...], tuple[type[Any], type[Any]]]
"""The class of a struct in CDL and that of its message, by its name in CDL."""


def to_board(item: Item, classes: Classes) -> Convert:
    """Return the function from the value of a field to that of an argument or member."""
    convert = _to_board(item.node, classes)
    if not item.nullable:
        return convert
    return lambda value: convert(value[0]) if len(value) else None


def to_message(item: Item, classes: Classes) -> Convert:
    """Return the function from a result or member to the value of a field."""
    convert = _to_message(item.node, classes)
    if not item.nullable:
        return convert
    octets = isinstance(item.node, Basic) and item.node.scalar in _UNSIGNED_OCTETS

    def optional(value: Any) -> Any:
        some = [] if value is None else [convert(value)]
        return bytes(some) if octets else some

    return optional


_UNSIGNED_OCTETS = (Scalar.CHAR, Scalar.UCHAR, Scalar.UINT8)
"""Types whose arrays are octets in messages."""


def _same(value: Any) -> Any:
    return value


def _to_board(node: Node, classes: Classes) -> Convert:
    match node:
        case Octets(scalar):
            return _octets(scalar)
        case Counted(Basic(scalar)) if node.is_octets:
            return _octets(scalar)
        case FixedArray(element) | Counted(element):
            convert = _to_board(element, classes)
            return lambda values: [convert(value) for value in values]
        case Record():
            class_, _ = classes[node.struct.name]
            names = field_names((i.name for i in node.items), ()).values()
            members = [
                (name, to_board(item, classes))
                for name, item in zip(names, node.items, strict=True)
            ]
            return lambda value: class_(
                *(convert(getattr(value, name)) for name, convert in members)
            )
        case String() if node.is_wide:
            return list
    return _same


def _octets(scalar: Scalar) -> Convert:
    """Return the function for the octets of an array."""
    if scalar in _UNSIGNED_OCTETS:
        return bytes
    return lambda values: bytes(value & 0xFF for value in values)


def _to_message(node: Node, classes: Classes) -> Convert:
    match node:
        case Octets(scalar) | Counted(Basic(scalar)) | FixedArray(Basic(scalar)):
            if scalar in _UNSIGNED_OCTETS:
                return bytes
            if isinstance(node, Octets) or (
                isinstance(node, Counted) and node.is_octets
            ):
                return lambda octets: [(each ^ 0x80) - 0x80 for each in octets]
            return list
        case FixedArray(element) | Counted(element):
            convert = _to_message(element, classes)
            return lambda values: [convert(value) for value in values]
        case Record():
            _, class_ = classes[node.struct.name]
            converts = [to_message(item, classes) for item in node.items]

            def message(value: Any) -> Any:
                members = (getattr(value, name) for name in value.__struct_fields__)
                pairs = zip(converts, members, strict=True)
                return class_(*(convert(member) for convert, member in pairs))

            return message
        case String() if node.is_wide:
            return list
    return _same
