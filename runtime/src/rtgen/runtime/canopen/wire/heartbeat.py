"""Heartbeat producer and consumer (CiA 301, 7.2.8.3.2; objects 1016h and 1017h)."""

from __future__ import annotations

from enum import Enum
from typing import Final

import msgspec

from rtgen.runtime.canopen.wire.frames import ERROR_CONTROL, Frame, checked_node_id
from rtgen.runtime.canopen.wire.guarding import TOGGLE
from rtgen.runtime.canopen.wire.nmt import NmtState, heartbeat_frame

_STATES: Final = frozenset(NmtState)


class HeartbeatProducer:
    """Heartbeat producer with a period in ns; 0 disables it.

    `deadline` is when `poll` has a heartbeat to send, None for never. Heartbeats keep their
    phase; those that are late by more than a period are skipped.
    """

    def __init__(self, node_id: int, period: int = 0) -> None:
        self._node_id = checked_node_id(node_id)
        self._period = period
        self.deadline: int | None = None

    def booted(self, now: int) -> None:
        """Start the period at the boot-up message, which counts as the first heartbeat."""
        self.deadline = now + self._period if self._period else None

    def configure(self, period: int, now: int) -> None:
        """Apply a new period (1017h written); the next heartbeat is due immediately."""
        self._period = period
        self.deadline = now if period else None

    def stop(self) -> None:
        """Stop until `booted`, because the node resets."""
        self.deadline = None

    def poll(self, now: int, state: NmtState) -> Frame | None:
        """Return the heartbeat, if due."""
        if self.deadline is None or now < self.deadline:
            return None
        self.deadline += self._period * (1 + (now - self.deadline) // self._period)
        return heartbeat_frame(self._node_id, state)


class HeartbeatNews(Enum):
    """Kinds of events of a heartbeat consumer."""

    BOOT_UP = "boot-up"
    FOUND = "found"
    """The first heartbeat, or the first after BOOT_UP or LOST."""
    CHANGED = "changed"
    LOST = "lost"


class HeartbeatEvent(msgspec.Struct, frozen=True, gc=False):
    """An event of a node; `asked`: its new state was requested."""

    news: HeartbeatNews
    state: NmtState
    asked: bool


class HeartbeatConsumer:
    """Consumes the heartbeat of one node; `timeout` in ns, 0 for no supervision.

    Supervision starts with the first heartbeat, and again after every boot-up message, so a node
    whose heartbeat is not configured yet is not lost. `deadline` is when the node is lost, None
    without supervision.
    """

    def __init__(self, node_id: int, timeout: int) -> None:
        self._can_id = ERROR_CONTROL + checked_node_id(node_id)
        self._timeout = timeout
        self.deadline: int | None = None
        self.state: NmtState | None = None
        """The last received state; None before the first, and after LOST."""
        self._requested: NmtState | None = None
        self._beating = False

    @property
    def timeout(self) -> int:
        """The time-out in ns, 0 for none."""
        return self._timeout

    def configure(self, timeout: int, now: int) -> None:
        """Apply a new time-out (1016h written)."""
        self._timeout = timeout
        self.deadline = now + timeout if timeout and self._beating else None

    def watch(self, now: int) -> None:
        """Start supervision without waiting for the first heartbeat."""
        self._beating = True
        self.deadline = now + self._timeout if self._timeout else None

    def ask(self, state: NmtState) -> None:
        """Record that the node was commanded to a state; INITIALISING stands for a reset."""
        self._requested = state

    def receive(self, frame: Frame, now: int) -> HeartbeatEvent | None:
        """Return the event in a frame; None for other frames and for unchanged states."""
        state = self._state_in(frame)
        if state is None:
            return None
        if state is NmtState.INITIALISING:
            self._beating, self.deadline = False, None
            self.state = NmtState.PRE_OPERATIONAL
            return HeartbeatEvent(
                HeartbeatNews.BOOT_UP, state, self._take_request(state)
            )
        before = self.state
        is_new = before is None or not self._beating
        self._beating, self.state = True, state
        self.deadline = now + self._timeout if self._timeout else None
        if state is before and not is_new:
            self._take_request(state)
            return None
        news = HeartbeatNews.FOUND if is_new else HeartbeatNews.CHANGED
        asked = self._take_request(state)
        return HeartbeatEvent(news, state, asked)

    def poll(self, now: int) -> HeartbeatEvent | None:
        """Return LOST, once, when the time-out has expired."""
        if self.deadline is None or now < self.deadline:
            return None
        last = NmtState.INITIALISING if self.state is None else self.state
        self.deadline, self.state, self._beating = None, None, False
        return HeartbeatEvent(HeartbeatNews.LOST, last, asked=False)

    def _state_in(self, frame: Frame) -> NmtState | None:
        if frame.can_id != self._can_id or frame.extended or frame.remote:
            return None
        if len(frame.data) != 1:
            return None
        octet = frame.data[0]
        # a node guarding response has the toggle bit above the state
        code = octet & ~TOGGLE or octet
        return NmtState(code) if code in _STATES else None

    def _take_request(self, state: NmtState) -> bool:
        """Return whether the state was requested; clears the request."""
        if self._requested is not state:
            return False
        self._requested = None
        return True
