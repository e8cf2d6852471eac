"""Texts about objects of devices in generated code."""

from __future__ import annotations

from rtgen.compiler.model.canopen import STRUCTURES, DataType, Variable
from rtgen.compiler.typemap.canopen.ports import Quantity


def line(text: str) -> str:
    """Return a description in one line, without characters illegal in comments and XML."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return " ".join(printable.replace("\\", "/").split())


def number(variable: Variable) -> str:
    """Return the object's number in CiA's notation: `6064h`, `1018h:1`."""
    subindex = f":{variable.subindex}" if variable.subindex else ""
    return f"{variable.index:04X}h{subindex}"


def type_name(data_type: int) -> str:
    """Return a data type's name, such as `INTEGER16`; the code if it is unknown."""
    try:
        return DataType(data_type).name
    except ValueError:
        return STRUCTURES.get(data_type, f"type {data_type:04X}h")


def object_line(quantity: Quantity) -> str:
    """Describe an object in one line: number, name, type, factor and unit."""
    variable = quantity.variable
    text = f"{line(variable.name)} ({number(variable)}, {type_name(variable.data_type)}"
    if quantity.factor is not None:
        text += f", times {quantity.factor!r}"
    elif variable.factor not in (None, 0, 1):
        text += f", in units of {variable.factor!r} {line(variable.unit)}".rstrip()
    text += ")"
    unit = line(quantity.unit)
    return f"{text} [{unit}]" if unit else text
