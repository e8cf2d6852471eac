"""Device descriptions as EDS or DCF files (CiA 306).

The whole model is written, without the defaults of CiA 306, and in the forms that every reader
supports: sub-objects one by one, unsigned numbers in hexadecimal, signed ones in decimal digits,
formulas as `$NODEID+0x180`. The modules of a modular device are written as the objects that they
add.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

from rtgen.compiler.backends.canopen.portable_eds import LISTS, Portable, bits_text
from rtgen.compiler.backends.kit.quoting.properties import eds_line
from rtgen.compiler.model.canopen import (
    BIT_RATES,
    SIGNED,
    Commissioning,
    DataType,
    Device,
    DeviceInfo,
    FileInfo,
    NodeRelative,
    Object,
    ObjectType,
    Value,
    Variable,
)

_MANDATORY = (0x1000, 0x1001, 0x1018)
_SUB_OBJECT = re.compile(r"[0-9A-F]{4}sub[0-9A-F]+")
_MANUFACTURER = range(0x2000, 0x6000)
_EXACT = 2.0**53
"""The largest integer up to which REAL64 represents every integer."""
_SIMPLE_DUMMIES = range(1, 8)

_Pair: TypeAlias = tuple[str, str]
_Section: TypeAlias = tuple[str, list[_Pair]]


def eds_text(
    device: Device,
    header: Sequence[str] = (),
    remarks: Mapping[str, str] = MappingProxyType({}),
    portable: bool = False,
) -> str:
    """Return the file of a device: a DCF if it has a commissioning.

    `header` are lines of comment, `remarks` those before sections, by their names. `portable`:
    lines that strict readers refuse are comments with a mark, which rtgen reads (`portable_eds`).
    """
    lines = [eds_line(f"; {line}") for line in header]
    hidden = Portable(device) if portable else None
    for name, pairs in sections(device):
        if lines and not _SUB_OBJECT.fullmatch(name):
            lines.append("")
        if name in remarks:
            lines.append(eds_line(f"; {remarks[name]}"))
        if hidden is not None:
            lines += map(eds_line, hidden.lines(name, pairs))
            continue
        lines.append(f"[{name}]")
        lines += [eds_line(f"{key}={value}") for key, value in pairs]
    return "\n".join(lines) + "\n"


def sections(device: Device) -> Iterator[_Section]:
    """Yield the sections of a device with their keys and values."""
    yield "FileInfo", list(_file_info(device.file_info))
    yield "DeviceInfo", list(_device_info(device.info))
    if device.commissioning is not None:
        yield "DeviceComissioning", list(_commissioning(device.commissioning))
    if device.dummies:
        yield "DummyUsage", list(_dummies(device.dummies))
    if device.comments:
        comments = device.comments.split("\n")
        numbered = [(f"Line{n}", line) for n, line in enumerate(comments, 1)]
        yield "Comments", [("Lines", str(len(comments))), *numbered]
    lists: dict[str, list[Object]] = {name: [] for name in LISTS}
    for thing in device.objects:
        lists[_list_of(thing.index)].append(thing)
    for name, members in lists.items():
        yield name, _numbered("SupportedObjects", [o.index for o in members])
        for thing in members:
            yield from _object(thing)
    for name, entries in device.further:
        yield name, list(entries)


def _list_of(index: int) -> str:
    if index in _MANDATORY:
        return "MandatoryObjects"
    return "ManufacturerObjects" if index in _MANUFACTURER else "OptionalObjects"


def _numbered(count: str, indices: Sequence[int]) -> list[_Pair]:
    entries = [(str(n), f"0x{index:04X}") for n, index in enumerate(indices, 1)]
    return [(count, str(len(indices))), *entries]


def _given(**entries: str | int | None) -> Iterator[_Pair]:
    """Yield the entries that have a value."""
    for key, value in entries.items():
        if value is not None and value != "":
            yield key, str(value)


def _hex(value: int | None, digits: int = 1) -> str | None:
    return None if value is None else f"0x{value:0{digits}X}"


def _file_info(info: FileInfo) -> Iterator[_Pair]:
    yield from _given(
        FileName=info.file_name,
        FileVersion=info.version,
        FileRevision=info.revision,
        EDSVersion=info.eds_version,
        Description=info.description,
        CreationTime=info.created[1],
        CreationDate=info.created[0],
        CreatedBy=info.created_by,
        ModificationTime=info.modified[1],
        ModificationDate=info.modified[0],
        ModifiedBy=info.modified_by,
        LastEDS=info.last_eds,
    )


def _device_info(info: DeviceInfo) -> Iterator[_Pair]:
    yield from _given(
        VendorName=info.vendor_name,
        VendorNumber=_hex(info.vendor_number, 8),
        ProductName=info.product_name,
        ProductNumber=_hex(info.product_number, 8),
        RevisionNumber=_hex(info.revision_number, 8),
        OrderCode=info.order_code,
    )
    for rate in sorted({*BIT_RATES, *info.bit_rates}):
        yield f"BaudRate_{rate}", str(int(rate in info.bit_rates))
    yield from _given(
        SimpleBootUpMaster=int(info.boot_up_master),
        SimpleBootUpSlave=int(info.boot_up_slave),
        Granularity=info.granularity,
        DynamicChannelsSupported=info.dynamic_channels,
        CompactPDO=_hex(info.compact_pdo),
        GroupMessaging=int(info.group_messaging),
        NrOfRXPDO=info.rpdos,
        NrOfTXPDO=info.tpdos,
        LSS_Supported=int(info.lss),
    )


def _commissioning(commissioning: Commissioning) -> Iterator[_Pair]:
    yield from _given(
        NodeID=_hex(commissioning.node_id),
        NodeName=commissioning.node_name,
        Baudrate=commissioning.bit_rate,
        NetNumber=commissioning.net_number,
        NetworkName=commissioning.network_name,
        CANopenManager=int(commissioning.manager),
        LSS_SerialNumber=_hex(commissioning.serial_number, 8),
    )


def _dummies(allowed: Sequence[int]) -> Iterator[_Pair]:
    for code in sorted({*_SIMPLE_DUMMIES, *allowed}):
        yield f"Dummy{code:04X}", str(int(code in allowed))


def _object(thing: Object) -> Iterator[_Section]:
    name = f"{thing.index:04X}"
    if thing.type in (ObjectType.VAR, ObjectType.DOMAIN):
        for variable in thing.variables:
            yield name, list(_variable(variable, thing.type, thing.denotation))
    else:
        head = _given(
            ParameterName=thing.name,
            ObjectType=_hex(thing.type),
            SubNumber=_hex(len(thing.variables)),
            Denotation=thing.denotation,
            ObjFlags=_hex(thing.flags or None),
        )
        yield name, list(head)
        for variable in thing.variables:
            type_ = ObjectType.DOMAIN if variable.domain else ObjectType.VAR
            section = f"{name}sub{variable.subindex:X}"
            yield section, list(_variable(variable, type_, variable.denotation))
    if thing.links:
        yield f"{name}ObjectLinks", _numbered("ObjectLinks", thing.links)


def _variable(
    variable: Variable, type_: ObjectType, denotation: str
) -> Iterator[_Pair]:
    code = variable.data_type
    factor = variable.factor
    yield from _given(
        ParameterName=variable.name,
        ObjectType=None if type_ is ObjectType.VAR else _hex(type_),
        DataType=_hex(int(code), 4),
        AccessType=variable.access.value,
        LowLimit=value_text(variable.low, code),
        HighLimit=value_text(variable.high, code),
        DefaultValue=value_text(variable.default, code),
        PDOMapping=int(variable.pdo_mappable) or None,
        ParameterValue=value_text(variable.value, code),
        Denotation=denotation,
        ObjFlags=_hex(variable.flags or None),
        UploadFile=variable.upload_file,
        DownloadFile=variable.download_file,
        Unit=variable.unit,
        Factor=None if factor is None else repr(factor),
        Description=variable.description,
    )


def value_text(value: Value | None, data_type: int) -> str | None:
    """Return the text of a value in these files; None if it has none."""
    match value:
        case None | str():
            return value
        case bytes():
            return value.hex().upper()
        case NodeRelative():
            return str(value)
        case float() if not math.isfinite(value):
            return bits_text(value, data_type)
        case float() if (
            value.is_integer() and abs(value) < _EXACT and str(value) != "-0.0"
        ):
            # Checkers such as Lely's accept integers only, also for REAL32 and REAL64.
            return str(int(value))
        case float():
            return repr(value)
    if data_type in SIGNED or data_type == DataType.BOOLEAN or value < 0:
        return str(value)
    return f"0x{value:X}"
