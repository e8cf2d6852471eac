"""Descriptions and hashes of ROS 2 types: REP 2016, "Type Description Interfaces and RIHS01"."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from hashlib import sha256
from typing import Any, Final, NamedTuple

from rtgen.facts.primitives import Primitive

_NESTED: Final = 1
_IDS: Final[Mapping[str, int]] = {
    Primitive.INT8: 2,
    Primitive.UINT8: 3,
    Primitive.SHORT: 4,
    Primitive.UNSIGNED_SHORT: 5,
    Primitive.LONG: 6,
    Primitive.UNSIGNED_LONG: 7,
    Primitive.LONG_LONG: 8,
    Primitive.UNSIGNED_LONG_LONG: 9,
    Primitive.FLOAT: 10,
    Primitive.DOUBLE: 11,
    Primitive.LONG_DOUBLE: 12,
    Primitive.CHAR: 13,
    Primitive.WCHAR: 14,
    Primitive.BOOLEAN: 15,
    Primitive.OCTET: 16,
}
_STRING, _BOUNDED_STRING, _BOUNDED_WIDE_STRING = 17, 21, 22
"""Type ids of type_description_interfaces/msg/FieldType; those of wide strings are one higher."""
_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144
"""Added to the type id of the elements."""
_VERSION: Final = "RIHS01_"


class Element(NamedTuple):
    """A type that is neither array nor sequence."""

    id: int
    string_capacity: int = 0
    nested: str = ""


def primitive(name: str) -> Element | None:
    """Return a primitive type by its IDL name; None if ROS 2 has none."""
    return Element(_IDS[name]) if name in _IDS else None


def string(bound: int | None, *, wide: bool) -> Element:
    """Return the element for strings."""
    return Element((_BOUNDED_STRING if bound else _STRING) + wide, bound or 0)


def nested(name: str) -> Element:
    """Return the element for another message."""
    return Element(_NESTED, nested=name)


def field_type(
    element: Element, *, array: int | None = None, sequence: int | None = None
) -> dict[str, Any]:
    """Return the FieldType of a field: `array` elements, or a sequence of up to `sequence` (0:
    any).

    As rosidl_parser (Jazzy, Kilted), an unbounded sequence of bounded wide strings has their bound.
    """
    added = 0
    if sequence == 0 and element.id == _BOUNDED_WIDE_STRING:
        sequence = element.string_capacity
    if array is not None:
        added = _ARRAY
    elif sequence is not None:
        added = _BOUNDED_SEQUENCE if sequence else _SEQUENCE
    return {
        "type_id": element.id + added,
        "capacity": array or sequence or 0,
        "string_capacity": element.string_capacity,
        "nested_type_name": element.nested,
    }


def description(
    name: str, fields: Iterable[tuple[str, dict[str, Any]]]
) -> dict[str, Any]:
    """Return the IndividualTypeDescription of a type with fields of these names and types."""
    return {
        "type_name": name,
        "fields": [{"name": key, "type": type_} for key, type_ in fields],
    }


def rihs01(whole: dict[str, Any], referenced: Mapping[str, dict[str, Any]]) -> str:
    """Return the hash of a description and of those of all types that it refers to, by name."""
    import json

    described = {
        "type_description": whole,
        "referenced_type_descriptions": [
            referenced[name] for name in sorted(referenced)
        ],
    }
    text = json.dumps(described, separators=(", ", ": "), ensure_ascii=True)
    return _VERSION + sha256(text.encode()).hexdigest()
