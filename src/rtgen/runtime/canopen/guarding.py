"""Node guarding and life guarding (CiA 301, 7.2.8.2.2; objects 100Ch and 100Dh).

The NMT master polls a node with remote frames; the node answers with its state and a toggle bit.
For nodes without a heartbeat: no node uses both.
"""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.frames import ERROR_CONTROL, Frame, checked_node_id

TOGGLE: Final = 0x80
"""The bit of an answer that differs from that of the answer before."""


class NodeGuard:
    """The master's requests to one node, one each `period` ns.

    `deadline` is when `poll` has one to send, None while guarding is off. An answer that repeats
    the toggle bit is not accepted, since the node's software may have stopped behind a controller
    that answers by itself; after a request without an answer either toggle bit is accepted.
    """

    def __init__(self, node_id: int) -> None:
        self._can_id = ERROR_CONTROL + checked_node_id(node_id)
        self._period = 0
        self._last: int | None = None
        self._awaiting = False
        self.deadline: int | None = None

    def start(self, period: int, now: int) -> None:
        """Guards from now on; the first request is due at once."""
        self._period, self._last, self._awaiting = period, None, False
        self.deadline = now

    def stop(self) -> None:
        """Sends no more requests."""
        self.deadline = None

    def poll(self, now: int) -> Frame | None:
        """The request if it is due. Requests that are late by more than a period are left out."""
        if self.deadline is None or now < self.deadline:
            return None
        if self._awaiting:
            self._last = None
        self._awaiting = True
        self.deadline += self._period * (1 + (now - self.deadline) // self._period)
        return Frame(self._can_id, remote=True)

    def accepts(self, frame: Frame) -> bool:
        """Whether an answer of the node shows that it is alive; True while guarding is off."""
        if self.deadline is None or frame.remote or len(frame.data) != 1:
            return True
        before, self._last = self._last, frame.data[0] & TOGGLE
        self._awaiting = False
        return self._last != before


class LifeGuard:
    """A node's supervision of its master's requests, from the first one on.

    `deadline` is when the master counts as lost, None while nothing is supervised.
    """

    def __init__(self) -> None:
        self._toggle = 0
        self._lifetime = 0
        self._polled = False
        self.deadline: int | None = None

    def configure(self, lifetime: int, now: int) -> None:
        """Sets the life time (100Ch times 100Dh) in ns; 0 is off."""
        self._lifetime = lifetime
        self.deadline = now + lifetime if lifetime and self._polled else None

    def requested(self, now: int) -> int:
        """The toggle bit of the answer to a request."""
        toggle = self._toggle
        self._toggle ^= TOGGLE
        self._polled = True
        self.deadline = now + self._lifetime if self._lifetime else None
        return toggle

    def reset(self) -> None:
        """The node boots: supervision waits for the first request, and toggling begins anew."""
        self._toggle, self._polled, self.deadline = 0, False, None

    def poll(self, now: int) -> bool:
        """Whether the master is lost; True once."""
        if self.deadline is None or now < self.deadline:
            return False
        self.deadline, self._polled = None, False
        return True
