"""Heartbeat producer and consumer (CiA 301, 7.2.8.3.2; objects 1016h and 1017h)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final

from rtgen.runtime.canopen.frames import ERROR_CONTROL, Frame, checked_node_id
from rtgen.runtime.canopen.guarding import TOGGLE
from rtgen.runtime.canopen.nmt import NmtState, heartbeat_frame

_STATES: Final = frozenset(NmtState)


class HeartbeatProducer:
    """Tells a node's state every `period` ns; 0 is off.

    `deadline` is when `poll` has something to send, None for never. Beats keep their raster; those
    that are late by more than a period are left out.
    """

    def __init__(self, node_id: int, period: int = 0) -> None:
        self._node_id = checked_node_id(node_id)
        self._period = period
        self.deadline: int | None = None

    def booted(self, now: int) -> None:
        """The boot-up message, which counts as the first heartbeat, is sent."""
        self.deadline = now + self._period if self._period else None

    def configure(self, period: int, now: int) -> None:
        """Takes a new period (1017h written), and begins at once."""
        self._period = period
        self.deadline = now if period else None

    def stop(self) -> None:
        """The node resets: nothing more until `booted`."""
        self.deadline = None

    def poll(self, now: int, state: NmtState) -> Frame | None:
        """The heartbeat if it is due."""
        if self.deadline is None or now < self.deadline:
            return None
        self.deadline += self._period * (1 + (now - self.deadline) // self._period)
        return heartbeat_frame(self._node_id, state)


class HeartbeatNews(Enum):
    """What a consumer notices."""

    BOOT_UP = "boot-up"
    FOUND = "found"
    """The first heartbeat, or the first one after BOOT_UP or LOST."""
    CHANGED = "changed"
    LOST = "lost"


@dataclass(frozen=True, slots=True)
class HeartbeatEvent:
    """News of a node; `asked` tells whether the state is the one that was asked for.

    The state of LOST is the last one known, INITIALISING if none is.
    """

    news: HeartbeatNews
    state: NmtState
    asked: bool


class HeartbeatConsumer:
    """Watches one node; `timeout` in ns, 0 to tell states without supervision.

    Supervision starts with the first heartbeat, and anew after every boot-up message: a node whose
    heartbeat is not configured yet is not lost. `deadline` is when it is lost, None while it is
    not supervised.
    """

    def __init__(self, node_id: int, timeout: int) -> None:
        self._can_id = ERROR_CONTROL + checked_node_id(node_id)
        self._timeout = timeout
        self.deadline: int | None = None
        self.state: NmtState | None = None
        """The last state told; None before, and after LOST."""
        self._asked: NmtState | None = None
        self._beating = False

    @property
    def timeout(self) -> int:
        """The time-out in ns, 0 for none."""
        return self._timeout

    def configure(self, timeout: int, now: int) -> None:
        """Takes a new time-out (1016h written)."""
        self._timeout = timeout
        self.deadline = now + timeout if timeout and self._beating else None

    def watch(self, now: int) -> None:
        """Supervises from now on, without a first heartbeat: the node is asked for its state."""
        self._beating = True
        self.deadline = now + self._timeout if self._timeout else None

    def ask(self, state: NmtState) -> None:
        """The node has been told to go there; INITIALISING stands for a reset."""
        self._asked = state

    def receive(self, frame: Frame, now: int) -> HeartbeatEvent | None:
        """The news in a frame; None if it is no heartbeat of the node, or tells nothing new."""
        state = self._told(frame)
        if state is None:
            return None
        if state is NmtState.INITIALISING:
            self._beating, self.deadline = False, None
            self.state = NmtState.PRE_OPERATIONAL
            return HeartbeatEvent(HeartbeatNews.BOOT_UP, state, self._settle(state))
        before = self.state
        found = before is None or not self._beating
        self._beating, self.state = True, state
        self.deadline = now + self._timeout if self._timeout else None
        if state is before and not found:
            self._settle(state)
            return None
        news = HeartbeatNews.FOUND if found else HeartbeatNews.CHANGED
        asked = self._settle(state)
        return HeartbeatEvent(news, state, asked)

    def poll(self, now: int) -> HeartbeatEvent | None:
        """LOST, once, when the time-out is over."""
        if self.deadline is None or now < self.deadline:
            return None
        last = NmtState.INITIALISING if self.state is None else self.state
        self.deadline, self.state, self._beating = None, None, False
        return HeartbeatEvent(HeartbeatNews.LOST, last, asked=False)

    def _told(self, frame: Frame) -> NmtState | None:
        if frame.can_id != self._can_id or frame.extended or frame.remote:
            return None
        if len(frame.data) != 1:
            return None
        octet = frame.data[0]
        # An answer to node guarding has the state below its toggle bit.
        code = octet & ~TOGGLE or octet
        return NmtState(code) if code in _STATES else None

    def _settle(self, state: NmtState) -> bool:
        """Whether the state was asked for; the question is then answered."""
        if self._asked is not state:
            return False
        self._asked = None
        return True
