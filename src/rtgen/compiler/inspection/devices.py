"""Output of `rtgen inspect` for a CANopen device: JSON (`rtgen-inspect/1`) and text."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, TypeAlias

from rtgen.compiler.backends.kit.quoting.idl import readable_string
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

Json: TypeAlias = dict[str, Any]


def declaration(d: Device) -> Json:
    """Return the device as JSON; the gap types of DummyUsage come first among its objects."""
    info = d.info
    return {
        "kind": "device",
        "name": d.name,
        "file": d.file,
        "line": d.span.line,
        "vendor_id": d.vendor_id,
        "product_code": d.product_code,
        "vendor": info.vendor_name,
        "product": info.product_name,
        "revision": info.revision_number,
        "node_id": d.node_id,
        "bit_rate": None if d.commissioning is None else d.commissioning.bit_rate,
        "bit_rates": list(info.bit_rates),
        "lss": info.lss,
        "objects": [*map(_dummy, d.dummies)]
        + [_variable(v, d.node_id) for v in d.variables],
        "pdos": [_pdo(p, d.node_id) for p in d.pdos],
        "doc": d.file_info.description,
        "annotations": [],
    }


def _dummy(code: int) -> Json:
    return {
        "index": code,
        "subindex": 0,
        "name": f"Dummy{code:04X}",
        "data_type": code,
        "access": Access.CONST.value,
        "default": None,
        "value": None,
        "low": None,
        "high": None,
        "unit": None,
        "factor": None,
        "pdo": False,
    }


def _variable(v: Variable, node_id: int | None) -> Json:
    return {
        "index": v.index,
        "subindex": v.subindex,
        "name": v.name,
        "data_type": int(v.data_type),
        "access": v.written_access,
        "default": value_of(v.default, node_id),
        "value": value_of(v.value, node_id),
        "low": value_of(v.low, node_id),
        "high": value_of(v.high, node_id),
        "unit": v.unit or None,
        "factor": v.factor,
        "pdo": v.pdo_mappable,
    }


def _pdo(p: Pdo, node_id: int | None) -> Json:
    return {
        "direction": p.direction.value,
        "number": p.number,
        "cob_id": value_of(p.cob_id, node_id),
        "transmission_type": p.transmission_type,
        "inhibit_time": p.inhibit_time,
        "event_timer": p.event_timer,
        "sync_start": p.sync_start,
        "entries": [*map(_entry, p.entries)],
        "default_entries": [*map(_entry, p.default_entries)],
    }


def _entry(entry: PdoEntry) -> Json:
    return {"index": entry.index, "subindex": entry.subindex, "bits": entry.bits}


def value_of(value: Value | None, node_id: int | None) -> Any:
    """Return a value as JSON: octets as hexadecimal digits, NaN and infinities as text."""
    match resolved(value, node_id):
        case bytes() as octets:
            return octets.hex()
        case float() as number if not math.isfinite(number):
            return str(number)
        case None | int() | float() | str() as plain:
            return plain
        case formula:
            return str(formula)


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
            line = f"{_type(v)} {v.written_access} {v.name}{shown}{scale}{unit}"
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


def _type(v: Variable) -> str:
    code = v.data_type
    return code.name if isinstance(code, DataType) else f"type {code:04X}h"
