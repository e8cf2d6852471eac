"""Writes what happens in a system as JSON lines: the same run gives the same bytes."""

from __future__ import annotations

import json
import math
import threading
from dataclasses import fields, is_dataclass
from decimal import Decimal
from enum import Enum
from typing import Any, TextIO

from rtgen.runtime.descriptors import (
    BitsetDescriptor,
    Description,
    EnumDescriptor,
    ExceptionDescriptor,
    StructDescriptor,
    ValueDescriptor,
)
from rtgen.runtime.records import Record, SampleRecord
from rtgen.runtime.values import AnyValue, Box, Value


class JsonLinesRecorder:
    """A listener that writes one JSON object for each record to a text stream.

    States: `{"t", "event": "state", "instance", "from", "to", "context"}`, and `reason` with ERROR;
    samples: `{"t", "event": "sample", "instance", "port", "value"}`. `t` in ns since the start, no
    wall time. Structs are objects, enumerators their names, octets numbers, non-finite floats text.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lock = threading.Lock()

    def __call__(self, record: Record) -> None:
        line = json.dumps(_fields(record), ensure_ascii=False) + "\n"
        with self._lock:
            self._stream.write(line)


def _fields(record: Record) -> dict[str, Any]:
    told: dict[str, Any] = {
        "t": record.time,
        "event": record.kind,
        "instance": record.instance,
    }
    if isinstance(record, SampleRecord):
        return told | {"port": record.port, "value": plain(record.value)}
    told |= {
        "from": record.before.name,
        "to": record.after.name,
        "context": record.ec_id,
    }
    return told | ({"reason": record.reason} if record.reason else {})


def plain(value: object) -> Any:
    """A generated value as what JSON knows, with the names that the definition has.

    A valuetype inside of itself is told by its name alone.
    """
    return _plain(value, ())


def _plain(value: Any, around: tuple[int, ...]) -> Any:
    match value:
        case None | bool() | str():
            return value
        case Enum():
            return _enumerator(value)
        case int():
            return value
        case float():
            return value if math.isfinite(value) else str(value)
        case list() | tuple():
            return [_plain(item, around) for item in value]
        case dict():
            pairs = value.items()
            return [[_plain(k, around), _plain(v, around)] for k, v in pairs]
        case bytes():
            return list(value)
        case Decimal() | Description():
            return str(value)
        case AnyValue():
            return _plain(value.value, around)
    if id(value) in around:
        return str(value.described())
    named = _members(getattr(value, "_descriptor_", None))
    inside = (*around, id(value)) if isinstance(value, Value | Box) else around
    if named:
        return {n: _plain(getattr(value, a), inside) for n, a in named.items()}
    if is_dataclass(value):
        names = [field.name for field in fields(value)]
    else:
        names = ["discriminator", "value"]
    return {name: _plain(getattr(value, name), inside) for name in names}


def _enumerator(value: Any) -> str:
    descriptor = getattr(value, "_descriptor_", None)
    if isinstance(descriptor, EnumDescriptor):
        return next(name for name, number in descriptor.members if number == value)
    return str(value.name)


def _members(descriptor: object) -> dict[str, str]:
    """The attributes of a generated value by their names in the definition."""
    match descriptor:
        case StructDescriptor() | ExceptionDescriptor():
            return {m.name: m.attribute for m in descriptor.members}
        case ValueDescriptor():
            return {m.name: m.attribute for m in descriptor.all_members()}
        case BitsetDescriptor():
            return {f.name: f.attribute for f in descriptor.fields}
    return {}
