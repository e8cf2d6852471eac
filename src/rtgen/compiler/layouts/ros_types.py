"""Descriptions and hashes of ROS 2 types: REP 2016, "Type Description Interfaces and RIHS01"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

from rtgen.compiler.model import (
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
from rtgen.facts import ros_hash

EVENT_INFO: Final = ("service_msgs", "msg", "ServiceEventInfo")
"""The message in a service's events."""


def type_name(name: ScopedName) -> str:
    """Return the name in ROS 2's notation: `std_msgs/msg/Header`."""
    return "/".join(name)


def type_hash(model: Model, struct: Struct) -> str:
    """Return the hash of a message (`RIHS01_...`). Raises ValueError for types unknown to ROS 2."""
    referenced: dict[str, Struct] = {}
    _collect(model, struct, referenced)
    described = {name: _individual(each) for name, each in referenced.items()}
    return ros_hash.rihs01(_individual(struct), described)


def service_hash(model: Model, request: Struct, response: Struct) -> str:
    """Return the hash of a service by its two messages, and its events' (REP 2016).

    Raises ValueError for types unknown to ROS 2, and if service_msgs/msg/ServiceEventInfo is not in
    the model.
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
    return ros_hash.rihs01(whole, described)


def _collect(model: Model, struct: Struct, structs: dict[str, Struct]) -> None:
    for nested in _nested(model, struct):
        name = type_name(nested.name)
        if name not in structs:
            structs[name] = nested
            _collect(model, nested, structs)


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
    typed = ((key, _field_type(type_)) for key, type_ in fields)
    return ros_hash.description(type_name(name), typed)


def _field_type(type_: Type) -> dict[str, Any]:
    if isinstance(type_, ArrayType) and len(type_.dimensions) == 1:
        return ros_hash.field_type(_element(type_.element), array=type_.dimensions[0])
    if isinstance(type_, SequenceType):
        return ros_hash.field_type(_element(type_.element), sequence=type_.bound or 0)
    return ros_hash.field_type(_element(type_))


def _element(type_: Type) -> ros_hash.Element:
    element = None
    if isinstance(type_, NamedType):
        return ros_hash.nested(type_name(type_.name))
    if isinstance(type_, StringType):
        return ros_hash.string(type_.bound, wide=type_.wide)
    if isinstance(type_, PrimitiveType):
        element = ros_hash.primitive(type_.kind)
    if element is None:
        raise ValueError(f"ROS 2 has no type {type_}")
    return element
