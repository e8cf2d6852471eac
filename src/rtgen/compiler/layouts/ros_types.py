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
    described = {name: _individual(model, each) for name, each in referenced.items()}
    return ros_hash.rihs01(_individual(model, struct), described)


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
            model,
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
    described |= {key: _individual(model, struct) for key, struct in referenced.items()}
    members = zip(
        ("request_message", "response_message", "event_message"),
        (request.name, response.name, event),
        strict=True,
    )
    whole = _description(model, name, [(key, NamedType(each)) for key, each in members])
    return ros_hash.rihs01(whole, described)


def _collect(model: Model, struct: Struct, structs: dict[str, Struct]) -> None:
    for nested in _nested(model, struct):
        name = type_name(nested.name)
        if name not in structs:
            structs[name] = nested
            _collect(model, nested, structs)


def _nested(model: Model, struct: Struct) -> Iterator[Struct]:
    for member in model.members(struct):
        type_ = _plain(model, member.type)
        if isinstance(type_, SequenceType | ArrayType):
            type_ = _plain(model, type_.element)
        if isinstance(type_, NamedType):
            declaration = model.find(type_.name)
            if isinstance(declaration, Struct):
                yield declaration


def _plain(model: Model, type_: Type) -> Type:
    """Return the type with typedefs resolved; names may be those of derived messages."""
    while (typedef := model.typedef(type_)) is not None:
        type_ = typedef.type
    return type_


def _individual(model: Model, struct: Struct) -> dict[str, Any]:
    fields = [(m.name, m.type) for m in model.members(struct)]
    return _description(model, struct.name, fields)


def _description(
    model: Model, name: ScopedName, fields: Sequence[tuple[str, Type]]
) -> dict[str, Any]:
    typed = ((key, _field_type(model, type_)) for key, type_ in fields)
    return ros_hash.description(type_name(name), typed)


def _field_type(model: Model, type_: Type) -> dict[str, Any]:
    type_ = _plain(model, type_)
    if isinstance(type_, ArrayType) and len(type_.dimensions) == 1:
        element = _element(model, type_.element)
        return ros_hash.field_type(element, array=type_.dimensions[0])
    if isinstance(type_, SequenceType):
        element = _element(model, type_.element)
        return ros_hash.field_type(element, sequence=type_.bound or 0)
    return ros_hash.field_type(_element(model, type_))


def _element(model: Model, type_: Type) -> ros_hash.Element:
    element = None
    type_ = _plain(model, type_)
    if isinstance(type_, NamedType):
        return ros_hash.nested(type_name(type_.name))
    if isinstance(type_, StringType):
        return ros_hash.string(type_.bound, wide=type_.wide)
    if isinstance(type_, PrimitiveType):
        element = ros_hash.primitive(type_.kind)
    if element is None:
        raise ValueError(f"ROS 2 has no type {type_}")
    return element
