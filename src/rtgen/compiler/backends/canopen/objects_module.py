"""The part of a device's package besides its types: the typed table of objects, the description."""

from __future__ import annotations

from msgspec.structs import replace

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.component_module import Values
from rtgen.compiler.backends.canopen.literals import (
    items,
    literal,
    named,
    number,
    octets_literal,
)
from rtgen.compiler.backends.kit.python_module import PythonModule, python_module
from rtgen.compiler.backends.kit.quoting.python import Python, docstring, string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.layouts.can_startup import StartWrite, configuration, configured
from rtgen.compiler.model.can_bus import DeviceKind
from rtgen.compiler.model.canopen import (
    DataType,
    Device,
    NodeRelative,
    Pdo,
    Value,
    Variable,
    cob_id_in_force,
)
from rtgen.compiler.typemap.canopen.labels import line
from rtgen.compiler.typemap.canopen.names import TABLES, identifier, table_class
from rtgen.compiler.typemap.canopen.ports import DevicePorts
from rtgen.compiler.typemap.canopen.values import kind, object_value, python_type

DESCRIPTION, CONFIGURATION, REMAPPED = TABLES
"""The description, the writes that configure the device, and its PDOs after them."""

_CLASSES = {
    "bool": "Boolean",
    "int": "Integer",
    "float": "Real",
    "str": "Text",
    "bytes": "Octets",
}
"""The classes of entries by the types of their values."""
_IDENTITY = 0x1018
_EVENT_DRIVEN = 255


def objects_module(path: str, ports: DevicePorts, options: Options) -> PythonModule:
    """Return the part of the module at the path."""
    kind, device = ports.kind, as_delivered(ports.kind.device)
    info = device.info
    body = render(
        "canopen/objects.py.j2",
        module=ports.module,
        table=table_class(ports.module),
        objects=[
            _entry(variable, ports.names[variable.index, variable.subindex], device)
            for variable in device.variables
        ],
        pdos=[pdo_values(pdo, device) for pdo in device.pdos],
        remapped=[
            pdo_values(pdo, device)
            for pdo in (configured(kind).pdos if is_remapped(kind) else ())
        ],
        configuration=[*map(write_values, configuration(kind))],
        info=info,
        vendor_id=_hex(identity_of(device, 1)),
        product_code=_hex(identity_of(device, 2)),
        revision_number=_hex(identity_of(device, 3)),
        dummies=device.dummies and items([f"0x{c:04X}" for c in device.dummies]),
        bit_rates=info.lss and info.bit_rates and items([*map(str, info.bit_rates)]),
    )
    return python_module(
        path,
        options,
        [device.key],
        f"The device of `{device.key}`: types of its ports, its objects, its description.",
        body=body,
    )


def is_remapped(kind: DeviceKind) -> bool:
    """Whether the PDOs of the configured device differ from its default ones."""
    return configured(kind).pdos != as_delivered(kind.device).pdos


def write_values(write: StartWrite) -> Values:
    """Return the values of the template of a write."""
    return {
        "place": number(write.variable.index, write.variable.subindex),
        "octets": octets_literal(write.value),
        "verify": write.verify,
        "relative": write.relative,
    }


def as_delivered(device: Device) -> Device:
    """The device before configuration; a device described by a DCF is configured already."""
    if device.commissioning is not None:
        return device
    objects = tuple(
        replace(o, variables=tuple(replace(v, value=None) for v in o.variables))
        for o in device.objects
    )
    plain = replace(device, objects=objects)
    return replace(plain, pdos=tuple(_default(pdo, plain) for pdo in device.pdos))


def _default(pdo: Pdo, device: Device) -> Pdo:
    """A PDO by the defaults of its objects."""

    def default(subindex: int) -> Value | None:
        variable = device.find(pdo.communication, subindex)
        return None if variable is None else variable.default

    def number(subindex: int) -> int | None:
        value = default(subindex)
        return value if isinstance(value, int) else None

    number_of_cob_id = pdo.communication, 1
    cob_id = cob_id_in_force(number_of_cob_id, default(1), device.node_id)
    assert isinstance(cob_id, int | NodeRelative)
    return replace(
        pdo,
        cob_id=cob_id,
        transmission_type=number(2),
        entries=pdo.default_entries,
        inhibit_time=number(3),
        event_timer=number(5),
        sync_start=number(6),
    )


def identity_of(device: Device, subindex: int) -> int | None:
    """A number of the identity: 1018h's, else (sub-indices 1 to 3) DeviceInfo's."""
    if current := device.number(_IDENTITY, subindex):
        return current
    info = device.info
    numbers = (info.vendor_number, info.product_number, info.revision_number)
    return numbers[subindex - 1] if subindex <= len(numbers) else None


def _hex(value: int | None) -> Python:
    return Python(f"0x{value:X}" if value else "")


def _entry(variable: Variable, name: str, device: Device) -> Values:
    value = object_value(variable.data_type, variable.current)
    if not value and variable.index == _IDENTITY and variable.subindex:
        value = identity_of(device, variable.subindex) or value
    relative = isinstance(variable.current, NodeRelative)
    default = _default_text(variable, value, relative)
    options = {
        "low": _limit(variable.low),
        "high": _limit(variable.high),
        "relative": "True" if relative else "",
        "mappable": "True" if variable.pdo_mappable else "",
    }
    return {
        "name": name,
        "class": _CLASSES[python_type(variable.data_type)],
        "arguments": [
            string_literal(kind(variable.data_type)),
            number(variable.index, variable.subindex),
            string_literal(variable.access.value),
            *([Python(default)] if default else []),
            *(Python(f"{key}={text}") for key, text in options.items() if text),
        ],
        "docstring": _docstring(variable, name),
    }


def _docstring(variable: Variable, name: str) -> Python:
    """Return name and unit of an object, unless its identifier says the same, as most do."""
    shown, unit = line(variable.name), line(variable.unit)
    if not unit and shown.isascii() and name.startswith(identifier(shown)):
        return docstring("", 4)
    text = f"{named(variable.index, variable.subindex)} {shown}"
    return docstring(f"{text} [{unit}]." if unit else f"{text}.", 4)


def _default_text(
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


def pdo_values(pdo: Pdo, device: Device, node_id: int | None = None) -> Values:
    """Return the values of the template of a PDO; with a node-id, with the COB-ID of that node."""
    given = pdo.cob_id
    relative = isinstance(given, NodeRelative)
    cob_id = given.offset if isinstance(given, NodeRelative) else given
    if relative and node_id is not None:
        relative, cob_id = False, cob_id + node_id
    used = device.find(pdo.mapping, 0)
    transmission = pdo.transmission_type
    return {
        "direction": pdo.direction.value,
        "number": pdo.number,
        "cob_id": Python(f"-0x{-cob_id:X}" if cob_id < 0 else f"0x{cob_id:X}"),
        "is_relative": relative,
        "transmission_type": _EVENT_DRIVEN if transmission is None else transmission,
        "entries": [
            {"place": number(e.index, e.subindex), "bits": e.bits} for e in pdo.entries
        ],
        "inhibit_time": pdo.inhibit_time,
        "event_timer": pdo.event_timer,
        "sync_start": pdo.sync_start,
        "fixed": used is None or not used.access.writable,
    }
