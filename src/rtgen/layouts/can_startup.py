"""SDO writes that configure a node before it is started, in an order safe for all devices.

Communication comes first, the node's heartbeat (1017h) before those that it consumes (1016h), then
the PDOs (CiA 301, 7.5.2.36): a PDO that changes is disabled (bit 31 of its COB-ID), its mapping is
cleared, written and counted, and finally the PDO is enabled. The other objects follow by index.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator

import msgspec
from msgspec.structs import replace

from rtgen.layouts.can_values import CanValueError, octets
from rtgen.model.can_bus import BusNode, DeviceKind
from rtgen.model.canopen import (
    INVALID,
    DataType,
    Device,
    NodeRelative,
    Pdo,
    Variable,
    resolved,
)

_CONSUMER, _PRODUCER = 0x1016, 0x1017
_STORE = (0x1010, 0x1011)
_COB_ID = DataType.UNSIGNED32
_PROFILES = 0x2000
_NOT_ON_DOWNLOAD = 1 << 0
"""Flag of an object (CiA 306, 4.6.3.2) that excludes it from configuration writes."""


class StartWrite(msgspec.Struct, frozen=True):
    """A write of a value; `why` is a short reason for reports.

    `verify`: the value can be read back; `relative`: the node-id is added to the value.
    """

    variable: Variable
    value: bytes
    why: str = ""
    verify: bool = True
    relative: bool = False


def start_up(node: BusNode) -> tuple[StartWrite, ...]:
    """Return the writes to a node: the bus file's values, and others that differ from defaults.

    The period of its heartbeat is always written.

    Raises CanValueError for a value that cannot be encoded.
    """
    asked = {number for number, _ in node.values}
    # The manager depends on the heartbeat, so its period is written even if it is the default.
    beats = {(v.index, v.subindex) for v in node.device.variables if _beats(v)}
    return tuple(_StartUp(node.device, node.id, asked | beats).writes())


def configuration(kind: DeviceKind) -> tuple[StartWrite, ...]:
    """Return the writes of a description's own configuration, with the mappings of the kind.

    For a node outside of networks. Values that cannot be encoded are skipped: in a network they are
    EDS0805.
    """
    device = configured(kind)
    writable = tuple(
        replace(o, variables=tuple(map(_writable, o.variables))) for o in device.objects
    )
    try:
        return tuple(_StartUp(replace(device, objects=writable), 0, set()).writes())
    except CanValueError:
        # A mapping or COB-ID that cannot be encoded: its PDO has no port either.
        return ()


def _writable(variable: Variable) -> Variable:
    """Return the variable, without its configured value if that cannot be encoded."""
    value = resolved(variable.value, 0)
    try:
        if value is not None:
            octets(variable.data_type, value)
    except CanValueError:
        return replace(variable, value=None)
    return variable


def configured(kind: DeviceKind) -> Device:
    """Return the device configured by its description, with the mappings of its kind."""
    own, common = kind.described or kind.device, kind.device
    mappings = {pdo.mapping for pdo in common.pdos}
    by_index = {o.index: o for o in common.objects if o.index in mappings}
    entries = {(p.direction, p.number): p.entries for p in common.pdos}
    return replace(
        own,
        objects=tuple(by_index.get(o.index, o) for o in own.objects),
        pdos=tuple(
            replace(pdo, entries=entries[pdo.direction, pdo.number]) for pdo in own.pdos
        ),
    )


def _beats(variable: Variable) -> bool:
    return variable.index == _PRODUCER and bool(variable.current)


class _StartUp:
    """Writes of a node; `asked` are the variables written even if equal to the default."""

    def __init__(
        self, device: Device, node_id: int, asked: set[tuple[int, int]]
    ) -> None:
        self._id = node_id
        self._device = device
        self._changed = {
            (v.index, v.subindex): v
            for v in device.variables
            if self._differs(v, (v.index, v.subindex) in asked)
        }

    def _differs(self, variable: Variable, asked: bool) -> bool:
        if not variable.access.writable or variable.current is None:
            return False
        if asked:
            return True
        default, value = (
            resolved(each, self._id) for each in (variable.default, variable.value)
        )
        wanted = value is not None and value != default
        return wanted and not variable.flags & _NOT_ON_DOWNLOAD

    def writes(self) -> Iterator[StartWrite]:
        """Yield all writes, in order."""
        of_pdos = {
            i for pdo in self._device.pdos for i in (pdo.communication, pdo.mapping)
        }
        plain = [v for v in self._changed.values() if v.index not in of_pdos]
        plain.sort(key=_order)
        for variable in plain:
            if variable.index < _PROFILES and variable.index not in _STORE:
                yield self._write(variable)
        for pdo in self._device.pdos:
            yield from self._pdo(pdo)
        for variable in plain:
            if variable.index >= _PROFILES:
                yield self._write(variable)
        for variable in plain:
            if variable.index in _STORE:
                yield self._write(variable)

    def _pdo(self, pdo: Pdo) -> Iterator[StartWrite]:
        index = pdo.communication
        parameters = self._of(index)
        mapping = self._of(pdo.mapping)
        if not (parameters or mapping):
            return
        name = f"{pdo.direction.upper()} {pdo.number}"
        cob_id = self._device.find(index, 1)
        configured = None if cob_id is None else resolved(cob_id.current, self._id)
        switched = (
            cob_id is not None
            and isinstance(configured, int)
            and cob_id.access.writable
        )
        if switched:
            assert cob_id is not None
            assert isinstance(configured, int)
            off = replace(
                self._write(cob_id), value=octets(_COB_ID, configured | INVALID)
            )
            yield replace(off, why=f"{name} off")
        for variable in parameters:
            if variable is not cob_id:
                yield self._write(variable)
        yield from self._mapping(pdo.mapping, name, bool(mapping))
        if switched and isinstance(configured, int) and not configured & INVALID:
            assert cob_id is not None
            yield self._write(cob_id, f"{name} on")

    def _mapping(self, index: int, name: str, changed: bool) -> Iterator[StartWrite]:
        count = self._device.find(index, 0)
        if not changed or count is None:
            return
        counted = count.access.writable
        if counted:
            yield self._write(count, f"{name} maps nothing", 0)
        used = count.current if isinstance(count.current, int) else 0
        for subindex in range(1, used + 1):
            entry = self._device.find(index, subindex)
            if entry is None or entry.current is None or not entry.access.writable:
                continue
            yield self._write(entry)
        if counted and used:
            yield self._write(count, f"{name} maps {used}")

    def _of(self, index: int) -> list[Variable]:
        """Return the variables of an object whose values differ from the defaults."""
        return [v for (of, _), v in self._changed.items() if of == index]

    def _write(
        self, variable: Variable, why: str = "", value: int | None = None
    ) -> StartWrite:
        number = resolved(variable.current, self._id) if value is None else value
        assert number is not None
        verify = variable.access.readable and variable.index not in _STORE
        try:
            written = octets(variable.data_type, number)
        except CanValueError as error:
            raise CanValueError(f"{variable.name}: {error}") from None
        relative = value is None and isinstance(variable.current, NodeRelative)
        return StartWrite(variable, written, why, verify, relative)


def _order(variable: Variable) -> tuple[float, int]:
    """Return the sort key: by index, except that the heartbeat precedes the consumed ones."""
    index = _CONSUMER - 0.5 if variable.index == _PRODUCER else variable.index
    return index, variable.subindex


def concise_dcf(writes: Iterable[StartWrite]) -> bytes:
    """Encode the writes as object 1F22h (CiA 302-3): their number, then each of them."""
    entries = list(writes)
    parts = [struct.pack("<I", len(entries))]
    for write in entries:
        variable = write.variable
        head = struct.pack("<HBI", variable.index, variable.subindex, len(write.value))
        parts += [head, write.value]
    return b"".join(parts)
