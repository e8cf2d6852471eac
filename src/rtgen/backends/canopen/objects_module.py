"""The module `objects` of a device: its description as a table, and typed access to its values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtgen.backends.canopen.literals import call, items, literal, named, number
from rtgen.backends.python_text import docstring, fit, string_literal
from rtgen.model.canopen import (
    RPDO_COMMUNICATION,
    TPDO_COMMUNICATION,
    DataType,
    Device,
    NodeRelative,
    Pdo,
    PdoDirection,
    Variable,
)
from rtgen.typemap.canopen_values import kind, object_value, python_type

_MAPPING = 0x200
_EVENT_DRIVEN = 255


def class_name(module: str) -> str:
    """The name of the class with the typed values."""
    return f"{module}Objects"


def objects_text(
    module: str, device: Device, names: Mapping[tuple[int, int], str], header: str
) -> str:
    """The module. `names` are the fields of the variables by index and sub-index."""
    used = ["DeviceDescription"]
    used += ["ObjectDescription"] * any(device.variables)
    used += ["PdoDescription"] * bool(device.pdos)
    lines = [
        header + docstring(f"The object dictionary of `{device.key}`.", 0).rstrip("\n"),
        "",
        "from __future__ import annotations",
        "",
        fit(f"from rtgen.runtime.canopen.description import {', '.join(used)}"),
        "from rtgen.runtime.canopen.objects import Entry, Objects",
        "",
        fit(f"DESCRIPTION = {_description(module, device, names)}"),
        "",
        *_aliases(device),
        "",
        "",
        fit(f"class {class_name(module)}(Objects):"),
        docstring(
            f"The values of {module}'s object dictionary, as they are on the wire.", 4
        ),
        "    __slots__ = ()",
        "",
        *_entries(device, names),
    ]
    return "\n".join(lines).rstrip("\n") + "\n"


def _description(
    module: str, device: Device, names: Mapping[tuple[int, int], str]
) -> str:
    info = device.info
    return call(
        "DeviceDescription",
        name=string_literal(module),
        objects=items(
            [_object(v, names[v.index, v.subindex]) for v in device.variables]
        ),
        pdos=items([pdo_text(pdo, device) for pdo in device.pdos]),
        vendor_id=_hex(device.vendor_id),
        product_code=_hex(device.product_code),
        revision_number=_hex(_identity(device, info.revision_number, 3)),
        lss="True" if info.lss else "",
        granularity=(
            "" if info.granularity in (None, 8) else str(info.granularity or 0)
        ),
        dummies=items([f"0x{code:04X}" for code in device.dummies]),
    )


def _identity(device: Device, told: int | None, subindex: int) -> int | None:
    variable = device.find(0x1018, subindex)
    current = None if variable is None else variable.current
    return current if told is None and isinstance(current, int) else told


def _hex(value: int | None) -> str:
    return f"0x{value:X}" if value else ""


def _object(variable: Variable, name: str) -> str:
    value = object_value(variable.data_type, variable.current)
    relative = isinstance(variable.current, NodeRelative)
    return call(
        "ObjectDescription",
        number(variable.index, variable.subindex),
        string_literal(name),
        string_literal(kind(variable.data_type)),
        string_literal(variable.access.value),
        default=_default(variable, value, relative),
        low=_limit(variable.low),
        high=_limit(variable.high),
        relative="True" if relative else "",
        mappable="True" if variable.pdo_mappable else "",
    )


def _default(
    variable: Variable, value: bool | int | float | str | bytes | None, relative: bool
) -> str:
    if value is None:
        return ""
    if isinstance(value, int) and value >= 0:
        wide = variable.data_type == DataType.UNSIGNED32 and value >= 0x1000
        if wide or relative:
            return f"0x{value:X}"
    return literal(value)


def _limit(value: int | float | NodeRelative | None) -> str:
    return "" if value is None or isinstance(value, NodeRelative) else literal(value)


def pdo_text(pdo: Pdo, device: Device, node_id: int | None = None) -> str:
    """A PDO as a `PdoDescription`; with a node-id its COB-ID is that node's."""
    told = pdo.cob_id
    relative = isinstance(told, NodeRelative)
    cob_id = told.offset if isinstance(told, NodeRelative) else told
    if relative and cob_id is not None and node_id is not None:
        relative, cob_id = False, cob_id + node_id
    base = (
        TPDO_COMMUNICATION if pdo.direction is PdoDirection.TPDO else RPDO_COMMUNICATION
    )
    used = device.find(base + _MAPPING + pdo.number - 1, 0)
    transmission = pdo.transmission_type
    return call(
        "PdoDescription",
        string_literal(pdo.direction.value),
        str(pdo.number),
        "None" if cob_id is None else _signed_hex(cob_id),
        str(relative),
        str(_EVENT_DRIVEN if transmission is None else transmission),
        items([f"(0x{e.index:04X}, {e.subindex}, {e.bits})" for e in pdo.entries]),
        inhibit_time=_number(pdo.inhibit_time),
        event_timer=_number(pdo.event_timer),
        sync_start=_number(pdo.sync_start),
        fixed="True" if used is None or not used.access.writable else "",
    )


def _signed_hex(value: int) -> str:
    return f"-0x{-value:X}" if value < 0 else f"0x{value:X}"


def _number(value: int | None) -> str:
    return str(value) if value else ""


def _aliases(device: Device) -> list[str]:
    """Names for the types of entries that no object has."""
    used = sorted({python_type(v.data_type) for v in device.variables})
    return [f"_{type_} = Entry[{type_}]" for type_ in used]


def _entries(device: Device, names: Mapping[tuple[int, int], str]) -> Iterator[str]:
    for variable in device.variables:
        place = variable.index, variable.subindex
        arguments = f"0x{variable.index:04X}" + (
            f", {variable.subindex}" if variable.subindex else ""
        )
        type_ = python_type(variable.data_type)
        yield fit(f"{names[place]} = _{type_}({arguments})", 4)
        unit = f" [{variable.unit}]" if variable.unit else ""
        yield docstring(
            f"{named(*place)} {variable.name}{unit}: {_type(variable)}, "
            f"{variable.access}.",
            4,
        ).rstrip("\n")


def _type(variable: Variable) -> str:
    code = variable.data_type
    return code.name if isinstance(code, DataType) else f"type {code:04X}h"
