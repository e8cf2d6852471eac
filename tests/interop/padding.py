"""Positions of padding in a CDR body."""

from __future__ import annotations

from rtgen.runtime.marshalling.descriptors import Descriptor, StringDescriptor
from rtgen.runtime.marshalling.dynamic.reader import Reader


class _Padding(Reader):
    """Walks octets and records the positions of padding."""

    def __init__(self, data: bytes, little_endian: bool) -> None:
        super().__init__(data, little_endian, walking=True)
        self.places: list[int] = []

    def _take(self, size: int, align: int) -> bytes:
        before = self.offset
        octets = super()._take(size, align)
        self.places.extend(range(before, self.offset - size))
        return octets


def padding(
    descriptor: Descriptor,
    octets: bytes,
    little_endian: bool,
    *,
    identified: bool = False,
) -> list[int]:
    """Return the offsets of the padding in a body; `identified`: a repository id precedes it."""
    scan = _Padding(octets, little_endian)
    if identified:
        scan.value(StringDescriptor())
    scan.value(descriptor)
    scan.end()
    return scan.places


def masked(octets: bytes, places: list[int]) -> bytes:
    """Return the octets with zeros at those positions."""
    cleared = bytearray(octets)
    for place in places:
        cleared[place] = 0
    return bytes(cleared)
