"""Error control of a device (CiA 301, 7.2.8.3.2): heartbeat, or responses to node guarding.

Objects 100Ch, 100Dh and 1017h. `heartbeat_consumers` handles heartbeats of other nodes.
"""

from __future__ import annotations

from collections.abc import Set
from typing import Final

from rtgen.runtime.canopen.node.emergency_producer import EmergencyProducer
from rtgen.runtime.canopen.node.object_dictionary import DeviceDictionary
from rtgen.runtime.canopen.wire.emergency import HEARTBEAT_LOST
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    MILLISECOND,
    Frame,
    earliest,
)
from rtgen.runtime.canopen.wire.guarding import LifeGuard
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatProducer
from rtgen.runtime.canopen.wire.nmt import NmtState

GUARD_TIME: Final = (0x100C, 0)
LIFE_TIME_FACTOR: Final = (0x100D, 0)
HEARTBEAT_TIME: Final = (0x1017, 0)
_INDICES: Final = {GUARD_TIME[0], LIFE_TIME_FACTOR[0], HEARTBEAT_TIME[0]}


class ErrorControl:
    """Heartbeat producer and life guarding; a node with a heartbeat ignores guarding."""

    def __init__(self, dictionary: DeviceDictionary, errors: EmergencyProducer) -> None:
        self._dictionary = dictionary
        self._errors = errors
        self._producer = HeartbeatProducer(1)
        self._life = LifeGuard()

    @property
    def deadline(self) -> int | None:
        """Time of the next call of `poll` or `beat`."""
        return earliest(self._producer.deadline, self._life.deadline)

    def begin(self, node_id: int) -> None:
        """Enter INITIALISING with a node-id."""
        self._producer = HeartbeatProducer(node_id, self._period)

    def boot(self, node_id: int, now: int) -> None:
        """Begin heartbeats after the boot-up message; guarding waits for a request."""
        self._producer = HeartbeatProducer(node_id, self._period)
        self._producer.booted(now)
        self._life.reset()

    def restart_heartbeat(self, now: int) -> None:
        """Apply 1017h, from the current time on."""
        self._producer.configure(self._period, now)

    def configure(self, indices: Set[int], now: int) -> None:
        """Apply the objects of these indices that concern error control."""
        if HEARTBEAT_TIME[0] in indices:
            self.restart_heartbeat(now)
        if indices & _INDICES:
            self._life.configure(self._lifetime, now)

    def poll(self, now: int) -> bool:
        """Return whether life guarding has just lost the NMT master."""
        return self._life.poll(now)

    def beat(self, now: int, state: NmtState) -> Frame | None:
        """Return the heartbeat, if due."""
        return self._producer.poll(now, state)

    def answer(self, node_id: int, state: NmtState, now: int) -> Frame | None:
        """Return the response to a node guarding request; None for a node with a heartbeat."""
        if self._period:
            return None
        self._life.configure(self._lifetime, now)
        data = bytes((state | self._life.requested(now),))
        self._errors.remove(HEARTBEAT_LOST, b"")
        return Frame(ERROR_CONTROL + node_id, data)

    @property
    def _period(self) -> int:
        """The heartbeat period in ns; 0 without heartbeats."""
        return self._dictionary.number(HEARTBEAT_TIME) * MILLISECOND

    @property
    def _lifetime(self) -> int:
        """The life time of guarding in ns; 0 without supervision."""
        if self._period:
            return 0
        return (
            self._dictionary.number(GUARD_TIME)
            * self._dictionary.number(LIFE_TIME_FACTOR)
            * MILLISECOND
        )
