"""Layout of a PDO's data (CiA 301, 7.3.3 and 7.5.2.36): slots read by one `struct` call.

Entries follow each other from bit 0 of the first octet, without gaps, little endian. A field that
starts and ends at an octet boundary is a slot of its own; other fields share a slot between octet
boundaries, and are extracted by shifts. Widths without a `struct` letter are read in parts, the
last of which has the sign: 24 bits are `Hb`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import Enum, auto

import msgspec

from rtgen.compiler.model.canopen import SIGNED, UNSIGNED, DataType

MAX_BITS = 64


class PdoLayoutError(ValueError):
    """A mapping without a layout; the message is the reason."""


class Kind(Enum):
    """The interpretation of a field's bits; times are one unsigned number."""

    BOOLEAN = auto()
    SIGNED = auto()
    UNSIGNED = auto()
    REAL = auto()
    CHARACTER = auto()
    TEXT = auto()
    OCTETS = auto()


class Mapped(msgspec.Struct, frozen=True):
    """An entry of a mapping: the field's name (None for a gap), data type and length."""

    name: str | None
    data_type: int
    bits: int


class PdoField(msgspec.Struct, frozen=True):
    """A field: `shift` is its first bit in the slot."""

    name: str
    kind: Kind
    bits: int
    shift: int = 0


class Part(msgspec.Struct, frozen=True):
    """A letter of the struct format and the bits that it takes."""

    letter: str
    bits: int


class Slot(msgspec.Struct, frozen=True):
    """Octets that are read together: the parts, low ones first, and the fields in them.

    `whole`: one field fills the slot, without shift and mask.
    """

    parts: tuple[Part, ...]
    fields: tuple[PdoField, ...]
    whole: bool


class PdoLayout(msgspec.Struct, frozen=True):
    """A PDO's data: its slots in order, and its size in octets."""

    slots: tuple[Slot, ...]
    size: int

    @property
    def format(self) -> str:
        """The format of the one `struct.Struct`."""
        return "<" + "".join(part.letter for slot in self.slots for part in slot.parts)

    @property
    def fields(self) -> tuple[PdoField, ...]:
        """The fields in order."""
        return tuple(field for slot in self.slots for field in slot.fields)


def layout(mapped: Sequence[Mapped]) -> PdoLayout:
    """Return the layout of a mapping. Raises PdoLayoutError."""
    bits = sum(entry.bits for entry in mapped)
    if bits > MAX_BITS:
        raise PdoLayoutError(f"{bits} bits; a PDO has up to {MAX_BITS}")
    slots: list[Slot] = []
    shared: list[PdoField] = []
    filled = 0
    for entry in mapped:
        if entry.bits < 1:
            raise PdoLayoutError(f"{entry.name or 'a gap'} has no bits")
        field = None
        if entry.name is not None:
            field = PdoField(entry.name, _kind(entry), entry.bits, filled)
        if not filled and entry.bits % 8 == 0:
            slots.append(_slot(entry.bits // 8, field))
            continue
        if field is not None:
            if field.kind in (Kind.TEXT, Kind.OCTETS):
                raise PdoLayoutError(f"{field.name} does not begin and end at an octet")
            shared.append(field)
        filled += entry.bits
        if filled % 8 == 0:
            slots.append(_shared(shared, filled // 8))
            shared, filled = [], 0
    if filled:
        slots.append(_shared(shared, (filled + 7) // 8))
    return PdoLayout(tuple(slots), (bits + 7) // 8)


def _kind(entry: Mapped) -> Kind:
    code = entry.data_type
    if code in SIGNED:
        return Kind.SIGNED
    if code in UNSIGNED or code in (DataType.TIME_OF_DAY, DataType.TIME_DIFFERENCE):
        return Kind.UNSIGNED
    if code == DataType.BOOLEAN:
        return Kind.BOOLEAN
    if code in (DataType.REAL32, DataType.REAL64):
        bits = 32 if code == DataType.REAL32 else 64
        if entry.bits != bits:
            raise PdoLayoutError(f"{entry.name} has {entry.bits} bits, not {bits}")
        return Kind.REAL
    if code == DataType.VISIBLE_CHAR:
        if entry.bits != 8:
            raise PdoLayoutError(f"{entry.name} has {entry.bits} bits, not 8")
        return Kind.CHARACTER
    return Kind.TEXT if code == DataType.VISIBLE_STRING else Kind.OCTETS


def _slot(size: int, field: PdoField | None) -> Slot:
    """Return the slot of a field, or of a gap, at octet boundaries."""
    if field is None:
        return _gap(size)
    parts: tuple[Part, ...]
    if field.kind is Kind.REAL:
        parts = (Part("f" if size == 4 else "d", field.bits),)
    elif field.kind in (Kind.TEXT, Kind.OCTETS):
        parts = (Part(f"{size}s", field.bits),)
    else:
        parts = tuple(_parts(size, signed=field.kind is Kind.SIGNED))
    return Slot(parts, (field,), whole=True)


def _shared(fields: Sequence[PdoField], size: int) -> Slot:
    if not fields:
        return _gap(size)
    return Slot(tuple(_parts(size, signed=False)), tuple(fields), whole=False)


def _gap(size: int) -> Slot:
    return Slot((Part(f"{size}x", 8 * size),), (), whole=True)


def _parts(size: int, signed: bool) -> Iterator[Part]:
    """Yield letters for an integer of `size` octets, low ones first; the last has the sign."""
    for width, letter in ((8, "Q"), (4, "I"), (2, "H"), (1, "B")):
        if size >= width:
            size -= width
            last = signed and size == 0
            yield Part(letter.lower() if last else letter, 8 * width)
