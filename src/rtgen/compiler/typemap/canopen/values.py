"""CANopen data types and values in the form of the runtime's object dictionary."""

from __future__ import annotations

from rtgen.compiler.model.canopen import NodeRelative, Value
from rtgen.facts.canopen import (
    EPOCH,
    KINDS,
    MILLISECOND,
    DataType,
    Kind,
    milliseconds_of,
)

PYTHON_TYPES = {
    "bool": "bool",
    "char": "str",
    "string": "str",
    "wstring": "str",
    "octets": "bytes",
    "r32": "float",
    "r64": "float",
}
"""Python types of values by kind; others are int."""


def kind(data_type: int) -> Kind:
    """Return the kind of a data type; unknown types are raw octets."""
    try:
        return KINDS[DataType(data_type)]
    except ValueError:
        return "octets"


def python_type(data_type: int) -> str:
    """Return the Python type of a data type's values."""
    return PYTHON_TYPES.get(kind(data_type), "int")


def object_value(
    data_type: int, value: Value | None
) -> bool | int | float | str | bytes | None:
    """Convert a value for the runtime; a value relative to the node-id becomes the offset."""
    if isinstance(value, NodeRelative):
        return value.offset
    if not isinstance(value, int):
        return value
    match kind(data_type):
        case "bool":
            return value != 0
        case "char":
            return chr(value & 0xFF)
        case "time_of_day":
            return (milliseconds_of(value) + EPOCH) * MILLISECOND
        case "time_difference":
            return milliseconds_of(value) * MILLISECOND
    return value
