"""Schemas of ROS 2 messages: the text of the .msg, and of all messages in it.

MCAP's registry calls such a schema `ros2msg`: the message first, then each other one after a line
of 80 `=` and a line `MSG: package/Name`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from rtgen.compiler.diagnostics import Span, in_order
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.kit.resources import ros_file, ros_interfaces
from rtgen.compiler.model import Declaration, Model, ScopedName
from rtgen.facts.ros import is_interface
from rtgen.ros2.rosidl import idl_form, load
from rtgen.ros2.rosidl.interfaces import Message, messages_of
from rtgen.ros2.rosidl.lowering import FILLER, declarations
from rtgen.ros2.rosidl.syntax import (
    FIELD_NAME,
    MESSAGE_NAME,
    PACKAGE_NAME,
    PRIMITIVES,
    parts_of,
)
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.tools.recording.errors import SchemaError

ENCODING: Final = "ros2msg"
IDL_ENCODING: Final = "ros2idl"
"""Names of schema encodings in MCAP's registry."""
NO_ENCODING: Final = ""
"""That of messages without schemas, as bags up to Humble have them."""
ENCODINGS: Final = (ENCODING, IDL_ENCODING, NO_ENCODING)

_MAX_DEPTH: Final = 64
_SEPARATOR: Final = "=" * 80
_HEAD: Final = re.compile(r"MSG: *(\S+) *")
_IDL_HEAD: Final = re.compile(r"IDL: *(\S+) *")
_NAMES: Final[dict[str, str]] = {
    kind: name for name, kind in reversed(PRIMITIVES.items()) if name != "char"
}
_NO_SPAN: Final = Span("", 1, 1, 1, 1)


class _NoMessageError(Exception):
    """A type that a message cannot contain."""


def message_text(descriptor: StructDescriptor, *, wide: bool = False) -> str | None:
    """Return the text of a message and of those in it; None if it is no ROS 2 message.

    Messages are structs with rosidl's naming (`std_msgs::msg::Header`) whose members interface
    files can declare; strings of 16-bit characters, which Foxglove's reader of messages lacks, only
    if `wide`.
    """
    texts: dict[str, str] = {}
    try:
        _add(descriptor, texts, wide=wide)
    except _NoMessageError:
        return None
    (_, first), *others = texts.items()
    rest = (f"{_SEPARATOR}\nMSG: {name}\n{text}" for name, text in others)
    return "".join((first, *rest))


def message_name(scoped_name: str) -> str:
    """Return `std_msgs::msg::Header` in ROS 2's notation, `std_msgs/msg/Header`."""
    return scoped_name.replace("::", "/")


def _add(descriptor: Descriptor, texts: dict[str, str], *, wide: bool) -> str:
    """Append a message to those found before; return its name as a type."""
    if (
        not isinstance(descriptor, StructDescriptor)
        or descriptor.extensibility != "final"
        or descriptor.representation == 2
        or descriptor.opaque
    ):
        raise _NoMessageError
    words = descriptor.name.split("::")
    if len(words) != 3 or scoped("/".join(words)) is None:
        raise _NoMessageError
    name = "/".join(words)
    if words[1] == "msg":
        name = f"{words[0]}/{words[2]}"
    if name not in texts:
        texts[name] = ""
        lines = []
        for member in descriptor.members:
            is_field = FIELD_NAME.fullmatch(member.name)
            if not is_field or member.optional or member.external:
                raise _NoMessageError
            if member.name != FILLER:
                lines.append(f"{_type(member.type, texts, wide=wide)} {member.name}\n")
        texts[name] = "".join(lines)
    return name


def _type(descriptor: Descriptor, texts: dict[str, str], *, wide: bool) -> str:
    match plain(descriptor):
        case SequenceDescriptor(element, bound):
            most = "" if bound is None else f"<={bound}"
            return f"{_element(element, texts, wide=wide)}[{most}]"
        case ArrayDescriptor(element, (size,)):
            return f"{_element(element, texts, wide=wide)}[{size}]"
        case other:
            return _element(other, texts, wide=wide)


def _element(descriptor: Descriptor, texts: dict[str, str], *, wide: bool) -> str:
    match plain(descriptor):
        case PrimitiveDescriptor(name) if name in _NAMES:
            return _NAMES[name]
        case StringDescriptor(is_wide, bound) if wide or not is_wide:
            name = "wstring" if is_wide else "string"
            return name if bound is None else f"{name}<={bound}"
        case other:
            return _add(other, texts, wide=wide)


def model_of(name: str, text: str, encoding: str) -> Model | None:
    """Return the declarations of a schema; None for IDL in another form than rosidl_adapter's.

    `name` is that of the message, whose declaration ships with rtgen if the schema is missing.
    Raises SchemaError.
    """
    match encoding:
        case "ros2idl":
            return _idl_model(name, text)
        case "":
            return shipped_model(name)
    return message_model(name, text)


def idl_texts(text: str) -> Iterator[tuple[str, str]]:
    """Yield the name and the text of each interface in a schema of IDL."""
    for section in _sections(text):
        head, _, rest = section.partition("\n")
        if (match := _IDL_HEAD.fullmatch(head)) is not None:
            yield match[1], rest
        elif section.strip():
            yield "", section


def _idl_model(name: str, text: str) -> Model | None:
    messages: list[Message] = []
    for title, section in idl_texts(text):
        words = title.split("/")
        if scoped(title) is None or len(words) != 3:
            return None
        package, kind, last = words
        try:
            parts = idl_form.parts_of(section, name, (package, kind, last))
        except idl_form.OtherFormError:
            return None
        messages += messages_of(package, kind, last, parts, _NO_SPAN)
    return Model(declarations=tuple(_declarations(messages)))


def shipped_model(name: str) -> Model:
    """Return the declarations of a message that ships with rtgen. Raises SchemaError."""
    if scoped(name) is not None and f"{name}.msg" in ros_interfaces():
        file = ros_file(f"{name}.msg")
        return load([file], root=file.parents[2]).model
    raise SchemaError(
        f"{name}: the recording has no definition of the message, and rtgen does not ship it",
        hint="`ros2 bag convert` of a later ROS 2 adds definitions",
    )


def _sections(text: str) -> list[str]:
    return re.split(r"^={80}\n", text, flags=re.MULTILINE)


def message_model(name: str, text: str) -> Model:
    """Return the declarations of a schema. Raises SchemaError."""
    findings = Findings()
    messages: list[Message] = []
    for number, section in enumerate(_sections(text)):
        section_text, section_name = section, name
        if number:
            head, _, section_text = section.partition("\n")
            match = _HEAD.fullmatch(head)
            if match is None:
                raise SchemaError(f"{name}: expected `MSG: package/Name` in the schema")
            section_name = match[1]
        scoped_name = scoped(section_name)
        if scoped_name is None:
            raise SchemaError(f"{section_name} is not a message of ROS 2")
        parts = parts_of(section_text, name, findings)
        if len(parts) != 1:
            raise SchemaError(f"{section_name}: the schema is not of one message")
        messages.append(Message(scoped_name, parts[0], _NO_SPAN))
    if findings.errors:
        first = in_order(findings.diagnostics)[0]
        line = 0 if first.span is None else first.span.line
        raise SchemaError(f"{name}: line {line} of a message: {first.message}")
    return Model(declarations=tuple(_declarations(messages)))


def scoped(text: str, package: str = "") -> ScopedName | None:
    """Return the scoped name of `Name`, `package/Name` or `package/msg/Name`; else None."""
    words = text.split("/")
    if len(words) == 1:
        words.insert(0, package)
    if len(words) == 2:
        words.insert(1, "msg")
    if not is_interface(words) or not PACKAGE_NAME.fullmatch(words[0]):
        return None
    # Requests, goals and so on are named after their interface.
    name = words[2] if words[1] == "msg" else words[2].partition("_")[0]
    return tuple(words) if MESSAGE_NAME.fullmatch(name) else None


def _declarations(messages: list[Message]) -> Iterator[Declaration]:
    by_name: dict[ScopedName, Message] = {message.name: message for message in messages}
    levels: dict[ScopedName, int] = {}

    def level(name: ScopedName, inside: int) -> int:
        """Return the nesting depth of a message."""
        if inside > _MAX_DEPTH:
            raise SchemaError(
                f"{'/'.join(name)} contains itself, or over {_MAX_DEPTH} levels of messages"
            )
        if name not in levels:
            if name not in by_name:
                raise SchemaError(f"the schema declares no {'/'.join(name)[:80]}")
            fields = by_name[name].part.fields
            inner = [
                scoped(f.type.base, name[0]) or (f.type.base,)
                for f in fields
                if f.type.is_message
            ]
            levels[name] = 1 + max(
                (level(each, inside + 1) for each in inner), default=0
            )
        return levels[name]

    for message in by_name.values():
        if level(message.name, 1) > _MAX_DEPTH:
            raise SchemaError(f"over {_MAX_DEPTH} levels of messages")
        yield from declarations(message, "")
