"""Values of IDL types from JSON, in the form of logs, and their JSON Schemas.

For types of numbers, texts, enums, sequences, arrays and structs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeAlias

from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)

Convert: TypeAlias = Callable[[Any], Any]
"""Function that converts a JSON value. Raises ValueError with the reason."""

_OCTETS: Final = ("octet", "uint8")


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
        case StringDescriptor():
            return {"type": "string"}, _of(str)
        case EnumDescriptor() as enum:
            return {"type": "string", "enum": [n for n, _ in enum.members]}, _enum(enum)
        case SequenceDescriptor(element, bound):
            limits = {} if bound is None else {"maxItems": bound}
            return _list(element, limits, plain(element))
        case ArrayDescriptor(element, (size,)):
            limits = {"minItems": size, "maxItems": size}
            return _list(element, limits, plain(element))
        case StructDescriptor() as struct:
            return _struct(struct)
        case other:
            raise NoJsonError(str(other))


def _of(kind: type) -> Convert:
    def convert(value: Any) -> Any:
        if type(value) is not kind:
            raise ValueError(f"{_short(value)} is not {_NAMES[kind]}")
        return value

    return convert


_NAMES: Final = {bool: "true or false", int: "an integer", str: "a string"}


def _number(value: Any) -> float:
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
        return bytes(items) if octets else items

    return {"type": "array", "items": items, **limits}, convert


def _struct(struct: StructDescriptor) -> tuple[dict[str, Any], Convert]:
    if any(member.optional for member in struct.members):
        raise NoJsonError(f"{struct} has optional members")
    forms = {member.name: json_form(member.type) for member in struct.members}
    attributes = {member.name: member.attribute for member in struct.members}

    def convert(value: Any) -> Any:
        if not isinstance(value, dict):
            raise ValueError(f"{_short(value)} is not an object")
        if unknown := [name for name in value if name not in forms]:
            raise ValueError(f"{_short(unknown[0])} is not one of {', '.join(forms)}")
        members = {}
        for name, (_, convert_member) in forms.items():
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
        "required": [*forms],
        "additionalProperties": False,
    }
    return schema, convert


def _short(value: Any) -> str:
    return repr(value)[:60]
