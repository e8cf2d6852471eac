"""The profile of a proxy: its PDOs are the mirror of the device's (RTC-CANopen, figure 109).

The proxy receives the TPDOs of the device under the same number, COB-ID and mapping: the objects
of a TPDO (1800h, 1A00h) lie 400h lower in the proxy (1400h, 1600h), those of an RPDO 400h higher.
"""

from __future__ import annotations

from collections.abc import Iterator

from msgspec.structs import replace

from rtgen.compiler.model.canopen import (
    NO_RTR,
    PDOS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    TPDO_COMMUNICATION,
    TPDO_MAPPING,
    Access,
    Device,
    NodeRelative,
    Object,
    PdoDirection,
    Value,
    Variable,
)
from rtgen.compiler.typemap.canopen.ports import DevicePorts

SHIFT = 0x400

_OWN = (0x1000, 0x1001, 0x1018)
_COB_ID, _TRANSMISSION, _SYNC_START = 1, 2, 6
_ON_REQUEST = (252, 253)
_EVENT_DRIVEN = 255


def measured(ports: DevicePorts) -> Device:
    """Return the device with the factors and the units of the bus file at its objects."""
    stated = {number for number, _ in (*ports.kind.factors, *ports.kind.units)}

    def changed(variable: Variable) -> Variable:
        if variable.number not in stated:
            return variable
        quantity = ports.quantity(variable)
        return replace(variable, factor=quantity.factor, unit=quantity.unit)

    objects = (
        replace(thing, variables=tuple(map(changed, thing.variables)))
        for thing in ports.device.objects
    )
    return replace(ports.device, objects=tuple(objects))


def mirrored(device: Device, file_name: str) -> Device:
    """Return the profile of a proxy: its mandatory objects, PDOs and mapped objects.

    Its `pdos` are omitted: readers of the description derive them.
    """
    sent, received = (
        {
            entry.index
            for pdo in device.pdos
            if pdo.direction is direction
            for entry in pdo.entries
        }
        for direction in (PdoDirection.RPDO, PdoDirection.TPDO)
    )
    objects = []
    for thing in device.objects:
        shift = _shift(thing.index)
        if shift:
            objects.append(_moved(_stated(thing, device.node_id), shift))
        elif thing.index in sent or thing.index in received:
            objects.append(_turned(thing, thing.index in sent, thing.index in received))
        elif thing.index in _OWN:
            objects.append(thing)
    objects.sort(key=lambda o: o.index)
    info = replace(
        device.info,
        rpdos=_count(objects, RPDO_COMMUNICATION),
        tpdos=_count(objects, TPDO_COMMUNICATION),
        compact_pdo=0,
        boot_up_slave=False,
        lss=False,
    )
    return replace(
        device,
        info=info,
        objects=tuple(objects),
        pdos=(),
        commissioning=None,
        further=(),
        file_info=replace(device.file_info, file_name=file_name, last_eds=""),
    )


def _shift(index: int) -> int:
    """Return the offset of the index of a PDO's object; 0 for other objects."""
    for base in (TPDO_COMMUNICATION, TPDO_MAPPING):
        if base <= index < base + PDOS:
            return -SHIFT
    for base in (RPDO_COMMUNICATION, RPDO_MAPPING):
        if base <= index < base + PDOS:
            return SHIFT
    return 0


def _count(objects: list[Object], base: int) -> int:
    return sum(base <= o.index < base + PDOS for o in objects)


def _stated(thing: Object, node_id: int | None) -> Object:
    """Return an object with the COB-ID in force: the mirrored PDO has another predefined one."""
    variables = tuple(
        replace(
            variable,
            default=variable.initial(node_id),
            value=None if variable.value is None else variable.in_force(node_id),
        )
        for variable in thing.variables
    )
    return replace(thing, variables=variables)


def _moved(thing: Object, shift: int) -> Object:
    return replace(
        thing,
        index=thing.index + shift,
        name=_renamed(thing.name, shift),
        variables=tuple(_members(thing, shift)),
        links=(),
    )


def _members(thing: Object, shift: int) -> Iterator[Variable]:
    communication = thing.index + shift in (
        *range(RPDO_COMMUNICATION, RPDO_COMMUNICATION + PDOS),
        *range(TPDO_COMMUNICATION, TPDO_COMMUNICATION + PDOS),
    )
    kept = [
        v
        for v in thing.variables
        if not (communication and shift < 0 and v.subindex == _SYNC_START)
    ]
    for variable in kept:
        changed = replace(
            variable,
            index=variable.index + shift,
            name=_renamed(variable.name, shift),
        )
        if communication and shift < 0:
            changed = _received(changed, max(v.subindex for v in kept))
        yield changed


def _received(variable: Variable, highest: int) -> Variable:
    """Return a communication parameter of a TPDO, converted to one of an RPDO."""

    def at_most(value: Value | None) -> Value | None:
        return min(value, highest) if isinstance(value, int) else value

    conversions = {0: at_most, _COB_ID: _without_rtr, _TRANSMISSION: _unasked}
    convert = conversions.get(variable.subindex)
    if convert is None:
        return variable
    default, value = convert(variable.default), convert(variable.value)
    return replace(variable, default=default, value=value)


def _without_rtr(value: Value | None) -> Value | None:
    if isinstance(value, NodeRelative) and value.offset >= 0:
        return NodeRelative(value.offset & ~NO_RTR)
    return value & ~NO_RTR if isinstance(value, int) else value


def _unasked(value: Value | None) -> Value | None:
    """Return the transmission type of an RPDO, which cannot be RTR-only."""
    return _EVENT_DRIVEN if value in _ON_REQUEST else value


def _renamed(name: str, shift: int) -> str:
    """Return the name with the direction reversed."""
    old, new = ("TPDO", "RPDO") if shift < 0 else ("RPDO", "TPDO")
    words, others = ("ransmit", "eceive"), ("T", "R")
    if shift > 0:
        words, others = words[::-1], others[::-1]
    for text, other in (
        (old, new),
        (others[0] + words[0], others[1] + words[1]),
        ((others[0] + words[0]).lower(), (others[1] + words[1]).lower()),
    ):
        name = name.replace(text, other)
    return name


def _turned(thing: Object, sent: bool, received: bool) -> Object:
    """Return a mapped object with the access for the proxy's PDOs."""
    variables = tuple(
        replace(v, access=_access(v.access, sent, received)) if v.pdo_mappable else v
        for v in thing.variables
    )
    return replace(thing, variables=variables, links=())


def _access(access: Access, sent: bool, received: bool) -> Access:
    if sent and received:
        return Access.RW
    if sent and not access.in_tpdo:
        return Access.RWR
    if received and not access.in_rpdo:
        return Access.RWW
    return access
