"""Values of IDL types from JSON, in the form of logs, and their JSON Schemas.

For types of numbers, texts, enums, bitmasks, sequences, arrays, structs and unions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeAlias

from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    FlagsDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)

Convert: TypeAlias = Callable[[Any], Any]
"""Function that converts a JSON value. Raises ValueError with the reason."""

_OCTETS: Final = ("octet", "uint8")
_MAX_OCTET: Final = 255


class NoJsonError(TypeError):
    """A type without a JSON form."""


def json_form(descriptor: Descriptor) -> tuple[dict[str, Any], Convert]:
    """Return the JSON Schema of a type, and the converter of values. Raises NoJsonError."""
    if isinstance(descriptor, LinkDescriptor):
        raise NoJsonError("a recursive type")
    match plain(descriptor):
        case PrimitiveDescriptor("boolean"):
            return {"type": "boolean"}, _of(bool)
        case PrimitiveDescriptor(name) if name in INTEGER_RANGES:
            low, high = INTEGER_RANGES[name]
            return {"type": "integer", "minimum": low, "maximum": high}, _of(int)
        case PrimitiveDescriptor(name) if name in FLOAT_LIMITS:
            return {"type": "number"}, _number
        case PrimitiveDescriptor("char" | "wchar"):
            return {"type": "string", "minLength": 1, "maxLength": 1}, _character
        case StringDescriptor():
            return {"type": "string"}, _of(str)
        case FlagsDescriptor(class_=class_):
            convert = _of(int)
            return {"type": "integer", "minimum": 0}, lambda v: class_(convert(v))
        case EnumDescriptor() as enum:
            return {"type": "string", "enum": [n for n, _ in enum.members]}, _enum(enum)
        case SequenceDescriptor(element, bound):
            limits = {} if bound is None else {"maxItems": bound}
            return _list(element, limits, plain(element))
        case ArrayDescriptor(element, (size, *rest)):
            limits = {"minItems": size, "maxItems": size}
            inner = ArrayDescriptor(element, tuple(rest)) if rest else element
            return _list(inner, limits, plain(inner))
        case StructDescriptor() as struct:
            return _struct(struct)
        case UnionDescriptor() as union:
            return _union(union)
        case other:
            raise NoJsonError(str(other))


def _of(kind: type) -> Convert:
    def convert(value: Any) -> Any:
        if type(value) is not kind:
            raise ValueError(f"{_short(value)} is not {_NAMES[kind]}")
        return value

    return convert


_NOT_FINITE: Final = ("nan", "inf", "-inf")
_NAMES: Final = {bool: "true or false", int: "an integer", str: "a string"}


def _character(value: Any) -> str:
    if not isinstance(value, str) or len(value) != 1:
        raise ValueError(f"{_short(value)} is not a character")
    return value


def _number(value: Any) -> float:
    if value in _NOT_FINITE:
        return float(value)
    if type(value) not in (int, float):
        raise ValueError(f"{_short(value)} is not a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{_short(value)} is too large") from None


def _enum(enum: EnumDescriptor) -> Convert:
    numbers = dict(enum.members)

    def convert(value: Any) -> Any:
        if not isinstance(value, str) or value not in numbers:
            raise ValueError(f"{_short(value)} is not one of {', '.join(numbers)}")
        return enum.class_(numbers[value])

    return convert


def _list(
    element: Descriptor, limits: dict[str, int], inner: Descriptor
) -> tuple[dict[str, Any], Convert]:
    items, convert_item = json_form(element)
    octets = isinstance(inner, PrimitiveDescriptor) and inner.name in _OCTETS

    def convert(value: Any) -> Any:
        if not isinstance(value, list):
            raise ValueError(f"{_short(value)} is not a list")
        low, high = limits.get("minItems", 0), limits.get("maxItems", len(value))
        if not low <= len(value) <= high:
            raise ValueError(f"{len(value)} elements are not {low} to {high}")
        items = [convert_item(item) for item in value]
        for item in items if octets else ():
            if not 0 <= item <= _MAX_OCTET:
                raise ValueError(f"{item} is out of the range of octet")
        return bytes(items) if octets else items

    return {"type": "array", "items": items, **limits}, convert


def _struct(struct: StructDescriptor) -> tuple[dict[str, Any], Convert]:
    forms = {member.name: json_form(member.type) for member in struct.members}
    attributes = {member.name: member.attribute for member in struct.members}
    optional = {member.name for member in struct.members if member.optional}

    def convert(value: Any) -> Any:
        if not isinstance(value, dict):
            raise ValueError(f"{_short(value)} is not an object")
        if unknown := [name for name in value if name not in forms]:
            raise ValueError(f"{_short(unknown[0])} is not one of {', '.join(forms)}")
        members = {}
        for name, (_, convert_member) in forms.items():
            if name in optional and value.get(name) is None:
                continue
            if name not in value:
                raise ValueError(f"{name} is missing")
            try:
                members[attributes[name]] = convert_member(value[name])
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from None
        return struct.class_(**members)

    schema = {
        "type": "object",
        "properties": {name: schema for name, (schema, _) in forms.items()},
        "required": [name for name in forms if name not in optional],
        "additionalProperties": False,
    }
    return schema, convert


def _union(union: UnionDescriptor) -> tuple[dict[str, Any], Convert]:
    """Return the form of a union: its discriminator and value, or the name of a branch."""
    switch, convert_switch = json_form(union.switch)
    forms = {branch.name: json_form(branch.type) for branch in union.branches}

    def convert(value: Any) -> Any:
        match value:
            case {"discriminator": selected, **others} if set(others) <= {"value"}:
                discriminator = convert_switch(selected)
                branch = union.branch(discriminator)
                inner = value.get("value")
            case {**members} if len(members) == 1 and next(iter(members)) in forms:
                [(name, inner)] = members.items()
                branch = next(b for b in union.branches if b.name == name)
                if not branch.labels:
                    raise ValueError(f"{name} is the default: state the discriminator")
                discriminator = branch.labels[0]
            case _:
                names = ", ".join(forms)
                raise ValueError(
                    f"{_short(value)} is not an object with one of {names}"
                )
        if branch is None:
            return union.class_(discriminator, None)
        return union.class_(discriminator, forms[branch.name][1](inner))

    schema = {
        "type": "object",
        "properties": {"discriminator": switch, "value": {}},
        "required": ["discriminator"],
    }
    return schema, convert


def _short(value: Any) -> str:
    return repr(value)[:60]
