"""Shipped interface files compared with Debian's rosidl (`apt-get install python3-rosidl`).

It is rosidl 3, which has no hashes: the names and types of all fields are compared. ROSIDL names
another folder of Python packages.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from typing import Any

import pytest

from rtgen.compiler.kit.resources import ros_file, ros_interfaces
from rtgen.compiler.model import (
    ArrayType,
    Model,
    NamedType,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Type,
)
from rtgen.ros2.rosidl import load

pytestmark = pytest.mark.peer

DEBIAN = Path(os.environ.get("ROSIDL", "/usr/lib/python3/dist-packages"))
ROSIDL = {
    "byte": "octet",
    "char": "uint8",
    "bool": "boolean",
    "uint8": "uint8",
    "int8": "int8",
    "int16": "short",
    "uint16": "unsigned short",
    "int32": "long",
    "uint32": "unsigned long",
    "int64": "long long",
    "uint64": "unsigned long long",
    "float32": "float",
    "float64": "double",
}


@pytest.fixture(scope="module")
def parser() -> Any:
    if not (DEBIAN / "rosidl_adapter").is_dir():
        pytest.skip("Debian's python3-rosidl is not installed")
    sys.path.append(str(DEBIAN))
    try:
        return importlib.import_module("rosidl_adapter.parser")
    finally:
        sys.path.remove(str(DEBIAN))


def theirs(type_: Any) -> str:
    """Return a type of rosidl in the syntax of IDL."""
    if type_.is_primitive_type() and type_.type in ("string", "wstring"):
        bound = "" if type_.string_upper_bound is None else type_.string_upper_bound
        inner = f"{type_.type}<{bound}>" if bound else type_.type
    elif type_.is_primitive_type():
        inner = ROSIDL[type_.type]
    else:
        inner = f"{type_.pkg_name}::msg::{type_.type}"
    if not type_.is_array:
        return inner
    if type_.array_size is None:
        return f"sequence<{inner}>"
    if type_.is_upper_bound:
        return f"sequence<{inner}, {type_.array_size}>"
    return f"{inner}[{type_.array_size}]"


def own(model: Model, type_: Type) -> str:
    match type_:
        case ArrayType(element, (size,)):
            return f"{own(model, element)}[{size}]"
        case SequenceType(element, bound):
            most = "" if bound is None else f", {bound}"
            return f"sequence<{own(model, element)}{most}>"
        case StringType(wide, bound):
            name = "wstring" if wide else "string"
            return name if bound is None else f"{name}<{bound}>"
        case NamedType(name):
            return "::".join(name)
        case PrimitiveType(kind):
            return str(kind)
    raise AssertionError(type_)


def parts(parser: Any, name: str) -> dict[str, Any]:
    """Return the messages of a file by the suffixes of their names."""
    package, kind, _ = name.split("/")
    path = ros_file(name)
    if kind == "msg":
        return {"": parser.parse_message_file(package, str(path))}
    if kind == "srv":
        found = parser.parse_service_file(package, str(path))
        return {"_Request": found.request, "_Response": found.response}
    found = parser.parse_action_file(package, str(path))
    return {"_Goal": found.goal, "_Result": found.result, "_Feedback": found.feedback}


def test_fields_of_all_shipped_interfaces(parser: Any) -> None:
    paths = [ros_file(name) for name in ros_interfaces()]
    model = load(paths, root=paths[0].parents[2]).model
    compared = 0
    for name in ros_interfaces():
        package, kind, file = name.split("/")
        for suffix, message in parts(parser, name).items():
            scoped = package, kind, f"{Path(file).stem}{suffix}"
            struct = model.find(scoped)
            assert isinstance(struct, Struct)
            expected = [(f.name, theirs(f.type)) for f in message.fields]
            found = [(m.name, own(model, m.type)) for m in struct.members]
            if not expected:
                assert len(found) == 1, name
                continue
            assert found == expected, name
            compared += len(found)
    assert compared > len(ros_interfaces())
