"""Names and types of IDL in ROS 2 interface files."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Final

from rtgen.compiler.model import (
    ArrayType,
    Enum,
    Model,
    NamedType,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
)
from rtgen.compiler.typemap.python.names import snake_case
from rtgen.facts.primitives import Primitive
from rtgen.facts.ros import is_interface

_PRIMITIVES: Final[Mapping[str, str]] = {
    Primitive.BOOLEAN: "bool",
    Primitive.OCTET: "byte",
    Primitive.CHAR: "char",
    Primitive.INT8: "int8",
    Primitive.UINT8: "uint8",
    Primitive.SHORT: "int16",
    Primitive.UNSIGNED_SHORT: "uint16",
    Primitive.LONG: "int32",
    Primitive.UNSIGNED_LONG: "uint32",
    Primitive.LONG_LONG: "int64",
    Primitive.UNSIGNED_LONG_LONG: "uint64",
    Primitive.FLOAT: "float32",
    Primitive.DOUBLE: "float64",
}
_GLOBAL: Final = "interfaces"
"""The package of declarations in the global scope."""


class InexpressibleError(Exception):
    """ROS 2 cannot express a part of a declaration; the message names it."""


def package_name(scope: ScopedName) -> str:
    """Return the package of a module: `Lab::Arm` is `lab_arm`."""
    return _words("_".join(map(snake_case, scope))) or _GLOBAL


def message_name(name: str) -> str:
    """Return the message of a struct: `path_point` is `PathPoint`."""
    words = (word for word in re.split(r"_+", name) if word)
    return "".join(word[0].upper() + word[1:] for word in words)


def field_name(name: str) -> str:
    """Return the field of a member: `minAngle` is `min_angle`."""
    return _words(snake_case(name))


def _words(text: str) -> str:
    return re.sub(r"_+", "_", text.lower()).strip("_")


def reference(name: ScopedName) -> str:
    """Return the name of a message in a field."""
    if is_interface(name):
        return f"{name[0]}/{name[2]}"
    return f"{package_name(name[:-1])}/{message_name(name[-1])}"


def field_type(model: Model, type_: Type, written: Callable[[ScopedName], bool]) -> str:
    """Return the type of a field; `written` returns whether a struct has a message."""
    type_ = model.unalias(type_)
    if isinstance(type_, SequenceType):
        bound = "" if type_.bound is None else f"<={type_.bound}"
        return f"{_element(model, type_.element, written)}[{bound}]"
    if isinstance(type_, ArrayType):
        if len(type_.dimensions) > 1:
            raise InexpressibleError("arrays of several dimensions")
        return f"{_element(model, type_.element, written)}[{type_.dimensions[0]}]"
    return _element(model, type_, written)


def _element(model: Model, type_: Type, written: Callable[[ScopedName], bool]) -> str:
    type_ = model.unalias(type_)
    match type_:
        case SequenceType() | ArrayType():
            raise InexpressibleError("sequences and arrays in each other")
        case StringType(wide=wide, bound=bound):
            name = "wstring" if wide else "string"
            return name if bound is None else f"{name}<={bound}"
        case PrimitiveType(kind=kind) if kind in _PRIMITIVES:
            return _PRIMITIVES[kind]
        case NamedType(name=name):
            declaration = model.find(name)
            if isinstance(declaration, Enum) and declaration.bound == 32:
                return "uint32"
            if isinstance(declaration, Struct) and written(name):
                return reference(name)
            raise InexpressibleError(f"the type {type_}")
    raise InexpressibleError(f"the type {type_}")
