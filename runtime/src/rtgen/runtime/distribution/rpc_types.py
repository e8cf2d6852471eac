"""Types of requests and replies of an interface, by DDS-RPC 1.0's basic mapping (7.5.1.1).

`<Interface>_Request` is a header and the union `<Interface>_Call` of `<Interface>_<operation>_In`;
`<Interface>_Reply` a header and the union `<Interface>_Return` of `<Interface>_<operation>_Result`,
a union itself: `<Interface>_<operation>_Out`, or an exception. Discriminators are hashes of names.
An operation with types that DDS does not support has a body of CDR instead, as octets.
"""

from __future__ import annotations

import hashlib
from functools import cache
from typing import Any

import msgspec
from msgspec.structs import replace

from rtgen.runtime import idl
from rtgen.runtime.cdr import Union, UserException
from rtgen.runtime.distribution.medium import ServiceTypes
from rtgen.runtime.distribution.rpc_header import ReplyHeader, RequestHeader
from rtgen.runtime.marshalling.descriptors import (
    NEXT,
    ArrayDescriptor,
    EnumDescriptor,
    FlagsDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.services.call_types import Call, aggregate
from rtgen.runtime.services.calls import calls_of

OK = 0
"""Discriminator of a result (dds::RETCODE_OK)."""
_UNUSED = "dummy"


class OperationTypes(msgspec.Struct, frozen=True):
    """The types of an operation; `octets`: arguments and results are bodies of CDR."""

    name: str
    label: int
    call: Call
    octets: bool
    request: Any
    reply: Any
    result: Any
    exceptions: dict[int, tuple[Any, type[UserException]]] = msgspec.field(
        default_factory=dict
    )


class InterfaceTypes(ServiceTypes, frozen=True):
    """The types of an interface, with its unions and operations by name and by label."""

    call: Any
    answer: Any
    operations: dict[str, OperationTypes]
    labels: dict[int, OperationTypes]


def name_hash(name: str) -> int:
    """Return the hash of an operation's or exception's name: the first octets of its MD5."""
    digest = hashlib.md5(name.encode(), usedforsecurity=False).digest()
    return int.from_bytes(digest[:4], "little", signed=True)


def operation_name(wire_name: str) -> str:
    """Return the operation in DDS-RPC; that of an attribute is `get_NAME` or `set_NAME`."""
    return wire_name.removeprefix("_")


@cache
def interface_types(interface: Any) -> InterfaceTypes:
    """Return the types for an interface. Raises ServiceError as `calls_of`."""
    name = interface._descriptor_.name
    calls = calls_of(interface)
    operations = {
        wire: _operation(name, wire, call)
        for wire, call in calls.items()
        if not (call.refused or any(call.request_objects) or any(call.reply_objects))
    }
    call = _union(
        f"{name}_Call",
        {each.name: (each.request, each.label) for each in operations.values()},
        "unknownOp",
    )
    answer = _union(
        f"{name}_Return",
        {each.name: (each.result, each.label) for each in operations.values()},
        "unknownOp",
    )
    return InterfaceTypes(
        _struct(f"{name}_Request", {"header": RequestHeader, "data": call}),
        _struct(f"{name}_Reply", {"header": ReplyHeader, "data": answer}),
        call,
        answer,
        operations,
        {each.label: each for each in operations.values()},
    )


def lineage_types(interface: Any) -> tuple[InterfaceTypes, ...]:
    """Return the types of an interface and of its bases with operations, which clients may use."""
    bases = [c for c in interface.__mro__[1:] if "_descriptor_" in vars(c)]
    return tuple(interface_types(c) for c in (interface, *bases) if calls_of(c))


def _operation(interface: str, wire: str, call: Call) -> OperationTypes:
    name = operation_name(wire)
    prefix = f"{interface}_{name}"
    raised: list[tuple[Any, Any]] = [
        (exception, exception._descriptor_)
        for _, exception in call.raises  # in the order of the definition
    ]
    octets = not (
        _is_known(call.request)
        and _is_known(call.reply)
        and all(_is_known_all(d.members) for _, d in raised)
    )
    body = {"octets": idl.sequence(idl.OCTET)}
    request = _struct(f"{prefix}_In", body if octets else _members(call.request))
    reply = _struct(f"{prefix}_Out", body if octets else _members(call.reply))
    exceptions = {
        name_hash(descriptor.name): (
            (
                _struct(f"{prefix}_{_last(descriptor.name)}", body)
                if octets
                else _exception(exception)
            ),
            exception,
        )
        for exception, descriptor in raised
    }
    cases = {"result": (reply, OK)} | {
        f"{_last(exception._descriptor_.name).lower()}_ex": (type_, label)
        for label, (type_, exception) in exceptions.items()
    }
    result = _union(f"{prefix}_Result", cases, "unknownEx")
    return OperationTypes(
        name, name_hash(name), call, octets, request, reply, result, exceptions
    )


@cache
def _exception(exception: Any) -> Any:
    """Return the struct of an exception."""
    descriptor = exception._descriptor_
    return _struct(descriptor.name, _all(descriptor.members))


def _last(name: str) -> str:
    return name.rpartition("::")[2]


def _members(type_: Any) -> dict[str, Any]:
    return {} if type_ is None else _all(type_._descriptor_.members)


def _all(members: Any) -> dict[str, Any]:
    return {
        m.attribute: replace(
            m, id=NEXT, name="return_" if m.attribute == "_result" else m.name
        )
        for m in members
    }


def _struct(name: str, members: dict[str, Any]) -> Any:
    """Return a struct; an empty one has a member, since DDS has no empty structs."""
    members = members or {_UNUSED: idl.OCTET}
    fields = [
        (key, Any, 0 if key == _UNUSED else None)  # values always have arguments
        for key in members
    ]
    return aggregate(name, fields, idl.struct(name, **members))


def _union(name: str, cases: dict[str, tuple[Any, int]], unknown: str) -> Any:
    branches = {key: idl.case(type_, label) for key, (type_, label) in cases.items()}
    branches[unknown] = idl.case(idl.OCTET, default=True)
    descriptor = idl.union(name, idl.LONG, **branches)
    fields = [("discriminator", int, 0), ("value", Any, None)]
    return aggregate(name, fields, descriptor, Union)


def _is_known(type_: Any) -> bool:
    return type_ is None or _is_known_all(type_._descriptor_.members)


def _is_known_all(members: Any) -> bool:
    return all(_has_dds(member.type, ()) for member in members)


_LACKING = ("long double",)


def _has_dds(descriptor: Any, inside: tuple[str, ...]) -> bool:
    """Return whether every DDS supports the type: no wide strings, maps, objects, recursion."""
    descriptor = plain(descriptor)
    match descriptor:
        case PrimitiveDescriptor(name):
            return name not in _LACKING
        case StringDescriptor(wide=wide):
            return not wide
        case EnumDescriptor() | FlagsDescriptor():
            return True
        case SequenceDescriptor(element=element) | ArrayDescriptor(element=element):
            return _has_dds(element, inside)
        case StructDescriptor(members=parts, name=name):
            return name not in inside and all(
                _has_dds(part.type, (*inside, name)) for part in parts
            )
        case UnionDescriptor(branches=parts, name=name, extensibility=extensibility):
            return (
                extensibility != "mutable"
                and name not in inside
                and not any(part.default and part.labels for part in parts)
                and all(_has_dds(part.type, (*inside, name)) for part in parts)
            )
    return False
