"""Output of `rtgen inspect` for a CANopen device: JSON (`rtgen-inspect/1`) and text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rtgen.compiler.backends.kit.quoting.idl import readable_string
from rtgen.compiler.inspection.facts import FIELDS, Json, facts, plain
from rtgen.compiler.model.canopen import (
    Access,
    DataType,
    Device,
    Pdo,
    PdoEntry,
    Value,
    Variable,
    resolved,
)

FIELDS.update(
    {
        Device: "kind name file line=span.line vendor_id product_code"
        " vendor=info.vendor_name product=info.product_name revision=info.revision_number"
        " node_id bit_rate bit_rates=info.bit_rates lss=info.lss objects pdos"
        " doc=file_info.description annotations",
        Variable: "index subindex name data_type access=written_access default value low"
        " high unit factor pdo=pdo_mappable",
        Pdo: "direction number cob_id transmission_type inhibit_time event_timer sync_start"
        " entries default_entries",
        PdoEntry: "index subindex bits",
    }
)


def declaration(d: Device) -> Json:
    """Return the device as JSON; the gap types of DummyUsage come first among its objects."""
    return facts(
        d,
        kind="device",
        bit_rate=None if d.commissioning is None else d.commissioning.bit_rate,
        objects=[*map(_dummy, d.dummies)]
        + [_variable(v, d.node_id) for v in d.variables],
        pdos=[facts(p, cob_id=value_of(p.cob_id, d.node_id)) for p in d.pdos],
        annotations=[],
    )


def _dummy(code: int) -> Json:
    name, access = f"Dummy{code:04X}", Access.CONST.value
    known = {"index": code, "subindex": 0, "name": name, "data_type": code}
    empty = dict.fromkeys(("default", "value", "low", "high", "unit", "factor"))
    return known | {"access": access} | empty | {"pdo": False}


def _variable(v: Variable, node_id: int | None) -> Json:
    keys = ("default", "value", "low", "high")
    values = {key: value_of(getattr(v, key), node_id) for key in keys}
    return facts(v, unit=v.unit or None, **values)


def value_of(value: Value | None, node_id: int | None) -> Any:
    """Return a value as JSON: octets as hexadecimal digits, NaN and infinities as text."""
    return plain(resolved(value, node_id))


def lines(d: Device) -> Iterator[str]:
    """Yield the device as text: a line for each variable and each PDO."""
    node = "" if d.node_id is None else f" (node {d.node_id})"
    yield f"device {d.name}{node}"
    for thing in d.objects:
        yield f"  {thing.index:04X}h {thing.name}: {thing.type.name}"
        for v in thing.variables:
            value = value_of(v.current, d.node_id)
            shown = "" if value is None else f" = {_shown(v, value)}"
            scale = "" if v.factor is None else f" times {v.factor!r}"
            unit = f" [{v.unit}]" if v.unit else ""
            line = f"{v.type_name} {v.written_access} {v.name}{shown}{scale}{unit}"
            yield f"    {v.subindex}: {line}"
    for p in d.pdos:
        cob_id = value_of(p.cob_id, d.node_id)
        number = f"{cob_id:X}h" if isinstance(cob_id, int) else cob_id
        kind = f"transmission type {p.transmission_type}"
        yield f"  {p.direction} {p.number}: COB-ID {number}, {kind}"
        for entry in p.entries:
            yield f"    {entry.index:04X}h:{entry.subindex} {entry.bits} bits"


def _shown(v: Variable, value: Any) -> str:
    """Return the JSON of a value for readers: texts as literals, a formula as it is written."""
    is_text = v.data_type in (DataType.VISIBLE_STRING, DataType.UNICODE_STRING)
    return readable_string(value) if is_text and isinstance(value, str) else str(value)
