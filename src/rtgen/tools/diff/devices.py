"""Compares CANopen devices of EDS and DCF files: identity, objects, PDOs (CiA 301, CiA 306)."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.matching import matching
from rtgen.compiler.model.canopen import (
    INVALID,
    Device,
    NodeRelative,
    Pdo,
    PdoEntry,
    Value,
    Variable,
)
from rtgen.facts.canopen import PDOS
from rtgen.tools.diff.changes import Change, change
from rtgen.tools.diff.items import Fact, Group, by_name, fact_changes, item_changes
from rtgen.tools.diff.kinds import devices as kinds
from rtgen.tools.diff.versions import Version

NumberOrRelative = int | float | NodeRelative | None


_DEVICES = Group("device", kinds.DEVICE_ADDED, kinds.DEVICE_REMOVED)
_PDOS = Group("", kinds.PDO_ADDED, kinds.PDO_REMOVED)
_FACTS = (
    Fact(kinds.DEVICE_IDENTITY, "vendor number", lambda d: _hex(d.vendor_id)),
    Fact(kinds.DEVICE_IDENTITY, "product number", lambda d: _hex(d.product_code)),
    Fact(
        kinds.DEVICE_IDENTITY,
        "revision number",
        lambda d: _hex(d.info.revision_number),
    ),
    Fact(kinds.DEVICE_INFO, "vendor name", lambda d: d.info.vendor_name),
    Fact(kinds.DEVICE_INFO, "product name", lambda d: d.info.product_name),
    Fact(kinds.DEVICE_INFO, "order code", lambda d: d.info.order_code),
    Fact(kinds.DEVICE_INFO, "description", lambda d: d.file_info.description),
    Fact(kinds.DEVICE_CAPABILITY, "LSS support", lambda d: d.info.lss),
    Fact(kinds.DEVICE_CAPABILITY, "granularity", lambda d: d.info.granularity),
    Fact(
        kinds.DEVICE_CAPABILITY,
        "boot-up as a slave",
        lambda d: d.info.boot_up_slave,
    ),
    Fact(
        kinds.DEVICE_CAPABILITY,
        "boot-up as a master",
        lambda d: d.info.boot_up_master,
    ),
    Fact(
        kinds.DEVICE_NODE_ID,
        "node-id",
        lambda d: d.commissioning and d.commissioning.node_id,
    ),
)
_PDO_FACTS = (
    Fact(kinds.PDO_TRANSMISSION, "transmission type", lambda p: p.transmission_type),
    Fact(kinds.PDO_INHIBIT, "inhibit time", lambda p: p.inhibit_time),
    Fact(kinds.PDO_EVENT_TIMER, "event timer", lambda p: p.event_timer),
    Fact(kinds.PDO_SYNC_START, "SYNC start value", lambda p: p.sync_start),
)


def compare_devices(old: Version, new: Version) -> Iterator[Change]:
    """Yield the changes of devices; another file name is another device."""
    found = matching(by_name(old.model.devices), by_name(new.model.devices))
    yield from item_changes(_DEVICES, found, lambda device: device.name)
    for one, other in found.pairs:
        yield from compare_device(one, other)


def compare_device(old: Device, new: Device) -> Iterator[Change]:
    """Yield the changes between two descriptions of a device."""
    yield from _information(old, new)
    yield from _objects(old, new)
    yield from compare_pdos(old, new)


def _information(old: Device, new: Device) -> Iterator[Change]:
    spans = (old.span, new.span)
    yield from fact_changes(_FACTS, old, new, new.name, spans, "device")
    for rate in sorted({*old.info.bit_rates} - {*new.info.bit_rates}):
        text = f"device {new.name} no longer supports {rate} kbit/s"
        yield change(kinds.DEVICE_BIT_RATE_REMOVED, new.name, text, *spans)
    for rate in sorted({*new.info.bit_rates} - {*old.info.bit_rates}):
        text = f"device {new.name} supports {rate} kbit/s"
        yield change(kinds.DEVICE_BIT_RATE_ADDED, new.name, text, *spans)


def _hex(number: int | None) -> str:
    return "none" if number is None else f"0x{number:08X}"


def _objects(old: Device, new: Device) -> Iterator[Change]:
    kinds_of = matching(
        {o.index: o for o in old.objects}, {o.index: o for o in new.objects}
    )
    for one, other in kinds_of.pairs:
        if one.type is not other.type:
            name = f"{new.name}.{other.index:04X}"
            text = f"object {name} is a {other.type.name}, was a {one.type.name}"
            yield change(kinds.OBJECT_STRUCTURE, name, text, one.span, other.span)
    before = {v.number: v for v in old.variables if not _is_pdo(v)}
    after = {v.number: v for v in new.variables if not _is_pdo(v)}
    for key, variable in before.items():
        if key not in after:
            name = _name(new, variable)
            text = f"object {name} ({variable.name}) is removed"
            yield change(kinds.OBJECT_REMOVED, name, text, variable.span, new.span)
    for key, variable in after.items():
        if key not in before:
            name = _name(new, variable)
            text = f"object {name} ({variable.name}) is added"
            yield change(kinds.OBJECT_ADDED, name, text, old.span, variable.span)
        else:
            yield from _variable(before[key], variable, _name(new, variable))


_NAMES = (
    Fact(
        kinds.OBJECT_RENAMED, '{name} is called "{now}", was "{was}"', lambda v: v.name
    ),
)
_VALUES = (
    Fact(kinds.OBJECT_DEFAULT, "default", lambda v: v.default, lambda v: shown(v)),
    Fact(kinds.OBJECT_VALUE, "value", lambda v: v.value, lambda v: shown(v)),
)


def _is_pdo(variable: Variable) -> bool:
    """Return whether a variable is a parameter of a PDO, which is compared separately."""
    return any(
        first <= variable.index < first + PDOS
        for first in (0x1400, 0x1600, 0x1800, 0x1A00)
    )


def _name(device: Device, variable: Variable) -> str:
    return f"{device.name}.{variable.index:04X}:{variable.subindex:02X}"


def _variable(old: Variable, new: Variable, name: str) -> Iterator[Change]:
    spans = (old.span, new.span)
    values = (old.value_span, new.value_span)
    yield from fact_changes(_NAMES, old, new, name, spans, "object")
    if (old.data_type, old.domain) != (new.data_type, new.domain):
        text = f"object {name} is of type {_type(new)}, was of {_type(old)}"
        yield change(kinds.OBJECT_TYPE, name, text, *spans)
    yield from _access(old, new, name)
    yield from fact_changes(_VALUES, old, new, name, values, "object")
    limits = ((old.low, old.high), (new.low, new.high))
    if limits[0] != limits[1]:
        narrowed = _is_narrower(old.low, new.low, 1) or _is_narrower(
            old.high, new.high, -1
        )
        kind = kinds.OBJECT_NARROWED if narrowed else kinds.OBJECT_WIDENED
        now, was = (f"{_end(a)}..{_end(b)}" for a, b in (limits[1], limits[0]))
        text = f"object {name} ranges over {now}, did over {was}"
        yield change(kind, name, text, *spans)
    if (old.unit, old.factor) != (new.unit, new.factor):
        now, was = (f"{v.factor or 1:g} {v.unit}".rstrip() for v in (new, old))
        text = f"object {name} counts in {now}, did in {was}"
        yield change(kinds.OBJECT_UNIT, name, text, *spans)


def _access(old: Variable, new: Variable, name: str) -> Iterator[Change]:
    spans = (old.span, new.span)
    if old.access is not new.access:
        lost = any(
            getattr(old.access, right) and not getattr(new.access, right)
            for right in ("readable", "writable", "in_tpdo", "in_rpdo")
        )
        kind = kinds.OBJECT_ACCESS_NARROWED if lost else kinds.OBJECT_ACCESS_WIDENED
        text = f"object {name} has the access {new.access}, had {old.access}"
        yield change(kind, name, text, *spans)
    if old.pdo_mappable != new.pdo_mappable:
        now = new.pdo_mappable
        kind = kinds.OBJECT_MAPPABLE_NOW if now else kinds.OBJECT_MAPPABLE
        text = f"object {name} can {'' if now else 'no longer '}be mapped"
        yield change(kind, name, text, *spans)


def _type(variable: Variable) -> str:
    name = getattr(variable.data_type, "name", None)
    return "DOMAIN" if variable.domain else name or f"0x{variable.data_type:04X}"


def shown(value: Value | None) -> str:
    """Return a value as shown in messages."""
    match value:
        case None:
            return "none"
        case bytes():
            return value.hex(" ") or "empty"
        case int() if value > 255:
            return f"0x{value:X}"
    return str(value)


def _end(limit: NumberOrRelative) -> str:
    return "" if limit is None else str(limit)


def _is_narrower(old: NumberOrRelative, new: NumberOrRelative, sign: int) -> bool:
    """Return whether a limit moved inwards; `sign` is 1 for a minimum, -1 for a maximum."""
    if new is None or old == new:
        return False
    if old is None or isinstance(old, NodeRelative) or isinstance(new, NodeRelative):
        return True
    return (new - old) * sign > 0


def compare_pdos(old: Device, new: Device) -> Iterator[Change]:
    """Yield the changes of PDOs: mapping, COB-ID, times."""
    found = matching(
        {(p.direction, p.number): p for p in old.pdos},
        {(p.direction, p.number): p for p in new.pdos},
    )
    spans = (old.span, new.span)
    yield from item_changes(_PDOS, found, lambda p: pdo_name(new, p), spans)
    for one, other in found.pairs:
        name = pdo_name(new, other)
        yield from _mapping(one, other, name, old, new)
        yield from _communication(one, other, name)


def pdo_name(device: Device, pdo: Pdo) -> str:
    """Return the name of a device's PDO: `Drive.tpdo1`."""
    return f"{device.name}.{pdo.direction}{pdo.number}"


def _mapping(
    old: Pdo, new: Pdo, name: str, before: Device, after: Device
) -> Iterator[Change]:
    spans = (old.span, new.span)
    if old.entries != new.entries:
        shorter, longer = sorted((old.entries, new.entries), key=len)
        if longer[: len(shorter)] == shorter:
            more = ", ".join(_entry(e) for e in longer[len(shorter) :])
            verb = "maps" if longer is new.entries else "no longer maps"
            text = f"{name} {verb} {more} at its end"
            yield change(kinds.PDO_APPENDED, name, text, *spans)
        else:
            now, was = (", ".join(map(_entry, p.entries)) for p in (new, old))
            text = f"{name} maps {now or 'nothing'}, did {was or 'nothing'}"
            yield change(kinds.PDO_MAPPING, name, text, *spans)
    for one, other in zip(old.entries, new.entries, strict=False):
        if one == other and not one.dummy:
            types = _mapped_type(before, one), _mapped_type(after, other)
            if types[0] != types[1]:
                text = (
                    f"{name} carries {_entry(other)} as {types[1]}, did as {types[0]}"
                )
                yield change(kinds.PDO_ENTRY_TYPE, name, text, *spans)


def _entry(entry: PdoEntry) -> str:
    return f"{entry.index:04X}:{entry.subindex:02X}/{entry.bits}"


def _mapped_type(device: Device, entry: PdoEntry) -> str:
    variable = device.find(entry.index, entry.subindex)
    return "none" if variable is None else _type(variable)


def _communication(old: Pdo, new: Pdo, name: str) -> Iterator[Change]:
    spans: tuple[Span, Span] = (old.span, new.span)
    if old.valid != new.valid:
        text = f"{name} is {'enabled' if new.valid else 'disabled'}"
        yield change(kinds.PDO_VALIDITY, name, text, *spans)
    if _identifier(old.cob_id) != _identifier(new.cob_id):
        now, was = (_cob_id(p.cob_id) for p in (new, old))
        text = f"{name} has the COB-ID {now}, had {was}"
        yield change(kinds.PDO_COB_ID, name, text, *spans)
    yield from fact_changes(_PDO_FACTS, old, new, name, spans)


def _identifier(cob_id: int | NodeRelative) -> tuple[bool, int]:
    """Return the identifier without flags, and whether it depends on the node-id."""
    relative = isinstance(cob_id, NodeRelative)
    number = cob_id.offset if isinstance(cob_id, NodeRelative) else cob_id
    return relative, number & ~INVALID


def _cob_id(cob_id: int | NodeRelative) -> str:
    if isinstance(cob_id, int):
        return f"0x{cob_id & ~INVALID:X}"
    return str(cob_id)
