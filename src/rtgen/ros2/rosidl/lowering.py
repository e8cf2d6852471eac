"""Lowers messages to declarations, with the names of ROS 2's mapping to IDL."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Final

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import (
    VOID,
    Annotation,
    ArrayType,
    Const,
    Declaration,
    Direction,
    Interface,
    Member,
    NamedType,
    Operation,
    Parameter,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    default_id,
)
from rtgen.facts.primitives import Primitive
from rtgen.facts.ros import ACTION_SERVICES, ACTION_TOPICS, EVENTS_SUFFIX
from rtgen.ros2.rosidl.interfaces import Message
from rtgen.ros2.rosidl.syntax import PRIMITIVES, Field, FieldType
from rtgen.ros2.rosidl.types import scoped

_UNIT: Final = re.compile(r"\[([^,\]]+)\]")
"""The unit in a field's comment; as in rosidl_adapter, it must be the only one."""
FILLER: Final = "structure_needs_at_least_one_member"
"""The member, one octet, of a message without fields."""


def declarations(message: Message, file: str) -> Iterator[Declaration]:
    """Yield the constants and the struct of a message, whose types are known."""
    constants = (*message.name[:-1], f"{message.name[-1]}_Constants")
    for constant in message.part.constants:
        name = (*constants, constant.name)
        assert constant.value is not None
        assert not isinstance(constant.value, tuple)
        yield Const(
            name=name,
            repository_id=default_id(name),
            file=file,
            span=constant.span,
            doc=constant.doc,
            type=_type(constant.type, message.name[0]),
            value=constant.value,
        )
    members = tuple(_member(field, message.name[0]) for field in message.part.fields)
    yield Struct(
        name=message.name,
        repository_id=default_id(message.name),
        file=file,
        span=message.span,
        doc=message.part.doc,
        members=members or (_filler(message),),
    )


def action_interfaces(action: ScopedName, file: str, span: Span) -> Iterator[Interface]:
    """Yield the interfaces of an action: of its services and of its topics, `Go` and
    `Go_Events`.
    """
    whole = "/".join(action)

    def scoped_type(form: str, suffix: str = "") -> NamedType:
        return NamedType(tuple(f"{form.format(whole)}{suffix}".split("/")))

    def interface(name: ScopedName, operations: Iterable[Operation]) -> Interface:
        return Interface(
            name=name,
            repository_id=default_id(name),
            file=file,
            span=span,
            operations=tuple(operations),
        )

    def operation(name: str, given: Type, returns: Type, *, within: str) -> Operation:
        return Operation(
            span=span,
            name=name,
            returns=returns,
            parameters=(
                Parameter(
                    span=span,
                    direction=Direction.IN,
                    name="request" if returns != VOID else "message",
                    type=given,
                ),
            ),
            oneway=returns == VOID,
            repository_id=default_id((*action[:-1], within, name)),
        )

    stem = action[-1]
    services = (
        operation(
            name,
            scoped_type(form, "_Request"),
            scoped_type(form, "_Response"),
            within=stem,
        )
        for name, form in ACTION_SERVICES.items()
    )
    yield interface(action, services)
    events = f"{stem}{EVENTS_SUFFIX}"
    topics = (
        operation(name, scoped_type(form), VOID, within=events)
        for name, form in ACTION_TOPICS.items()
    )
    yield interface((*action[:-1], events), topics)


def _member(field: Field, package: str) -> Member:
    default = field.value
    annotations: list[Annotation] = []
    if default is not None:
        # As rosidl_adapter writes it: IDL has no literal for a list.
        value = repr(default) if isinstance(default, tuple) else default
        annotations.append(Annotation("default", (("value", value),)))
    units = _UNIT.findall(field.doc)
    if len(units) == 1:
        annotations.append(Annotation("unit", (("value", units[0]),)))
    return Member(
        span=field.span,
        doc=field.doc,
        annotations=tuple(annotations),
        name=field.name,
        type=_type(field.type, package),
        initial=default,
    )


def _filler(message: Message) -> Member:
    type_ = PrimitiveType(Primitive.UINT8)
    return Member(span=message.span, name=FILLER, type=type_)


def _type(type_: FieldType, package: str) -> Type:
    element: Type
    if type_.is_message:
        name = scoped(type_.base, package)
        assert name is not None, "the pipeline has looked for it"
        element = NamedType(name)
    elif type_.base in PRIMITIVES:
        element = PrimitiveType(PRIMITIVES[type_.base])
    else:
        element = StringType(type_.base == "wstring", type_.length)
    if type_.is_sequence:
        return SequenceType(element, type_.size)
    if type_.is_array:
        assert type_.size is not None
        return ArrayType(element, (type_.size,))
    return element
