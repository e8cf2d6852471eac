"""Stores and restores parameters (CiA 301, objects 1010h and 1011h)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.node.object_dictionary import COMMUNICATION, DeviceDictionary
from rtgen.runtime.canopen.wire.sdo import HARDWARE_ERROR, SdoAbort

STORE: Final = 0x1010
RESTORE: Final = 0x1011
SAVE: Final = int.from_bytes(b"save", "little")
LOAD: Final = int.from_bytes(b"load", "little")

_NOT_STORED: Final = 0x08000020
_ALL: Final = range(0x1000, 0x10000)
_GROUPS: Final = {1: _ALL, 2: COMMUNICATION, 3: range(0x6000, 0xA000)}
_MANUFACTURER: Final = range(0x2000, 0x6000)
"""Objects of sub-indices 4 and higher."""
_NEVER_STORED: Final = frozenset((0x1001, 0x1003, STORE, RESTORE))


class ParameterStore:
    """The stored values that differ from the defaults.

    Restored defaults take effect at the next reset, as stored values do. They exist as long as the
    store, unless `keep` persists them: it is called with all stored values when they change, and
    raises OSError on failure, which rejects the command.
    """

    def __init__(self, dictionary: DeviceDictionary) -> None:
        self._dictionary = dictionary
        self.values: dict[ObjectNumber, bytes] = {}
        self.keep: Callable[[Mapping[ObjectNumber, bytes]], None] | None = None
        dictionary.command((STORE, RESTORE), self._obey)

    def apply(self, indices: range) -> None:
        """Apply the stored values of these indices."""
        for number, octets in self.values.items():
            if number[0] in indices:
                self._dictionary.restore(number, octets)

    def _obey(self, number: ObjectNumber, value: ObjectValue) -> None:
        index, subindex = number
        if value != (SAVE if index == STORE else LOAD):
            raise SdoAbort(_NOT_STORED)
        group = _GROUPS.get(subindex, _MANUFACTURER)
        stored = {n: v for n, v in self.values.items() if n[0] not in group}
        if index == STORE:
            altered = self._dictionary.altered(group)
            stored |= {n: v for n, v in altered.items() if n[0] not in _NEVER_STORED}
        if self.keep is not None:
            try:
                self.keep(stored)
            except OSError as error:
                raise SdoAbort(HARDWARE_ERROR) from error
        self.values = stored
