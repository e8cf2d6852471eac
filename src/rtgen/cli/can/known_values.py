"""Values of objects in words and in JSON: with factor and unit, by their kind."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import UTC, datetime

from rtgen.cli.can.known import KnownNode, KnownObject, written
from rtgen.cli.rpc.values import Json
from rtgen.runtime.canopen.description import Kind, ObjectValue
from rtgen.runtime.canopen.frames import SECOND
from rtgen.runtime.canopen.values import ObjectValueError, decode, size

_SHOWN = 24
"""Octets of a value that are shown in a text."""


@dataclass(frozen=True, slots=True)
class Field:
    """A value of an object of a node; `node` is empty if nobody has told of the node."""

    node: str
    thing: KnownObject
    value: ObjectValue

    @property
    def name(self) -> str:
        """The object's name, else its number."""
        return self.thing.name or written(self.thing.number)

    @property
    def physical(self) -> ObjectValue:
        """The value times the factor; without one, the value."""
        factor, value = self.thing.factor, self.value
        if factor is None or isinstance(value, (bool, str, bytes)):
            return value
        return _rounded(value * factor)

    @property
    def text(self) -> str:
        """The value with its unit, for people."""
        thing, value = self.thing, self.physical
        text = _text(thing.kind, value)
        if thing.kind == "u32" and thing.number[0] < 0x2000 and isinstance(value, int):
            text = f"0x{value:X}"
        if thing.unit:
            text += f" {thing.unit}"
        return f"{text} ({self.words})" if self.words else text

    @property
    def words(self) -> str:
        """What the value means, where it is more than a number."""
        if self.thing.words is None or not isinstance(self.value, int):
            return ""
        return self.thing.words(self.value)

    def __str__(self) -> str:
        return f"{self.name}={self.text}"

    def to_json(self) -> dict[str, Json]:
        """Object, name, value and unit; the value on the bus as `raw` if there is a factor."""
        told: dict[str, Json] = {
            "object": written(self.thing.number),
            "name": self.thing.name,
            "value": json_value(self.thing.kind, self.physical),
        }
        if self.thing.factor is not None:
            told["raw"] = json_value(self.thing.kind, self.value)
        if self.thing.unit:
            told["unit"] = self.thing.unit
        if self.words:
            told["words"] = self.words
        return told


def field_of(node: KnownNode | None, thing: KnownObject, value: ObjectValue) -> Field:
    """A value of a variable of a node."""
    return Field(node.name if node else "", thing, value)


def sdo_value(thing: KnownObject, octets: bytes) -> ObjectValue:
    """The value in octets of a transfer; the octets themselves if they are none.

    An expedited message that does not tell its length has 4 octets.
    """
    wanted = size(thing.kind)
    if wanted is not None and wanted < len(octets) == 4:
        octets = octets[:wanted]
    try:
        return decode(thing.kind, octets)
    except ObjectValueError:
        return octets


def _text(kind: Kind, value: ObjectValue) -> str:
    if isinstance(value, bytes):
        shown = value[:_SHOWN].hex(" ")
        more = len(value) - _SHOWN
        return f"{shown} ... ({len(value)} octets)" if more > 0 else shown or "(empty)"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    told = json_value(kind, value)
    return told if isinstance(told, str) else json.dumps(told)


def json_value(kind: Kind, value: ObjectValue) -> Json:
    """The value as JSON: octets in hex, times of day as ISO 8601, differences in seconds."""
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, int) and kind == "time_of_day":
        return iso_time(value)
    if isinstance(value, int) and kind == "time_difference":
        return value / SECOND
    return value


def iso_time(time: int) -> str:
    """A time in ns of UTC since 1970, to the millisecond."""
    moment = datetime.fromtimestamp(time // SECOND, UTC)
    return f"{moment:%Y-%m-%dT%H:%M:%S}.{time % SECOND // 1_000_000:03}Z"


def _rounded(value: float) -> float:
    """Without the noise of a factor such as 0.001 in the last digits."""
    return float(f"{value:.15g}")
