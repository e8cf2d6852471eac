"""SDO writes that configure a node before it is started, in the order of `facts.write_order`.

Communication comes first, then the PDOs, the other objects by index, and those that store.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping

import msgspec
from msgspec.structs import replace

from rtgen.compiler.layouts.can_values import CanValueError, octets
from rtgen.compiler.model.can_bus import BusNode, DeviceKind
from rtgen.compiler.model.canopen import (
    INVALID,
    NO_RTR,
    DataType,
    Device,
    NodeRelative,
    Value,
    Variable,
    resolved,
)
from rtgen.facts import write_order
from rtgen.facts.cob_ids import configurable, is_stated, service_of
from rtgen.facts.write_order import How, Step

_PRODUCER = 0x1017
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
    beats = {v.number for v in node.device.variables if _beats(v)}
    return tuple(_of_node(node, asked | beats).writes())


def _of_node(node: BusNode, asked: set[tuple[int, int]]) -> _StartUp:
    own = node.kind.described or node.device
    configured = {
        v.number: v.value
        for v in own.variables
        if v.value is not None and v.value != v.default
    }
    return _StartUp(node.device, node.id, asked, configured)


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


def obstacles(node: BusNode) -> Iterator[tuple[Variable, str]]:
    """Yield the changes of a node's values that it may refuse in any order, with the reasons."""
    written = _of_node(node, {number for number, _ in node.values})
    for number, why in write_order.obstacles(written.changed, written):
        variable = node.device.find(*number)
        assert variable is not None
        yield variable, why


class _StartUp:
    """Writes of a node; `asked` are the variables written even if equal to the default.

    `configured` are those that its description configures: it may begin with these values, or with
    the defaults. It is the `Target` of the order of writes.
    """

    def __init__(
        self,
        device: Device,
        node_id: int,
        asked: set[tuple[int, int]],
        configured: Mapping[tuple[int, int], Value] | None = None,
    ) -> None:
        self._id = node_id
        self._configured = configured or {}
        self._device = device
        self.changed = {
            v.number for v in device.variables if self._differs(v, v.number in asked)
        }

    def _differs(self, variable: Variable, asked: bool) -> bool:
        if not variable.access.writable or variable.current is None:
            return False
        if asked:
            return True
        if variable.value is None or variable.flags & _NOT_ON_DOWNLOAD:
            return False
        default, value = (
            resolved(each, self._id)
            for each in (self._initial(variable), self._final(variable))
        )
        return value != default

    def writes(self) -> Iterator[StartWrite]:
        """Yield all writes, in order."""
        for step in write_order.steps(self.changed, self):
            yield self._write(step)

    def before(self, number: tuple[int, int]) -> int | None:
        """See `Target`."""
        variable = self._device.find(*number)
        return None if variable is None else self._number(self._initial(variable)) or 0

    def after(self, number: tuple[int, int]) -> int | None:
        """See `Target`."""
        variable = self._device.find(*number)
        return None if variable is None else self._number(self._final(variable)) or 0

    def states(self, number: tuple[int, int]) -> bool:
        """See `Target`."""
        variable = self._device.find(*number)
        default = (
            None if variable is None else resolved(variable.default, self._id or 1)
        )
        is_certain = service_of(number) is None or number not in self._configured
        return is_certain and is_stated(
            number, default if isinstance(default, int) else None
        )

    def configured(self, number: tuple[int, int]) -> int | None:
        """See `Target`."""
        return self._number(self._configured.get(number))

    def moves(self, number: tuple[int, int]) -> bool:
        """See `Target`."""
        variable = self._device.find(*number)
        if variable is None:
            return False
        return self._identifier(self._initial(variable)) != self._identifier(
            self._final(variable)
        )

    def writable(self, number: tuple[int, int]) -> bool:
        """See `Target`."""
        variable = self._device.find(*number)
        return variable is not None and variable.access.writable

    def _initial(self, variable: Variable) -> Value | None:
        return variable.initial(self._device.node_id)

    def _final(self, variable: Variable) -> Value | None:
        """Return the value in force afterwards; a service is off with an identifier it can have."""
        value = variable.in_force(self._device.node_id)
        service = service_of(variable.number)
        cob_id = self._number(value)
        if service is None or cob_id is None or value is None:
            return value
        if service.exists(cob_id) or configurable(cob_id):
            return value
        initial = self._initial(variable)
        before = self._number(initial)
        if initial is None or before is None or not configurable(before):
            return value
        return self._switched_off(variable, initial)

    def _number(self, value: Value | None) -> int | None:
        number = resolved(value, self._id)
        return number if isinstance(number, int) else None

    def _identifier(self, cob_id: Value | None) -> Value | None:
        """Return bits 0 to 29 of a COB-ID; a formula if no node-id is known."""
        if self._id:
            cob_id = resolved(cob_id, self._id)
        if isinstance(cob_id, NodeRelative):
            return NodeRelative(cob_id.offset & ~(INVALID | NO_RTR))
        return cob_id & ~(INVALID | NO_RTR) if isinstance(cob_id, int) else None

    def _write(self, step: Step) -> StartWrite:
        variable = self._device.find(*step.number)
        assert variable is not None
        data_type, value = variable.data_type, self._value(variable, step.how)
        if step.how in (How.OFF, How.OFF_BEFORE):
            data_type = DataType.UNSIGNED32
        number = resolved(value, self._id)
        assert number is not None
        verify = variable.access.readable and variable.index not in write_order.STORE
        try:
            written = octets(data_type, number)
        except CanValueError as error:
            raise CanValueError(f"{variable.name}: {error}") from None
        relative = isinstance(value, NodeRelative)
        return StartWrite(variable, written, step.why, verify, relative)

    def _value(self, variable: Variable, how: How) -> Value | None:
        match how:
            case How.ZERO:
                return 0
            case How.OFF:
                return self._switched_off(variable, self._final(variable))
            case How.OFF_BEFORE:
                return self._switched_off(variable, self._initial(variable))
        return self._final(variable)

    def _switched_off(self, variable: Variable, cob_id: Value | None) -> Value:
        service = service_of(variable.number)
        assert service is not None
        if isinstance(cob_id, NodeRelative):
            return NodeRelative(service.switched_off(cob_id.offset))
        assert isinstance(cob_id, int)
        return service.switched_off(cob_id)


def concise_dcf(writes: Iterable[StartWrite]) -> bytes:
    """Encode the writes as object 1F22h (CiA 302-3): their number, then each of them."""
    entries = list(writes)
    parts = [struct.pack("<I", len(entries))]
    for write in entries:
        variable = write.variable
        head = struct.pack("<HBI", variable.index, variable.subindex, len(write.value))
        parts += [head, write.value]
    return b"".join(parts)
