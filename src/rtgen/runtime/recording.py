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
    EnumDescriptor,
    ExceptionDescriptor,
    StructDescriptor,
)
from rtgen.runtime.records import Record, SampleRecord


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
    """A generated value as what JSON knows, with the names that the definition has."""
    descriptor = getattr(value, "_descriptor_", None)
    if isinstance(descriptor, EnumDescriptor):
        return next(name for name, number in descriptor.members if number == value)
    if isinstance(descriptor, StructDescriptor | ExceptionDescriptor):
        return {
            member.name: plain(getattr(value, member.attribute))
            for member in descriptor.members
        }
    if isinstance(value, Enum):
        return value.name
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, dict):
        return [[plain(key), plain(item)] for key, item in value.items()]
    if isinstance(value, bytes):
        return list(value)
    if isinstance(value, Decimal):
        return str(value)
    if is_dataclass(value):
        return {
            field.name: plain(getattr(value, field.name)) for field in fields(value)
        }
    return {name: plain(getattr(value, name)) for name in ("discriminator", "value")}
