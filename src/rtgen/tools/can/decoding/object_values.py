"""Values of objects as text and as JSON, with factor and unit."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from datetime import UTC, datetime

from rtgen.runtime.canopen.description import Kind, ObjectValue
from rtgen.runtime.canopen.values import ObjectValueError, decode, size
from rtgen.runtime.canopen.wire.frames import SECOND
from rtgen.tools.can.decoding.node_index import DescribedNode, DescribedObject, written
from rtgen.tools.rpc.values import Json

_SHOWN = 24
"""Maximum number of octets of a value shown in text."""


@dataclass(frozen=True, slots=True)
class Field:
    """The value of an object of a node; `node` is empty for a node that is not described."""

    node: str
    thing: DescribedObject
    value: ObjectValue

    @property
    def name(self) -> str:
        """The object's name, or its number without one."""
        return self.thing.name or written(self.thing.number)

    @property
    def physical(self) -> ObjectValue:
        """The value times the factor, or the value itself without a factor."""
        factor, value = self.thing.factor, self.value
        if factor is None or isinstance(value, (bool, str, bytes)):
            return value
        return _rounded(value * factor)

    @property
    def text(self) -> str:
        """The physical value with its unit, for people."""
        thing, value = self.thing, self.physical
        if thing.factor and isinstance(self.value, int) and isinstance(value, float):
            value = round(value, _decimals(thing.factor))
        text = _text(thing.kind, value)
        if thing.kind == "u32" and thing.number[0] < 0x2000 and isinstance(value, int):
            text = f"0x{value:X}"
        if thing.unit:
            text += f" {thing.unit}"
        return f"{text} ({self.words})" if self.words else text

    @property
    def words(self) -> str:
        """The meaning of the value, for objects such as a statusword; otherwise empty."""
        if self.thing.words is None or not isinstance(self.value, int):
            return ""
        return self.thing.words(self.value)

    def __str__(self) -> str:
        return f"{self.name}={self.text}"

    def to_json(self) -> dict[str, Json]:
        """Object, name, physical value and unit; with a factor also `raw`, the value on the bus."""
        result: dict[str, Json] = {
            "object": written(self.thing.number),
            "name": self.thing.name,
            "value": json_value(self.thing.kind, self.physical),
        }
        if self.thing.factor is not None:
            result["raw"] = json_value(self.thing.kind, self.value)
        if self.thing.unit:
            result["unit"] = self.thing.unit
        if self.words:
            result["words"] = self.words
        return result


def field_of(
    node: DescribedNode | None, thing: DescribedObject, value: ObjectValue
) -> Field:
    """Return the value of an object as a field of its node."""
    return Field(node.name if node else "", thing, value)


def decoded(thing: DescribedObject, octets: bytes) -> ObjectValue:
    """Decode the octets of an SDO transfer. Raises ObjectValueError.

    An expedited message without size indication has 4 octets, which may be too many.
    """
    expected = size(thing.kind)
    if expected is not None and expected < len(octets) == 4:
        octets = octets[:expected]
    return decode(thing.kind, octets)


def sdo_value(thing: DescribedObject, octets: bytes) -> ObjectValue:
    """Decode the octets of an SDO transfer; octets of a wrong length are returned unchanged."""
    try:
        return decoded(thing, octets)
    except ObjectValueError:
        return octets


def _text(kind: Kind, value: ObjectValue) -> str:
    if isinstance(value, bytes):
        text = value[:_SHOWN].hex(" ")
        more = len(value) - _SHOWN
        return f"{text} ... ({len(value)} octets)" if more > 0 else text or "(empty)"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    converted = json_value(kind, value)
    return converted if isinstance(converted, str) else json.dumps(converted)


def json_value(kind: Kind, value: ObjectValue) -> Json:
    """Return the value in JSON: octets in hex, times of day as ISO 8601, differences in seconds."""
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, int) and kind == "time_of_day":
        return iso_time(value)
    if isinstance(value, int) and kind == "time_difference":
        return value / SECOND
    return value


def iso_time(time: int) -> str:
    """Return a time in ns of UTC since 1970 as ISO 8601, to the millisecond."""
    moment = datetime.fromtimestamp(time // SECOND, UTC)
    return f"{moment:%Y-%m-%dT%H:%M:%S}.{time % SECOND // 1_000_000:03}Z"


def _rounded(value: float) -> float:
    """Round away the binary noise of a factor such as 0.001."""
    return float(f"{value:.15g}")


def _decimals(factor: float) -> int:
    """Return two decimals more than tell values apart that differ by one step of the bus."""
    return max(0, 2 - math.floor(math.log10(abs(factor))))
