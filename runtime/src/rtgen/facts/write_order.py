"""The order in which the objects of a node are written, which every node accepts.

CiA 301, 7.5.2: an object that may only change while another one is off is written between the two
writes that switch it off and on. The manager, proxies, DCF and concise DCF have this order.

| object | changes while |
|---|---|
| 1005h, bits 0 to 29 | it produces no SYNC: bit 30 is 0 |
| 1012h, bits 0 to 29 | it neither consumes nor produces TIME: bits 31 and 30 are 0 |
| 1014h, 1028h, 1200h ff., 1280h ff., PDOs: bits 0 to 29 | it is not valid: bit 31 is 1 |
| 1019h | 1006h is 0 |
| 1016h: two entries for one node | never: entries that change places are 0 in between |
| 1200h ff., 1280h ff.: sub-index 3 | the SDO is not valid |
| PDO: types, times, mapping | the PDO is not valid; entries: sub-index 0 is 0 |
| COB-IDs that the description does not state, or configures | off: the node may have another |
| 1017h, 1016h | the heartbeat of the node precedes those that it consumes |
| 1020h | all others are written: they set it to 0 |
| 1010h, 1011h | all others are written |
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from enum import Enum, auto
from typing import Final, NamedTuple, Protocol

from rtgen.facts.canopen import (
    MAX_NODE_ID,
    PDOS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    TPDO_COMMUNICATION,
)
from rtgen.facts.cob_ids import (
    COB_ID_EMERGENCY,
    COB_ID_SYNC,
    SDO_CLIENTS,
    SDO_SERVERS,
    Number,
    Service,
    service_of,
)

MULTIPLEXED: Final = (0xFE, 0xFF)
"""Numbers of mapped objects that stand for a multiplexed PDO."""
STORE: Final = (0x1010, 0x1011)
CONSUMERS: Final = 0x1016
PERIOD: Final = (0x1006, 0)
OVERFLOW: Final = (0x1019, 0)

_WINDOW: Final = (0x1007, 0)
_PRODUCER: Final = (0x1017, 0)
_INHIBIT: Final = (0x1015, 0)
_VERIFY: Final = 0x1020
_PROFILES: Final = 0x2000
_MAX_ENTRIES: Final = 64
_TO_MAPPING: Final = RPDO_MAPPING - RPDO_COMMUNICATION
_SYNC_OBJECTS: Final = (COB_ID_SYNC, PERIOD, _WINDOW, OVERFLOW)
_WHILE_INVALID: Final = (2, 3, 6)
"""Sub-indices of communication parameters that nodes may refuse while the PDO is valid."""


class How(Enum):
    """The value of a write."""

    VALUE = auto()
    """The new value."""
    OFF = auto()
    """The new COB-ID, switched off."""
    OFF_BEFORE = auto()
    """The COB-ID from before, switched off."""
    ZERO = auto()


class Step(NamedTuple):
    """A write; `why` is a short reason for reports."""

    number: Number
    how: How
    why: str = ""


class Target(Protocol):
    """The node to be written, with its values before and afterwards."""

    def before(self, number: Number) -> int | None:
        """Return the value from before, 0 if it is unknown; None if there is no such object."""

    def after(self, number: Number) -> int | None:
        """Return the new value, or the unchanged one."""

    def states(self, number: Number) -> bool:
        """Return whether the COB-ID from before is stated; else the node may have another one."""

    def configured(self, number: Number) -> int | None:
        """Return the value that the description configures: the node may begin with it, too."""

    def moves(self, number: Number) -> bool:
        """Return whether the identifier of a COB-ID changes."""

    def writable(self, number: Number) -> bool:
        """Return whether SDO may write the object."""


class Obstacle(NamedTuple):
    """A write that a node may refuse: the object, and why."""

    number: Number
    why: str


def steps(changed: Collection[Number], node: Target) -> Iterator[Step]:
    """Yield the writes of the changed objects, and those that switch others off and on."""
    return _Order(frozenset(changed), node).steps()


def obstacles(changed: Collection[Number], node: Target) -> Iterator[Obstacle]:
    """Yield changes that no order makes acceptable to every node."""
    return _Order(frozenset(changed), node).obstacles()


def pdo_of(index: int) -> int | None:
    """Return the index of the communication parameter of a PDO's object; None for others."""
    for base in (RPDO_COMMUNICATION, TPDO_COMMUNICATION):
        for first in (base, base + _TO_MAPPING):
            if first <= index < first + PDOS:
                return base + index - first
    return None


def consumed_node(entry: int) -> int | None:
    """Return the node of an entry of 1016h; None for an entry that is not used."""
    node_id, time = entry >> 16 & 0xFF, entry & 0xFFFF
    return node_id if 1 <= node_id <= MAX_NODE_ID and time else None


class _Order:
    def __init__(self, changed: frozenset[Number], node: Target) -> None:
        self._changed = changed
        self._node = node

    def steps(self) -> Iterator[Step]:
        done: set[Number] = set()
        pdos = {i for n in self._changed if (i := pdo_of(n[0])) is not None}
        for number in sorted(self._changed, key=_rank):
            if pdos and _rank(number) > _PDOS:
                yield from self._pdos(pdos)
                pdos = set()
            if number not in done and pdo_of(number[0]) is None:
                unit, writes = self._unit(number)
                done |= unit
                yield from writes()
        yield from self._pdos(pdos)

    def _unit(self, number: Number) -> tuple[set[Number], Callable[[], Iterable[Step]]]:
        """Return the objects that are written together, and their writes."""
        index = number[0]
        if number in _SYNC_OBJECTS:
            return set(_SYNC_OBJECTS), self._sync
        if number in (COB_ID_EMERGENCY, _INHIBIT):
            return {COB_ID_EMERGENCY, _INHIBIT}, self._emergency
        if index == CONSUMERS:
            return set(self._of(index)), self._consumers
        if index in SDO_SERVERS or index in SDO_CLIENTS:
            return set(self._of(index)), lambda: self._sdo(index)
        service = service_of(number)
        if service is not None:
            return {number}, lambda: self._moved(number, service)
        return {number}, lambda: (Step(number, How.VALUE),)

    def _of(self, index: int) -> list[Number]:
        return sorted(number for number in self._changed if number[0] == index)

    def _values(self, numbers: Iterable[Number]) -> Iterator[Step]:
        for number in numbers:
            if number in self._changed:
                yield Step(number, How.VALUE)

    # COB-IDs

    def _off(
        self, number: Number, service: Service, *, always: bool = False
    ) -> Iterator[Step]:
        """Yield the writes before the new value, after which the identifier is the new one.

        `always`: also if it does not change.
        """
        node = self._node
        why = f"{service.name} off"
        moves = node.moves(number)
        before, after = node.before(number) or 0, node.after(number) or 0
        if moves and service.exists(before):
            yield Step(number, How.OFF_BEFORE, why)
            why = f"{service.name} still off"
        if always or ((moves or not node.states(number)) and service.exists(after)):
            yield Step(number, How.OFF, why)

    def _moved(
        self, number: Number, service: Service, between: Iterable[Number] = ()
    ) -> Iterator[Step]:
        """Yield the writes of a COB-ID, with others while it is off."""
        off = list(self._off(number, service))
        yield from off
        yield from self._values(between)
        exists = service.exists(self._node.after(number) or 0)
        yield Step(number, How.VALUE, f"{service.name} on" if off and exists else "")

    def _emergency(self) -> Iterator[Step]:
        if COB_ID_EMERGENCY not in self._changed:
            yield from self._values((_INHIBIT,))
            return
        service = service_of(COB_ID_EMERGENCY)
        assert service is not None
        yield from self._moved(COB_ID_EMERGENCY, service, (_INHIBIT,))

    def _sync(self) -> Iterator[Step]:
        service = service_of(COB_ID_SYNC)
        assert service is not None
        is_changed = COB_ID_SYNC in self._changed
        if is_changed:
            yield from self._off(COB_ID_SYNC, service)
        stops = OVERFLOW in self._changed and bool(self._node.before(PERIOD))
        stops = stops and self._node.writable(PERIOD)
        if stops:
            yield Step(PERIOD, How.ZERO, "SYNC counter off")
        yield from self._values((OVERFLOW,))
        if stops:
            if self._node.after(PERIOD):
                yield Step(PERIOD, How.VALUE)
        else:
            yield from self._values((PERIOD,))
        yield from self._values((_WINDOW,))
        if is_changed:
            yield Step(COB_ID_SYNC, How.VALUE)

    def _consumers(self) -> Iterator[Step]:
        changed = self._of(CONSUMERS)
        node = self._node
        consumed = {
            consumed_node(node.after(number) or 0): number for number in changed
        }
        for number in changed:
            for value in (node.before(number), node.configured(number)):
                watched = consumed_node(value or 0)
                if watched is not None and consumed.get(watched, number) != number:
                    yield Step(number, How.ZERO, f"node {watched} in no entry")
                    break
        yield from self._values(changed)

    def _sdo(self, index: int) -> Iterator[Step]:
        changed = self._of(index)
        cob_ids = [(index, sub) for sub in (1, 2)]
        others = [number for number in changed if number not in cob_ids]
        written: list[tuple[Number, Service]] = []
        for number in cob_ids:
            service = service_of(number)
            if service is None or not self._node.writable(number):
                continue
            if number in changed or (others and self._may_exist(number, service)):
                written.append((number, service))
        for number, service in written:
            yield from self._off(number, service, always=bool(others))
        yield from self._values(others)
        for number, service in written:
            exists = service.exists(self._node.after(number) or 0)
            if exists or number in changed:
                yield Step(number, How.VALUE, f"{service.name} on" if exists else "")

    def _may_exist(self, number: Number, service: Service) -> bool:
        before = self._node.before(number) or 0
        return service.exists(before) or not self._node.states(number)

    # PDOs

    def _pdos(self, communications: Iterable[int]) -> Iterator[Step]:
        """Yield the writes of PDOs: TPDOs, then RPDOs."""
        for index in sorted(communications, key=lambda i: (i < TPDO_COMMUNICATION, i)):
            yield from self._pdo(index)

    def _pdo(self, index: int) -> Iterator[Step]:
        node, cob_id = self._node, (index, 1)
        service = service_of(cob_id)
        assert service is not None
        name = service.name
        switched = node.writable(cob_id)
        if switched:
            yield from self._off(cob_id, service, always=True)
        others = (number for number in self._of(index) if number != cob_id)
        yield from self._values(others)
        mapping = index + _TO_MAPPING
        if self._of(mapping):
            yield from self._mapping(mapping, name)
        # A PDO that maps nothing stays off: nodes refuse to switch it on.
        is_empty = node.after((mapping, 0)) == 0
        if switched and not is_empty and service.exists(node.after(cob_id) or 0):
            yield Step(cob_id, How.VALUE, f"{name} on")

    def _mapping(self, index: int, name: str) -> Iterator[Step]:
        node, count = self._node, (index, 0)
        used = node.after(count)
        if used is None:
            return
        if node.writable(count):
            yield Step(count, How.ZERO, f"{name} maps nothing")
        if used in MULTIPLEXED:
            yield from self._values(n for n in self._of(index) if n != count)
        else:
            for subindex in range(1, min(used, _MAX_ENTRIES) + 1):
                entry = index, subindex
                if node.after(entry) is not None and node.writable(entry):
                    yield Step(entry, How.VALUE)
        if node.writable(count) and used:
            yield Step(count, How.VALUE, f"{name} maps {used}")

    # Obstacles

    def obstacles(self) -> Iterator[Obstacle]:
        node = self._node
        period = node.before(PERIOD)
        if OVERFLOW in self._changed and period and not node.writable(PERIOD):
            yield Obstacle(OVERFLOW, "1006h is not 0, and cannot be written")
        for index in sorted({number[0] for number in self._changed}):
            communication = pdo_of(index)
            if communication is not None:
                yield from self._fixed(index, communication)

    def _fixed(self, index: int, communication: int) -> Iterator[Obstacle]:
        node, cob_id = self._node, (communication, 1)
        service = service_of(cob_id)
        assert service is not None
        is_mapping = index != communication
        may_be_valid = self._may_exist(cob_id, service)
        is_valid = "is" if node.states(cob_id) else "may be"
        for number in self._of(index):
            if not (is_mapping or number[1] in _WHILE_INVALID):
                continue
            if may_be_valid and not node.writable(cob_id):
                why = (
                    f"{service.name} {is_valid} valid, and its COB-ID cannot be written"
                )
                yield Obstacle(number, why)
            elif is_mapping and number[1] and not node.writable((index, 0)):
                why = f"the number of objects in {service.name} cannot be written"
                yield Obstacle(number, why)


_PDOS: Final = (1, 0.0, 0)
"""The rank of PDOs: after the communication profile, before the objects of the application."""


def _rank(number: Number) -> tuple[int, float, int]:
    index, subindex = number
    if index in STORE:
        return 4, index, subindex
    if index == _VERIFY:
        return 3, index, subindex
    if index >= _PROFILES:
        return 2, index, subindex
    if number == _PRODUCER:
        return 0, CONSUMERS - 0.5, subindex
    return 0, index, subindex
