"""What generated text says about objects of devices."""

from __future__ import annotations

from rtgen.model.canopen import STRUCTURES, DataType, Variable
from rtgen.typemap.canopen_ports import Quantity


def line(text: str) -> str:
    """A text of a description in one line, without what comments and XML cannot hold."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return " ".join(printable.replace("\\", "/").split())


def number(variable: Variable) -> str:
    """Its place as CiA writes it: `6064h`, `1018h:1`."""
    subindex = f":{variable.subindex}" if variable.subindex else ""
    return f"{variable.index:04X}h{subindex}"


def type_name(data_type: int) -> str:
    """The name of a data type: `INTEGER16`; of one that is not known, its code."""
    try:
        return DataType(data_type).name
    except ValueError:
        return STRUCTURES.get(data_type, f"type {data_type:04X}h")


def told(quantity: Quantity) -> str:
    """An object in one line: number, name, type, factor and unit.

    A factor of the description that the value is shown without stands as the unit: `0.1 rpm`.
    """
    variable = quantity.variable
    text = f"{line(variable.name)} ({number(variable)}, {type_name(variable.data_type)}"
    if quantity.factor is not None:
        text += f", times {quantity.factor!r}"
    elif variable.factor not in (None, 0, 1):
        text += f", in units of {variable.factor!r} {line(variable.unit)}".rstrip()
    text += ")"
    unit = line(quantity.unit)
    return f"{text} [{unit}]" if unit else text
