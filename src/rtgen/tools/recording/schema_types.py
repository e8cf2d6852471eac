"""Creates types from the text of a schema, to read messages without generated code."""

from __future__ import annotations

import re
from collections.abc import Callable
from keyword import iskeyword
from pathlib import Path
from typing import Any, TypeAlias

from rtgen.compiler.diagnostics import has_errors, in_order
from rtgen.compiler.frontends.kit.library import VirtualFile
from rtgen.compiler.frontends.stage import Settings, read_idl
from rtgen.compiler.model import Model, Struct
from rtgen.compiler.typemap.data_classes import NoTypeError, Types
from rtgen.runtime.marshalling.descriptors import (
    DataType,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.ros2.types import decoded
from rtgen.runtime.xcdr import deserialize
from rtgen.tools.recording import ros_messages
from rtgen.tools.recording.errors import SchemaError
from rtgen.tools.recording.schemas import Schema, with_escapes

Decode: TypeAlias = Callable[[Any, bytes], Any]
"""Function that returns the value of a type of serialized data. Raises CdrError."""

_FILE = "schema.idl"
_IDENTIFIER = re.compile(r"[A-Za-z]\w*", re.ASCII)
_INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[^\n]*", re.MULTILINE)
_MAX_LENGTH = 1 << 20
"""Maximum length of a schema in characters."""


def decoder(schema: Schema) -> Decode:
    """Return the function that decodes the data of a schema's type, as ROS 2 does its messages."""
    return decoded if schema.encoding in ros_messages.ENCODINGS else deserialize


def type_of(schema: Schema) -> type[DataType]:
    """Return the type that a schema names, with new classes. Raises SchemaError.

    No repository id is registered, so types of generated code are not affected.
    """
    return _type_of(schema, own_names=False)


def named_type_of(schema: Schema) -> type[DataType]:
    """Return the type that a schema names; attributes have the names of members.

    Raises SchemaError, also for names that are not plain identifiers.
    """
    return _type_of(schema, own_names=True)


def _type_of(schema: Schema, *, own_names: bool) -> type[DataType]:
    if len(schema.text) > _MAX_LENGTH:
        raise SchemaError(
            f"{schema.name}: the schema has over {_MAX_LENGTH} characters"
        )
    if schema.encoding in ros_messages.ENCODINGS:
        name = ros_messages.scoped(schema.name) or (schema.name,)
        known = ros_messages.model_of(schema.name, schema.text, schema.encoding)
        model = _idl_model(schema) if known is None else known
    else:
        model = _idl_model(schema)
        name = tuple(schema.name.split("::"))
    if own_names:
        _require_identifiers(schema, model)
    try:
        descriptor = Types(model, own_names=own_names).named(name, schema.name)
    except NoTypeError as error:
        raise SchemaError(f"{schema.name}: {error}") from None
    class_: type[DataType] | None = getattr(descriptor, "class_", None)
    if class_ is None or not isinstance(descriptor, StructDescriptor | UnionDescriptor):
        raise SchemaError(
            f"{schema.name} is neither a struct nor a union of the schema"
        )
    return class_


def _require_identifiers(schema: Schema, model: Model) -> None:
    """Raise SchemaError for names of members that would be others in Python, or code."""
    for declaration in model.declarations:
        for member in getattr(declaration, "members", ()):
            name = str(member.name)
            if not _IDENTIFIER.fullmatch(name) or iskeyword(name):
                raise SchemaError(f"{schema.name}: {name!r} cannot be an attribute")


def message_classes(model: Model) -> dict[str, type[DataType]]:
    """Return classes of the messages that ship with rtgen, by name (`std_msgs/msg/Float32`)."""
    types = Types(model, own_names=True)
    classes = {}
    for declaration in model.declarations:
        if isinstance(declaration, Struct):
            descriptor = types.named(declaration.name)
            assert isinstance(descriptor, StructDescriptor)
            classes["/".join(declaration.name)] = descriptor.class_
    return classes


def _idl_model(schema: Schema) -> Model:
    if schema.encoding == ros_messages.IDL_ENCODING:
        sections = ros_messages.idl_texts(schema.text)
        whole = _INCLUDE.sub("", "\n".join(reversed([text for _, text in sections])))
    else:
        whole = with_escapes(schema.text)
    text = VirtualFile(_FILE, whole, given=True)
    settings = Settings(root=Path(), ignore_case_clashes=True)
    result = read_idl((), settings, text=text)
    if has_errors(result.diagnostics):
        first = in_order(result.diagnostics)[0]
        line = 0 if first.span is None else first.span.line
        raise SchemaError(f"{schema.name}: line {line} of the schema: {first.message}")
    return result.model
