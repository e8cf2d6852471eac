"""PDO mapping: packs and unpacks objects as bit fields (CiA 301, 7.5.2.36 and .38)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from typing import Final, Literal, TypeAlias

import msgspec

from rtgen.facts.canopen import KIND_BITS, SIGNED_KINDS, TPDO_MAPPING, Kind
from rtgen.facts.write_order import pdo_of
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import DeviceDescription, ObjectNumber
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.sdo import SdoAbort

Direction: TypeAlias = Literal["tpdo", "rpdo"]

MAX_BITS: Final = 64

_DUMMY_BITS: Final = {1: 1, 2: 8, 3: 16, 4: 32, 5: 8, 6: 16, 7: 32}
_GAP: Final = 0x20
"""Lower indices are data types."""
_DIRECTIONS: Final[dict[str, tuple[Direction, ...]]] = {
    "ro": ("tpdo",),
    "const": ("tpdo",),
    "rwr": ("tpdo",),
    "wo": ("rpdo",),
    "rww": ("rpdo",),
}
"""The direction of PDOs that an access type allows; others allow both (CiA 306)."""


def entry_of(index: int, subindex: int, bits: int) -> int:
    """Return an entry in the encoding of the mapping parameter."""
    return index << 16 | subindex << 8 | bits


class MappedField(msgspec.Struct, frozen=True, gc=False):
    """A field of a PDO with its variable, None for a gap."""

    number: ObjectNumber | None
    kind: Kind
    bits: int


def checked_field(
    description: DeviceDescription, direction: Direction, entry: int
) -> MappedField:
    """Return the field of a mapping entry. Raises SdoAbort if the device cannot map it."""
    number = entry >> 16, entry >> 8 & 0xFF
    bits = entry & 0xFF
    if number[0] < _GAP and number[0]:
        dummy = number[0] in description.dummies and not number[1]
        if direction == "tpdo" or not dummy or bits != _DUMMY_BITS.get(number[0], bits):
            raise SdoAbort(sdo.NOT_MAPPABLE)
        _check_granularity(description, bits)
        return MappedField(None, "octets", bits)
    described = description.by_number.get(number)
    if described is None:
        raise SdoAbort(sdo.NO_OBJECT)
    allowed = direction in _DIRECTIONS.get(described.access, ("tpdo", "rpdo"))
    if not (described.mappable and allowed and _fits(described.kind, bits)):
        raise SdoAbort(sdo.NOT_MAPPABLE)
    _check_granularity(description, bits)
    return MappedField(number, described.kind, bits)


def own_entries(description: DeviceDescription) -> dict[Direction, frozenset[int]]:
    """Return the entries that a description maps, by direction: used and unused ones."""
    by_direction: dict[Direction, set[int]] = {"tpdo": set(), "rpdo": set()}
    for pdo in description.pdos:
        by_direction[pdo.direction].update(entry_of(*entry) for entry in pdo.mapping)
    for described in description.objects:
        communication = pdo_of(described.index)
        is_entry = communication not in (None, described.index) and described.subindex
        if is_entry and isinstance(described.default, int) and described.default:
            sent = described.index >= TPDO_MAPPING
            by_direction["tpdo" if sent else "rpdo"].add(described.default)
    return {
        direction: frozenset(entries) for direction, entries in by_direction.items()
    }


def own_field(description: DeviceDescription, entry: int) -> MappedField:
    """Return the field of a default mapping entry; an unknown object becomes a gap."""
    number = entry >> 16, entry >> 8 & 0xFF
    described = description.by_number.get(number)
    if described is None:
        return MappedField(None, "octets", entry & 0xFF)
    return MappedField(number, described.kind, entry & 0xFF)


def _fits(kind: Kind, bits: int) -> bool:
    if kind == "bool":
        return bits in (1, 8)
    if kind in KIND_BITS:
        return bits == KIND_BITS[kind]
    return 0 < bits <= MAX_BITS and bits % 8 == 0


def _check_granularity(description: DeviceDescription, bits: int) -> None:
    if not description.granularity or bits % description.granularity:
        raise SdoAbort(sdo.NOT_MAPPABLE)


class Mapping:
    """The fields of a PDO. Raises SdoAbort if they are too long."""

    def __init__(self, fields: Sequence[MappedField] = ()) -> None:
        self.fields = tuple(fields)
        self.bits = sum(field.bits for field in fields)
        if self.bits > MAX_BITS:
            raise SdoAbort(sdo.MAPPING_TOO_LONG)
        # Fields of whole octets are joined and sliced instead of shifted.
        self._whole = all(map(_is_whole, self.fields))

    @cached_property
    def _places(self) -> list[tuple[ObjectNumber, slice]]:
        """The octets of each object, if all fields are whole octets."""
        places, offset = [], 0
        for field in self.fields:
            end = offset + field.bits // 8
            if field.number is not None:
                places.append((field.number, slice(offset, end)))
            offset = end
        return places

    @property
    def size(self) -> int:
        """Length of the PDO in octets."""
        return (self.bits + 7) // 8

    @cached_property
    def numbers(self) -> frozenset[ObjectNumber]:
        """The mapped objects."""
        return frozenset(f.number for f in self.fields if f.number is not None)

    def pack(self, octets: Callable[[ObjectNumber], bytes]) -> bytes:
        """Pack the data; `octets` returns the value of an object."""
        if self._whole:
            return b"".join([octets(f.number) for f in self.fields if f.number])
        raw = offset = 0
        for field in self.fields:
            if field.number is not None:
                signed = field.kind in SIGNED_KINDS
                value = int.from_bytes(octets(field.number), "little", signed=signed)
                raw |= (value & (1 << field.bits) - 1) << offset
            offset += field.bits
        return raw.to_bytes(self.size, "little")

    def unpack(self, data: bytes) -> Iterable[tuple[ObjectNumber, bytes | None]]:
        """Unpack at least `size` octets; the value is None if the object's type is too small."""
        if self._whole:
            return [(number, data[place]) for number, place in self._places]
        return self._shifted(data)

    def _shifted(self, data: bytes) -> Iterator[tuple[ObjectNumber, bytes | None]]:
        raw = int.from_bytes(data[: self.size], "little")
        for field in self.fields:
            if field.number is not None:
                value = raw & (1 << field.bits) - 1
                yield field.number, _octets(field, value)
            raw >>= field.bits


def _is_whole(field: MappedField) -> bool:
    """Return whether a field consists of all octets of an object."""
    size = values.size(field.kind)
    return field.number is not None and field.bits == 8 * (size or 0)


def _octets(field: MappedField, raw: int) -> bytes | None:
    if 8 * (values.size(field.kind) or 0) == field.bits:
        return raw.to_bytes(field.bits // 8, "little")
    try:
        value = values.from_bits(field.kind, raw, field.bits)
        return values.encode(field.kind, value)
    except values.ObjectValueError:
        return None
