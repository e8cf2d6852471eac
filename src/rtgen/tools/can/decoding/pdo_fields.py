"""PDOs by the mapping currently active in a node, and the values in their data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rtgen.compiler.model.canopen import (
    PDOS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    TPDO_COMMUNICATION,
    TPDO_MAPPING,
    Access,
    PdoDirection,
)
from rtgen.runtime.canopen.values import ObjectValueError, from_bits
from rtgen.runtime.canopen.wire.frames import MAX_DATA, CobId
from rtgen.tools.can.decoding.node_index import DescribedNode, DescribedObject, Number
from rtgen.tools.can.decoding.object_values import Field, field_of

_FIRST_OBJECT = 0x1000
"""Lower indices are those of data types and stand for gaps (dummy mapping)."""
_MAX_ENTRIES = 64
_MULTIPLEXED = (0xFE, 0xFF)
"""Numbers of mapped objects of multiplexed PDOs: source and destination addressing mode (MPDO)."""


@dataclass(frozen=True, slots=True)
class MappedObject:
    """An object in a PDO: its first bit and its number of bits."""

    thing: DescribedObject
    first: int
    bits: int


@dataclass(frozen=True, slots=True)
class Route:
    """A PDO of a node with its mapped objects. `bits` is its length, gaps included."""

    node: DescribedNode
    direction: PdoDirection
    number: int
    mapped: tuple[MappedObject, ...]
    bits: int
    multiplexed: bool = False

    @property
    def pdo(self) -> str:
        """The name of the PDO, such as `tpdo1`."""
        return f"{self.direction}{self.number}"

    @property
    def octets(self) -> int:
        """The length of its data."""
        return MAX_DATA if self.multiplexed else (self.bits + 7) // 8

    def fields(self, data: bytes) -> tuple[Field, ...]:
        """Decode the objects for which the data are long enough."""
        if self.multiplexed:
            return self._multiplexed(data)
        whole = int.from_bytes(data, "little")
        result = []
        for entry in self.mapped:
            if entry.first + entry.bits > 8 * len(data):
                break
            raw = whole >> entry.first & (1 << entry.bits) - 1
            result.append(self._field(entry, raw))
        return tuple(result)

    def _field(self, entry: MappedObject, raw: int) -> Field:
        thing, bits = entry.thing, entry.bits
        try:
            value = from_bits(thing.kind, raw, bits)
        except ObjectValueError:
            value = raw.to_bytes((bits + 7) // 8, "little")
        return field_of(self.node, thing, value)

    def _multiplexed(self, data: bytes) -> tuple[Field, ...]:
        """Return the single value of a multiplexed PDO: address, index, sub-index, 4 octets."""
        if len(data) != MAX_DATA:
            return ()
        number = data[1] | data[2] << 8, data[3]
        return (field_of(self.node, object_of(self.node, number), data[4:]),)


def object_of(node: DescribedNode | None, number: Number) -> DescribedObject:
    """Return the object of a node, or an unnamed one for an unknown number."""
    thing = node.objects.get(number) if node else None
    return thing or DescribedObject(number, "", "octets", Access.RW)


def routes(
    node: DescribedNode, parameters: Mapping[Number, int]
) -> Iterator[tuple[tuple[int, bool], Route]]:
    """Yield the valid PDOs by CAN identifier and whether it has 29 bits.

    They are determined by the node's parameters.
    """
    for direction, base, mapping in (
        (PdoDirection.TPDO, TPDO_COMMUNICATION, TPDO_MAPPING),
        (PdoDirection.RPDO, RPDO_COMMUNICATION, RPDO_MAPPING),
    ):
        for (index, subindex), value in parameters.items():
            if subindex != 1 or not base <= index < base + PDOS:
                continue
            cob_id = CobId(value & 0xFFFFFFFF)
            if not cob_id.valid:
                continue
            route = _route(node, direction, index - base, mapping, parameters)
            yield (cob_id.can_id, cob_id.extended), route


def _route(
    node: DescribedNode,
    direction: PdoDirection,
    place: int,
    mapping: int,
    parameters: Mapping[Number, int],
) -> Route:
    count = parameters.get((mapping + place, 0), 0)
    if count in _MULTIPLEXED:
        return Route(node, direction, place + 1, (), 64, multiplexed=True)
    mapped, bits = [], 0
    for subindex in range(1, min(count, _MAX_ENTRIES) + 1):
        entry = parameters.get((mapping + place, subindex), 0)
        number, length = (entry >> 16, entry >> 8 & 0xFF), entry & 0xFF
        if length and number[0] >= _FIRST_OBJECT:
            mapped.append(MappedObject(object_of(node, number), bits, length))
        bits += length
    return Route(node, direction, place + 1, tuple(mapped), bits)
