"""Adds the objects without which other tools do not read a description."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec.structs import replace

from rtgen.compiler.backends.canopen.rules import CHANGED
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.model.canopen import (
    PDOS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    TPDO_COMMUNICATION,
    Access,
    DataType,
    Device,
    Object,
    ObjectType,
    Value,
    Variable,
)
from rtgen.compiler.typemap.canopen.xdd import BIT_RATES, PRESET_RATE

_IDENTITY = 0x1018
_IDENTITY_PARTS = ("Vendor-ID", "Product code", "Revision number")
_MANDATORY = "CiA 301, 7.5.2 has it in each device"
_U8, _U32 = DataType.UNSIGNED8, DataType.UNSIGNED32


def completed(
    device: Device, *, in_xml: bool = False
) -> tuple[Device, list[Diagnostic]]:
    """Return a device with its mandatory objects, and a note of each thing that was added.

    Objects 1000h, 1001h and 1018h with sub-index 1 are mandatory, and the mapping of each PDO (CiA
    301, 7.5.2). `in_xml` tells what an XDD or XDC says beside that.
    """
    objects = {thing.index: thing for thing in device.objects}
    notes = []
    if in_xml and not {*device.info.bit_rates} & {*BIT_RATES}:
        message = (
            f"{PRESET_RATE} kbit/s is the bit rate for other tools: the file has none, CiA 311's "
            "schema requires one"
        )
        notes.append(CHANGED.at(device.span, message))
    for thing, why in _missing(device, objects):
        objects[thing.index] = thing
        message = f"{thing.index:04X}h, {thing.name}, is added: {why}"
        notes.append(CHANGED.at(device.span, message))
    ordered = tuple(objects[index] for index in sorted(objects))
    return replace(device, objects=ordered), notes


def _missing(
    device: Device, objects: dict[int, Object]
) -> Iterator[tuple[Object, str]]:
    for index, name, type_ in (
        (0x1000, "Device type", _U32),
        (0x1001, "Error register", _U8),
    ):
        if device.find(index) is None:
            one = _variable(device, index, 0, name, type_, 0)
            yield _object(device, index, name, ObjectType.VAR, [one]), _MANDATORY
    if device.find(_IDENTITY, 1) is None:
        yield _identity(device), _MANDATORY
    for base in (RPDO_COMMUNICATION, TPDO_COMMUNICATION):
        for index in range(base, base + PDOS):
            mapping = index + RPDO_MAPPING - RPDO_COMMUNICATION
            if index in objects and mapping not in objects:
                name = f"{objects[index].name} mapping"
                first = _variable(device, mapping, 0, "Mapped objects", _U8, 0)
                record = _object(device, mapping, name, ObjectType.RECORD, [first])
                yield record, f"{index:04X}h is a PDO, without a mapped object"


def _identity(device: Device) -> Object:
    """Return the identity object, with what the description says elsewhere."""
    info = device.info
    known = (info.vendor_number or 0, info.product_number, info.revision_number)
    parts = [
        _variable(device, _IDENTITY, sub, name, _U32, value)
        for sub, (name, value) in enumerate(zip(_IDENTITY_PARTS, known, strict=True), 1)
        if value is not None
    ]
    of_file = {v.subindex: v for v in device.variables if v.index == _IDENTITY}
    members = {**{v.subindex: v for v in parts}, **of_file}
    members.pop(0, None)
    count = max(members)
    first = _variable(device, _IDENTITY, 0, "Highest sub-index supported", _U8, count)
    ordered = [first, *(members[sub] for sub in sorted(members))]
    return _object(device, _IDENTITY, "Identity object", ObjectType.RECORD, ordered)


def _object(
    device: Device, index: int, name: str, type_: ObjectType, members: list[Variable]
) -> Object:
    return Object(
        index=index,
        name=name,
        type=type_,
        variables=tuple(members),
        span=device.span,
    )


def _variable(
    device: Device,
    index: int,
    subindex: int,
    name: str,
    type_: DataType,
    default: Value,
) -> Variable:
    return Variable(
        index=index,
        subindex=subindex,
        name=name,
        data_type=type_,
        access=Access.RO,
        written_access=Access.RO.value,
        span=device.span,
        value_span=device.span,
        default=default,
    )
