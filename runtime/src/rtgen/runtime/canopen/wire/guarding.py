"""Node guarding and life guarding (CiA 301, 7.2.8.2.2; objects 100Ch and 100Dh).

The NMT master polls a node with remote frames; the node responds with its state and a toggle bit.
It is for nodes without heartbeat: a node uses only one of both.
"""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.wire.frames import ERROR_CONTROL, Frame, checked_node_id

TOGGLE: Final = 0x80
"""The toggle bit, which alternates between consecutive responses."""


class NodeGuard:
    """The master's side of node guarding: one request to the node per `period` ns.

    `deadline` is when `poll` has a request to send, None while guarding is off. A response with an
    unchanged toggle bit is rejected: the CAN controller may respond although the node's software
    has stopped. After a request without a response, either toggle bit is accepted.
    """

    def __init__(self, node_id: int) -> None:
        self._can_id = ERROR_CONTROL + checked_node_id(node_id)
        self._period = 0
        self._last: int | None = None
        self._awaiting = False
        self.deadline: int | None = None

    def start(self, period: int, now: int) -> None:
        """Start guarding; the first request is due immediately."""
        self._period, self._last, self._awaiting = period, None, False
        self.deadline = now

    def stop(self) -> None:
        """Stop guarding."""
        self.deadline = None

    def poll(self, now: int) -> Frame | None:
        """Return the request, if due. Requests that are late by more than a period are skipped."""
        if self.deadline is None or now < self.deadline:
            return None
        if self._awaiting:
            self._last = None
        self._awaiting = True
        self.deadline += self._period * (1 + (now - self.deadline) // self._period)
        return Frame(self._can_id, remote=True)

    def accepts(self, frame: Frame) -> bool:
        """Return whether a response shows that the node is alive; True while guarding is off."""
        if self.deadline is None or frame.remote or len(frame.data) != 1:
            return True
        before, self._last = self._last, frame.data[0] & TOGGLE
        self._awaiting = False
        return self._last != before


class LifeGuard:
    """The node's side: supervises the master's requests from the first one on."""

    def __init__(self) -> None:
        self._toggle = 0
        self._lifetime = 0
        self._polled = False
        self.deadline: int | None = None

    def configure(self, lifetime: int, now: int) -> None:
        """Set the life time (100Ch times 100Dh) in ns; 0 disables supervision."""
        self._lifetime = lifetime
        self.deadline = now + lifetime if lifetime and self._polled else None

    def requested(self, now: int) -> int:
        """Process a request; return the toggle bit of the response."""
        toggle = self._toggle
        self._toggle ^= TOGGLE
        self._polled = True
        self.deadline = now + self._lifetime if self._lifetime else None
        return toggle

    def reset(self) -> None:
        """Reset at boot-up: supervision waits for the first request, the toggle bit is 0."""
        self._toggle, self._polled, self.deadline = 0, False, None

    def poll(self, now: int) -> bool:
        """Return whether the master has just been lost; True only once."""
        if self.deadline is None or now < self.deadline:
            return False
        self.deadline, self._polled = None, False
        return True
