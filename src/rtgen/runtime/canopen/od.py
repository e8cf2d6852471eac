"""The object dictionary of a device: values with access, lengths and limits (CiA 301, 7.4)."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from typing import Final, TypeAlias

from rtgen.runtime.canopen import sdo, values
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    ObjectDescription,
    ObjectNumber,
    ObjectValue,
)
from rtgen.runtime.canopen.sdo import SdoAbort
from rtgen.runtime.canopen.values import ObjectValueError

log = logging.getLogger("rtgen.runtime")

WriteHook: TypeAlias = Callable[[ObjectValue], None]
"""Gets a value that came over the bus, before it is taken; raises SdoAbort to refuse it."""

ReadHook: TypeAlias = Callable[[], ObjectValue]
"""Gives the value that an object has now; raises SdoAbort if there is none."""

Guard: TypeAlias = Callable[[ObjectNumber, ObjectValue], None]
"""As a WriteHook, for all of an index."""

COMMUNICATION: Final = range(0x1000, 0x2000)
"""The communication profile area, which reset communication sets back, too."""


class DeviceDictionary:
    """The values of a device's variables.

    SDO comes through `read`, `writable_size` and `write`, PDOs through `octets` and `take`, the
    device itself through `get` and `set`. `changed` is told of every value that is another one now.
    """

    def __init__(
        self, description: DeviceDescription, changed: Callable[[ObjectNumber], None]
    ) -> None:
        self.description = description
        self._objects = description.by_number
        self._indices = frozenset(index for index, _ in self._objects)
        self._octets: dict[ObjectNumber, bytes] = {}
        self._initial: dict[ObjectNumber, bytes] = {}
        self._changed = changed
        self._guards: dict[int, Guard] = {}
        self._commands: dict[int, Guard] = {}
        self._read_guards: dict[int, Callable[[ObjectNumber], None]] = {}
        self._write_hooks: dict[ObjectNumber, WriteHook] = {}
        self._read_hooks: dict[ObjectNumber, ReadHook] = {}

    def __contains__(self, number: ObjectNumber) -> bool:
        return number in self._objects

    def describe(self, number: ObjectNumber) -> ObjectDescription:
        """What a variable is. Raises SdoAbort if there is none."""
        found = self._objects.get(number)
        if found is None:
            known = number[0] in self._indices
            raise SdoAbort(sdo.NO_SUBINDEX if known else sdo.NO_OBJECT)
        return found

    def subindices(self, index: int) -> list[int]:
        """The sub-indices of an index, ascending."""
        return sorted(sub for found, sub in self._objects if found == index)

    # Hooks.

    def on_write(self, number: ObjectNumber, hook: WriteHook) -> None:
        """Sets the hook for values that come by SDO or PDO. Raises KeyError for no variable."""
        self._write_hooks[self._known(number)] = hook

    def on_read(self, number: ObjectNumber, hook: ReadHook) -> None:
        """Sets where a value comes from whenever it is asked for. Raises KeyError, as above."""
        self._read_hooks[self._known(number)] = hook

    def guard(self, indices: Iterable[int], guard: Guard) -> None:
        """Sets what says whether SDO may write to these indices."""
        self._guards.update(dict.fromkeys(indices, guard))

    def command(self, indices: Iterable[int], action: Guard) -> None:
        """Sets what a write to these indices does; the objects keep their values."""
        self._commands.update(dict.fromkeys(indices, action))

    def guard_reading(self, index: int, guard: Callable[[ObjectNumber], None]) -> None:
        """Sets what says whether SDO may read an index."""
        self._read_guards[index] = guard

    # SDO.

    def read(self, index: int, subindex: int) -> bytes:
        """See `sdo_server.ObjectDictionary`."""
        number = index, subindex
        if not self.describe(number).readable:
            raise SdoAbort(sdo.WRITE_ONLY)
        if index in self._read_guards:
            self._read_guards[index](number)
        return self.octets(number)

    def writable_size(self, index: int, subindex: int) -> int:
        """See `sdo_server.ObjectDictionary`."""
        described = self.describe((index, subindex))
        if not described.writable:
            raise SdoAbort(sdo.READ_ONLY)
        wanted = values.size(described.kind)
        return sdo.MAX_SIZE if wanted is None else wanted

    def write(self, index: int, subindex: int, value: bytes) -> None:
        """See `sdo_server.ObjectDictionary`."""
        number = index, subindex
        if not self.describe(number).writable:
            raise SdoAbort(sdo.READ_ONLY)
        if index in self._commands:
            self._commands[index](number, self._decoded(number, value))
        else:
            self._take(number, value, self._guards.get(index))

    # PDO.

    def octets(self, number: ObjectNumber) -> bytes:
        """The value of a variable that exists. Raises SdoAbort if its read hook does."""
        hook = self._read_hooks.get(number)
        if hook is not None:
            try:
                value = hook()
                octets = values.encode(self._objects[number].kind, value)
            except ObjectValueError as error:
                log.warning("%04X:%02X: %s", *number, error)
                raise SdoAbort(error.code) from None
            except SdoAbort:
                raise
            except Exception:
                log.exception("read hook of %04X:%02X", *number)
                raise SdoAbort(sdo.GENERAL_ERROR) from None
            # Looking is no event: a TPDO would never end to be sent.
            self._octets[number] = octets
        return self._octets[number]

    def last(self, number: ObjectNumber) -> bytes:
        """The value as it was last known, whatever a read hook says."""
        return self._octets[number]

    def take(self, number: ObjectNumber, octets: bytes) -> None:
        """Takes a value that a PDO brought. Raises SdoAbort if it cannot be had."""
        self._take(number, octets, None)

    def _take(self, number: ObjectNumber, octets: bytes, guard: Guard | None) -> None:
        value = self._decoded(number, octets)
        if guard is not None:
            guard(number, value)
        hook = self._write_hooks.get(number)
        if hook is not None:
            try:
                hook(value)
            except SdoAbort:
                raise
            except Exception:
                log.exception("write hook of %04X:%02X", *number)
                raise SdoAbort(sdo.GENERAL_ERROR) from None
        self.put(number, octets)

    def _decoded(self, number: ObjectNumber, octets: bytes) -> ObjectValue:
        described = self._objects[number]
        try:
            value = values.decode(described.kind, octets)
            return values.checked(described.kind, value, described.low, described.high)
        except ObjectValueError as error:
            raise SdoAbort(error.code) from None

    # The device itself.

    def get(self, number: ObjectNumber) -> ObjectValue:
        """A value. Raises KeyError for no variable, SdoAbort if its read hook does."""
        described = self._objects[self._known(number)]
        return values.decode(described.kind, self.octets(number))

    def number(self, number: ObjectNumber, absent: int = 0) -> int:
        """An integer value as it was last known; `absent` where there is no such variable."""
        if number not in self._objects:
            return absent
        return int.from_bytes(self._octets[number], "little")

    def set(self, number: ObjectNumber, value: ObjectValue) -> None:
        """Sets a value, whatever its access; hooks are not called.

        Raises KeyError for no variable, ObjectValueError for a value that it cannot have.
        """
        described = self._objects[self._known(number)]
        values.checked(described.kind, value, described.low, described.high)
        self.put(number, values.encode(described.kind, value))

    def put(self, number: ObjectNumber, octets: bytes) -> None:
        """Sets a value as it is on the wire, without a check."""
        if self._octets[number] != octets:
            self._octets[number] = octets
            self._changed(number)

    # Resets.

    def load(self, node_id: int, indices: range = range(0x10000)) -> None:
        """Gives the variables of these indices their defaults; nobody is told."""
        for number, described in self._objects.items():
            if number[0] in indices:
                self.preset(number, described.initial(node_id))

    def preset(self, number: ObjectNumber, value: ObjectValue | None) -> None:
        """Gives a variable another default; one that it cannot have counts as none."""
        kind = self._objects[number].kind
        try:
            octets = values.encode(kind, values.zero(kind) if value is None else value)
        except ObjectValueError:
            octets = values.encode(kind, values.zero(kind))
        self._octets[number] = self._initial[number] = octets

    def restore(self, number: ObjectNumber, octets: bytes) -> None:
        """Sets a stored value after `load`."""
        if number in self._objects:
            self._octets[number] = octets

    def altered(self, indices: range) -> dict[ObjectNumber, bytes]:
        """The writable values of these indices that are not their defaults."""
        return {
            number: self._octets[number]
            for number, described in self._objects.items()
            if number[0] in indices
            and described.writable
            and self._octets[number] != self._initial[number]
        }

    def _known(self, number: ObjectNumber) -> ObjectNumber:
        if number not in self._objects:
            name = self.description.name
            raise KeyError(f"{name} has no object {number[0]:04X}h:{number[1]:02X}")
        return number
