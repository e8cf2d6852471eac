"""CANopen data types as the runtime's descriptions call them, and values as these hold them."""

from __future__ import annotations

from rtgen.facts.canopen import (
    EPOCH,
    KINDS,
    MILLISECOND,
    DataType,
    Kind,
    milliseconds_of,
)
from rtgen.model.canopen import NodeRelative, Value

PYTHON_TYPES = {
    "bool": "bool",
    "char": "str",
    "string": "str",
    "wstring": "str",
    "octets": "bytes",
    "r32": "float",
    "r64": "float",
}
"""What values of a kind are in Python; those of all others are int."""


def kind(data_type: int) -> Kind:
    """The kind of a data type; one that is not known is raw octets."""
    try:
        return KINDS[DataType(data_type)]
    except ValueError:
        return "octets"


def python_type(data_type: int) -> str:
    """What its values are in Python."""
    return PYTHON_TYPES.get(kind(data_type), "int")


def object_value(
    data_type: int, value: Value | None
) -> bool | int | float | str | bytes | None:
    """A value as the runtime has it; one that depends on the node-id gives its offset."""
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
