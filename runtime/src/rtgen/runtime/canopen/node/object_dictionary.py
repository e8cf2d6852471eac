"""The object dictionary of a device (CiA 301, 7.4): values with access, lengths and limits."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from typing import Final, TypeAlias

from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    ObjectDescription,
    ObjectNumber,
    ObjectValue,
)
from rtgen.runtime.canopen.values import ObjectValueError
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import CobId
from rtgen.runtime.canopen.wire.sdo import SdoAbort

log = logging.getLogger("rtgen.runtime")

WriteHook: TypeAlias = Callable[[ObjectValue], None]
"""Function called with a received value before it is stored; raises SdoAbort to reject it."""

ReadHook: TypeAlias = Callable[[], ObjectValue]
"""Function that returns the current value of an object; raises SdoAbort without one."""

Guard: TypeAlias = Callable[[ObjectNumber, ObjectValue], None]
"""A WriteHook for all sub-indices of an index."""

COMMUNICATION: Final = range(0x1000, 0x2000)
"""The communication profile area, which reset communication also resets."""


def check_cob_id(old: int, new: ObjectValue) -> None:
    """Check a write to a COB-ID with a valid bit (CiA 301, 7.5.2).

    Raises SdoAbort for a change of one that is valid, and for a restricted identifier.
    """
    before, after = CobId(old), CobId(int(new))
    moves = (before.can_id, before.extended) != (after.can_id, after.extended)
    if before.valid and not after.bit31 and moves:
        raise SdoAbort(sdo.VALUE_INVALID)
    if not after.bit31 and not after.configurable:
        raise SdoAbort(sdo.VALUE_INVALID)


class DeviceDictionary:
    """The values of a device's objects.

    SDO uses `read`, `writable_size` and `write`, PDOs use `octets` and `take`, the device itself
    `get` and `set`. `changed` is called for every object whose value has changed.
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
        self._plain = {
            number: values.size(described.kind)
            for number, described in self._objects.items()
            if values.limits(described.kind) and not described.limited
        }
        """Sizes of objects that accept any octets, without a check."""

    def __contains__(self, number: ObjectNumber) -> bool:
        return number in self._objects

    def describe(self, number: ObjectNumber) -> ObjectDescription:
        """Return the description of an object. Raises SdoAbort if it does not exist."""
        description = self._objects.get(number)
        if description is None:
            has_index = number[0] in self._indices
            raise SdoAbort(sdo.NO_SUBINDEX if has_index else sdo.NO_OBJECT)
        return description

    def subindices(self, index: int) -> list[int]:
        """Return the sub-indices of an index, ascending."""
        return sorted(
            sub for index_of_object, sub in self._objects if index_of_object == index
        )

    # Hooks

    def on_write(self, number: ObjectNumber, hook: WriteHook) -> None:
        """Set the hook for values received by SDO or PDO. Raises KeyError for an unknown object."""
        self._description_of(number)
        self._write_hooks[number] = hook
        self._plain.pop(number, None)

    def on_read(self, number: ObjectNumber, hook: ReadHook) -> None:
        """Set a source for an object's value, called on each access. Raises KeyError, as above."""
        self._description_of(number)
        self._read_hooks[number] = hook

    def guard(self, indices: Iterable[int], guard: Guard) -> None:
        """Set a check for SDO writes to these indices."""
        self._guards.update(dict.fromkeys(indices, guard))

    def command(self, indices: Iterable[int], action: Guard) -> None:
        """Set an action for SDO writes to these indices; the objects keep their values."""
        self._commands.update(dict.fromkeys(indices, action))

    def guard_reading(self, index: int, guard: Callable[[ObjectNumber], None]) -> None:
        """Set a check for SDO reads of an index."""
        self._read_guards[index] = guard

    # SDO

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
        expected = values.size(described.kind)
        return sdo.MAX_SIZE if expected is None else expected

    def write(self, index: int, subindex: int, value: bytes) -> None:
        """See `sdo_server.ObjectDictionary`."""
        number = index, subindex
        if not self.describe(number).writable:
            raise SdoAbort(sdo.READ_ONLY)
        if index in self._commands:
            self._commands[index](number, self._decoded(number, value))
        else:
            self._take(number, value, self._guards.get(index))

    # PDO

    def octets(self, number: ObjectNumber) -> bytes:
        """Return the value of an existing object. Raises SdoAbort if its read hook does."""
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
            # Reading is not an event; otherwise a TPDO would trigger itself.
            self._octets[number] = octets
        return self._octets[number]

    def last(self, number: ObjectNumber) -> bytes:
        """Return the last stored value, without calling a read hook."""
        return self._octets[number]

    def take(self, number: ObjectNumber, octets: bytes) -> None:
        """Store a value received by a PDO. Raises SdoAbort for an invalid value."""
        if self._plain.get(number) == len(octets):
            self.put(number, octets)
        else:
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
            if described.limited:
                values.checked(described.kind, value, described.low, described.high)
        except ObjectValueError as error:
            raise SdoAbort(error.code) from None
        return value

    # Device

    def get(self, number: ObjectNumber) -> ObjectValue:
        """Return a value. Raises KeyError for an unknown object, SdoAbort from its read hook."""
        return values.decode(self._description_of(number).kind, self.octets(number))

    def number(self, number: ObjectNumber, absent: int = 0) -> int:
        """Return an integer object's last stored value; `absent` if the object does not exist."""
        if number not in self._objects:
            return absent
        return int.from_bytes(self._octets[number], "little")

    def set(self, number: ObjectNumber, value: ObjectValue) -> None:
        """Set a value regardless of its access type; hooks are not called.

        Raises KeyError for an unknown object, ObjectValueError for an invalid value.
        """
        described = self._description_of(number)
        if described.limited:
            values.checked(described.kind, value, described.low, described.high)
        self.put(number, values.encode(described.kind, value))

    def put(self, number: ObjectNumber, octets: bytes) -> None:
        """Set the octets of a value, without a check."""
        if self._octets[number] != octets:
            self._octets[number] = octets
            self._changed(number)

    # Resets

    def load(self, node_id: int, indices: range = range(0x10000)) -> None:
        """Reset these objects to their defaults without calling `changed`."""
        for number, described in self._objects.items():
            if number[0] in indices:
                self.preset(number, described.initial(node_id))

    def preset(self, number: ObjectNumber, value: ObjectValue | None) -> None:
        """Replace the default of an object; an invalid one counts as none."""
        described = self._objects[number]
        kind = described.kind
        start = values.zero(kind) if described.start is None else described.start
        try:
            octets = values.encode(kind, start if value is None else value)
        except ObjectValueError:
            octets = values.encode(kind, start)
        self._octets[number] = self._initial[number] = octets

    def restore(self, number: ObjectNumber, octets: bytes) -> None:
        """Restore a stored value, after `load`."""
        if number in self._objects:
            self._octets[number] = octets

    def altered(self, indices: range) -> dict[ObjectNumber, bytes]:
        """Return the writable values of these indices that differ from their defaults."""
        return {
            number: self._octets[number]
            for number, described in self._objects.items()
            if number[0] in indices
            and described.writable
            and self._octets[number] != self._initial[number]
        }

    def _description_of(self, number: ObjectNumber) -> ObjectDescription:
        description = self._objects.get(number)
        if description is None:
            name = self.description.name
            raise KeyError(f"{name} has no object {number[0]:04X}h:{number[1]:02X}")
        return description
