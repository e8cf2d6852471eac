"""Descriptions and hashes of ROS 2 types: REP 2016, "Type Description Interfaces and RIHS01"."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
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
EVENT_INFO: Final = ("service_msgs", "msg", "ServiceEventInfo")
"""The message that the events of each service contain."""
_VERSION: Final = "RIHS01_"


def type_name(name: ScopedName) -> str:
    """The name as ROS 2 writes it: `std_msgs/msg/Header`."""
    return "/".join(name)


def type_hash(model: Model, struct: Struct) -> str:
    """The hash of a message (`RIHS01_...`). Raises ValueError for types that ROS 2 lacks."""
    referenced: dict[str, Struct] = {}
    _collect(model, struct, referenced)
    described = {name: _individual(each) for name, each in referenced.items()}
    return _hash(_individual(struct), described)


def service_hash(model: Model, request: Struct, response: Struct) -> str:
    """The hash of the service of two messages, with that of its events (REP 2016).

    Raises ValueError for types that ROS 2 lacks, and if service_msgs/msg/ServiceEventInfo is
    not in the model.
    """
    structs = {
        each.name: each for each in model.declarations if isinstance(each, Struct)
    }
    if EVENT_INFO not in structs:
        raise ValueError(f"{type_name(EVENT_INFO)} is not in the model")
    info = structs[EVENT_INFO]
    name = (*request.name[:-1], request.name[-1].removesuffix("_Request"))
    event = (*name[:-1], f"{name[-1]}_Event")
    parts = (request, response)
    described = {
        type_name(event): _description(
            event,
            [
                ("info", NamedType(EVENT_INFO)),
                *(
                    (part, SequenceType(NamedType(struct.name), 1))
                    for part, struct in zip(("request", "response"), parts, strict=True)
                ),
            ],
        )
    }
    referenced = {type_name(each.name): each for each in (info, *parts)}
    for each in (info, *parts):
        _collect(model, each, referenced)
    described |= {key: _individual(struct) for key, struct in referenced.items()}
    members = zip(
        ("request_message", "response_message", "event_message"),
        (request.name, response.name, event),
        strict=True,
    )
    whole = _description(name, [(key, NamedType(each)) for key, each in members])
    return _hash(whole, described)


def _hash(whole: dict[str, Any], referenced: Mapping[str, dict[str, Any]]) -> str:
    import json

    description = {
        "type_description": whole,
        "referenced_type_descriptions": [
            referenced[name] for name in sorted(referenced)
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


def _individual(struct: Struct) -> dict[str, Any]:
    return _description(struct.name, [(m.name, m.type) for m in struct.members])


def _description(
    name: ScopedName, fields: Sequence[tuple[str, Type]]
) -> dict[str, Any]:
    return {
        "type_name": type_name(name),
        "fields": [{"name": key, "type": _field_type(type_)} for key, type_ in fields],
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
