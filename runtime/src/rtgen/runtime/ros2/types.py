"""ROS 2 types as generated classes: names, and hashes of their descriptors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from rtgen.facts import ros_hash
from rtgen.facts.primitives import FLOAT_LIMITS
from rtgen.facts.ros import is_interface
from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.marshalling.layouts.trees import ros2_format
from rtgen.runtime.xcdr import deserialize


def ros_name(type_: type[Any]) -> str | None:
    """Return a generated class's ROS name (`std_msgs/msg/Float32`); None if it is not a message."""
    name = str(type_._descriptor_.name).split("::")
    return "/".join(name) if is_interface(name) else None


Described: TypeAlias = tuple[dict[str, Any], dict[str, dict[str, Any]]]
"""The description of a type, and those of all types that it refers to, by name."""


def type_description(type_: type[Any]) -> Described:
    """Return the description of a message. Raises ValueError for types unknown to ROS 2."""
    described: dict[str, dict[str, Any]] = {}
    return _described(type_._descriptor_, described), described


def type_hash(type_: type[Any]) -> str:
    """Return a message's hash (`RIHS01_...`). Raises ValueError for types unknown to ROS 2."""
    return ros_hash.rihs01(*type_description(type_))


def _described(struct: Any, found: dict[str, dict[str, Any]]) -> dict[str, Any]:
    fields = [(m.name, _field(m.type, found)) for m in struct.members]
    return ros_hash.description(_slashed(struct), fields)


def _slashed(struct: Any) -> str:
    return str(struct.name).replace("::", "/")


def _field(descriptor: Any, found: dict[str, dict[str, Any]]) -> dict[str, Any]:
    descriptor = plain(descriptor)
    match descriptor:
        case ArrayDescriptor(element=element, dimensions=(length,)):
            return ros_hash.field_type(_element(element, found), array=length)
        case SequenceDescriptor(element=element, bound=bound):
            return ros_hash.field_type(_element(element, found), sequence=bound or 0)
    return ros_hash.field_type(_element(descriptor, found))


def _element(descriptor: Any, found: dict[str, dict[str, Any]]) -> ros_hash.Element:
    descriptor = plain(descriptor)
    made = None
    match descriptor:
        case StructDescriptor():
            name = _slashed(descriptor)
            if name not in found:
                found[name] = {}
                found[name] = _described(descriptor, found)
            return ros_hash.nested(name)
        case StringDescriptor(wide=wide, bound=bound):
            return ros_hash.string(bound, wide=wide)
        case PrimitiveDescriptor(name=name):
            made = ros_hash.primitive(name)
    if made is None:
        raise ValueError(f"ROS 2 has no type {descriptor}")
    return made


def blank(descriptor: Any) -> Any:
    """Return a value of a ROS 2 type with zeros, empty texts and sequences."""
    match plain(descriptor):
        case StructDescriptor() as struct:
            values = {m.attribute: blank(m.type) for m in struct.members}
            return struct.class_(**values)
        case ArrayDescriptor(element=element, dimensions=(length,)):
            if _is_octet(element):
                return bytes(length)
            return [blank(element) for _ in range(length)]
        case SequenceDescriptor(element=element):
            return b"" if _is_octet(element) else []
        case StringDescriptor():
            return ""
        case PrimitiveDescriptor(name="boolean"):
            return False
        case PrimitiveDescriptor(name=name) if name in FLOAT_LIMITS:
            return 0.0
    return 0


def made(descriptor: Any, value: Any) -> Any:
    """Return a value of a ROS 2 type: structs from mappings, other members zero."""
    match plain(descriptor):
        case StructDescriptor() as struct:
            members = {
                m.attribute: (
                    made(m.type, value[m.name]) if m.name in value else blank(m.type)
                )
                for m in struct.members
            }
            return struct.class_(**members)
        case SequenceDescriptor(element=element) if not _is_octet(element):
            return [made(element, each) for each in value]
    return value


def _is_octet(element: Any) -> bool:
    match plain(element):
        case PrimitiveDescriptor(name="octet" | "uint8"):
            return True
    return False


def request_of(type_: type[Any] | None) -> str | None:
    """Return the service (`std_srvs::srv::SetBool`) of a request's class; None for others."""
    name = "" if type_ is None else str(type_._descriptor_.name)
    is_one = is_interface(name.split("::")) and name.endswith("_Request")
    return name.removesuffix("_Request") if is_one else None


def service_hash(request: type[Any], response: type[Any], info: type[Any]) -> str:
    """Return the hash of a service; see `service_description`."""
    return ros_hash.rihs01(*service_description(request, response, info))


def service_description(
    request: type[Any], response: type[Any], info: type[Any]
) -> Described:
    """Return the description of a service, with that of its events (REP 2016).

    `info` is service_msgs/msg/ServiceEventInfo. Raises ValueError for types unknown to ROS 2.
    """
    described: dict[str, dict[str, Any]] = {}
    names = []
    for type_ in (request, response, info):
        names.append(_slashed(type_._descriptor_))
        described[names[-1]] = _described(type_._descriptor_, described)
    name = names[0].removesuffix("_Request")
    nested = [ros_hash.nested(each) for each in names]
    event = f"{name}_Event"
    described[event] = ros_hash.description(
        event,
        (
            ("info", ros_hash.field_type(nested[2])),
            ("request", ros_hash.field_type(nested[0], sequence=1)),
            ("response", ros_hash.field_type(nested[1], sequence=1)),
        ),
    )
    whole = ros_hash.description(
        name,
        (
            ("request_message", ros_hash.field_type(nested[0])),
            ("response_message", ros_hash.field_type(nested[1])),
            ("event_message", ros_hash.field_type(ros_hash.nested(event))),
        ),
    )
    return whole, described


_HEAD = b"\x00\x01\x00\x00"
"""Encapsulation header of classic CDR, little endian, as ROS 2 writes it."""
_LARGE = 65_536
"""From this number of octets, a view of them is faster than a copy."""
_BYTE_ORDERS = {b"\x00\x00": False, b"\x00\x01": True}


def encoded(value: Any) -> bytes:
    """Return a message as ROS 2 sends it, with its encapsulation header. Raises CdrError."""
    body: bytes = _codec("to_cdr", type(value)._descriptor_)(value, True)
    return _HEAD + body


def decoded(type_: type[Any], octets: bytes) -> Any:
    """Return the value of a serialized message; what follows is ignored. Raises CdrError.

    Nodes of ROS 2 ignore it, too: rclpy's `serialize_message` returns more octets than a message
    has, and networks pad messages.
    """
    little_endian = _BYTE_ORDERS.get(octets[:2])
    if little_endian is None or len(octets) < len(_HEAD):
        return deserialize(type_, octets)  # another representation, or an error
    decode = _codec("from_prefix", type_._descriptor_)
    whole = octets if len(octets) < _LARGE else memoryview(octets)
    return decode(type_, whole[len(_HEAD) :], little_endian)


def _codec(kind: str, descriptor: Any) -> Callable[..., Any]:
    """Return a compiled function of a message, which is kept with its others."""
    known: Callable[..., Any] | None = descriptor.codecs.get(("ros2", kind))
    if known is None:
        known = compiled(kind, descriptor, ros2_format(descriptor))
        descriptor.codecs["ros2", kind] = known
    return known
