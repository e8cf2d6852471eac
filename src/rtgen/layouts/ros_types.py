"""Descriptions and hashes of ROS 2 types: REP 2016, "Type Description Interfaces and RIHS01"."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import sha256
from typing import Any, Final

from rtgen.facts.primitives import Primitive
from rtgen.model import (
    ArrayType,
    Model,
    NamedType,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
)

_NESTED: Final = 1
_IDS: Final = {
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
_STRING, _BOUNDED_STRING = 17, 21
"""Of wide strings, one more."""
_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144
"""Identifiers of type_description_interfaces/msg/FieldType: of elements, and added to them."""
_VERSION: Final = "RIHS01_"


def type_name(name: ScopedName) -> str:
    """The name as ROS 2 writes it: `std_msgs/msg/Header`."""
    return "/".join(name)


def type_hash(model: Model, struct: Struct) -> str:
    """The hash of a message (`RIHS01_...`). Raises ValueError for types that ROS 2 lacks."""
    import json

    referenced: dict[str, Struct] = {}
    _collect(model, struct, referenced)
    description = {
        "type_description": _individual(model, struct),
        "referenced_type_descriptions": [
            _individual(model, referenced[name]) for name in sorted(referenced)
        ],
    }
    text = json.dumps(description, separators=(", ", ": "), ensure_ascii=True)
    return _VERSION + sha256(text.encode()).hexdigest()


def _collect(model: Model, struct: Struct, found: dict[str, Struct]) -> None:
    for nested in _nested(model, struct):
        name = type_name(nested.name)
        if name not in found:
            found[name] = nested
            _collect(model, nested, found)


def _nested(model: Model, struct: Struct) -> Iterator[Struct]:
    for member in struct.members:
        type_ = member.type
        if isinstance(type_, SequenceType | ArrayType):
            type_ = type_.element
        if isinstance(type_, NamedType):
            declaration = model.find(type_.name)
            if isinstance(declaration, Struct):
                yield declaration


def _individual(model: Model, struct: Struct) -> dict[str, Any]:
    return {
        "type_name": type_name(struct.name),
        "fields": [
            {"name": member.name, "type": _field_type(member.type)}
            for member in struct.members
        ],
    }


def _field_type(type_: Type) -> dict[str, Any]:
    added, capacity, element = 0, 0, type_
    if isinstance(type_, ArrayType) and len(type_.dimensions) == 1:
        added, capacity, element = _ARRAY, type_.dimensions[0], type_.element
    elif isinstance(type_, SequenceType):
        added = _SEQUENCE if type_.bound is None else _BOUNDED_SEQUENCE
        capacity, element = type_.bound or 0, type_.element
    identifier, nested, length = 0, "", 0
    if isinstance(element, NamedType):
        identifier, nested = _NESTED, type_name(element.name)
    elif isinstance(element, StringType):
        length = element.bound or 0
        identifier = _BOUNDED_STRING if length else _STRING
        identifier += element.wide
    elif isinstance(element, PrimitiveType) and element.kind in _IDS:
        identifier = _IDS[element.kind]
    else:
        raise ValueError(f"ROS 2 has no type {type_}")
    return {
        "type_id": identifier + added,
        "capacity": capacity,
        "string_capacity": length,
        "nested_type_name": nested,
    }
