"""Heartbeat consumers of a device (CiA 301, object 1016h), with the error for a lost node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.node.emergency_producer import EmergencyProducer
from rtgen.runtime.canopen.node.object_dictionary import DeviceDictionary
from rtgen.runtime.canopen.wire.emergency import HEARTBEAT_LOST
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    MAX_NODE_ID,
    MILLISECOND,
    Frame,
    earliest,
)
from rtgen.runtime.canopen.wire.heartbeat import (
    HeartbeatConsumer,
    HeartbeatEvent,
    HeartbeatNews,
)
from rtgen.runtime.canopen.wire.sdo import SdoAbort

CONSUMERS: Final = 0x1016
_INCOMPATIBLE: Final = 0x06040043


def watched(entry: int) -> tuple[int, int] | None:
    """Return node-id and consumer time in ms of an entry of 1016h; None for an unused entry."""
    node_id, time = entry >> 16 & 0xFF, entry & 0xFFFF
    return (node_id, time) if 1 <= node_id <= MAX_NODE_ID and time else None


class HeartbeatConsumers:
    """The consumers of a device; `noticed` is called with every event."""

    def __init__(
        self,
        dictionary: DeviceDictionary,
        errors: EmergencyProducer,
        on_event: Callable[[int, HeartbeatEvent], None],
    ) -> None:
        self._dictionary = dictionary
        self._errors = errors
        self._noticed = on_event
        self._consumers: dict[int, HeartbeatConsumer] = {}
        self._periods: dict[int, int] = {}
        self.deadline: int | None = None
        """Time of the next call of `poll`."""
        self._entries = [(CONSUMERS, sub) for sub in dictionary.subindices(CONSUMERS)]
        dictionary.guard((CONSUMERS,), self._check)

    @property
    def identifiers(self) -> frozenset[int]:
        """The CAN identifiers of the consumed heartbeats."""
        return frozenset(ERROR_CONTROL + node_id for node_id in self._consumers)

    def configure(self) -> None:
        """Apply 1016h; consumers whose entry is unchanged keep their state."""
        times: dict[int, int] = {}
        for number in self._entries:
            entry = watched(self._dictionary.number(number)) if number[1] else None
            if entry is not None:
                times.setdefault(*entry)
        for node_id in [n for n in self._consumers if n not in times]:
            del self._consumers[node_id]
            self._errors.remove(HEARTBEAT_LOST, bytes((node_id,)))
        for node_id, time in times.items():
            if node_id not in self._consumers or self._periods[node_id] != time:
                consumer = HeartbeatConsumer(node_id, time * MILLISECOND)
                self._consumers[node_id] = consumer
        self._periods = times
        self._settle()

    def reset(self) -> None:
        """Drop all consumers, because the device resets."""
        self._consumers.clear()
        self._settle()

    def receive(self, frame: Frame, now: int) -> None:
        """Process a heartbeat."""
        node_id = frame.can_id - ERROR_CONTROL
        consumer = self._consumers.get(node_id)
        if consumer is None:
            return
        event = consumer.receive(frame, now)
        self._settle()
        if event is None:
            return
        if event.news is not HeartbeatNews.BOOT_UP:
            self._errors.remove(HEARTBEAT_LOST, bytes((node_id,)))
        self._noticed(node_id, event)

    def poll(self, now: int) -> None:
        """Report nodes whose heartbeat is overdue."""
        for node_id, consumer in list(self._consumers.items()):
            event = consumer.poll(now)
            self._settle()
            if event is not None:
                self._errors.add(HEARTBEAT_LOST, bytes((node_id,)))
                self._noticed(node_id, event)

    def _settle(self) -> None:
        self.deadline = earliest(*[each.deadline for each in self._consumers.values()])

    def _check(self, number: ObjectNumber, value: ObjectValue) -> None:
        if not number[1]:
            return
        entry = watched(int(value))
        for other in self._entries:
            if entry is None or other == number or not other[1]:
                continue
            consumed = watched(self._dictionary.number(other))
            if consumed is not None and consumed[0] == entry[0]:
                raise SdoAbort(_INCOMPATIBLE)
