"""CANopen data types as the runtime's descriptions call them, and values as these hold them.

The kinds are those of `rtgen.runtime.canopen.description.Kind`.
"""

from __future__ import annotations

from rtgen.model.canopen import (
    SIGNED,
    UNSIGNED,
    DataType,
    NodeRelative,
    Value,
)

KINDS = {
    DataType.BOOLEAN: "bool",
    DataType.VISIBLE_CHAR: "char",
    DataType.VISIBLE_STRING: "string",
    DataType.UNICODE_STRING: "wstring",
    DataType.OCTET_STRING: "octets",
    DataType.DOMAIN: "octets",
    DataType.TIME_OF_DAY: "time_of_day",
    DataType.TIME_DIFFERENCE: "time_difference",
    DataType.REAL32: "r32",
    DataType.REAL64: "r64",
    **{code: f"i{bits}" for code, bits in SIGNED.items()},
    **{code: f"u{bits}" for code, bits in UNSIGNED.items()},
}
"""The kind of each data type."""

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

_MILLISECONDS = (1 << 28) - 1
_DAY = 86_400_000
_EPOCH_DAYS = 5113
"""1984-01-01 in days since 1970."""


def kind(data_type: int) -> str:
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
            return _nanoseconds(value, _EPOCH_DAYS)
        case "time_difference":
            return _nanoseconds(value, 0)
    return value


def _nanoseconds(raw: int, days: int) -> int:
    """The time that 48 bits are: milliseconds, then days."""
    return (((raw >> 32) + days) * _DAY + (raw & _MILLISECONDS)) * 1_000_000
