"""Ring buffers of connections, with OpenRTM's policies for full and empty buffers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

import msgspec

from rtgen.facts.connector_properties import EmptyPolicy, FullPolicy
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.timing.guards import SINGLE_THREAD, Guard

T = TypeVar("T")


class BufferSettings(msgspec.Struct, frozen=True, gc=False):
    """The settings of one end of a connection; timeouts in seconds, used by `block`."""

    length: int = 8
    full_policy: FullPolicy = FullPolicy.OVERWRITE
    write_timeout: float = 1.0
    empty_policy: EmptyPolicy = EmptyPolicy.READBACK
    read_timeout: float = 1.0


class RingBuffer(Generic[T]):
    """A ring buffer with at most `settings.length` samples, oldest first.

    `arrivals` is the order in which samples arrived in the buffers of one InPort: the buffer
    appends itself once per sample, so that the port reads the oldest sample of all buffers. It is
    None if the port has one connection.
    """

    __slots__ = (
        "arrivals",
        "closed",
        "guard",
        "on_arrival",
        "overwritten",
        "samples",
        "settings",
    )

    def __init__(self, settings: BufferSettings, guard: Guard = SINGLE_THREAD) -> None:
        self.settings = settings
        self.guard = guard
        self.samples: deque[T] = deque()
        self.arrivals: deque[RingBuffer[T]] | None = None
        self.on_arrival: Callable[[], None] | None = None
        """Called after each sample, by its writer."""
        self.overwritten = 0
        self.closed = False

    def write(self, value: T) -> PortStatus:
        """Append a sample, or return the reason of failure.

        `block` waits if another thread can read.
        """
        with self.guard:
            if self.closed:
                return PortStatus.CONNECTION_LOST
            if len(self.samples) >= self.settings.length:
                refusal = self._make_room()
                if refusal is not None:
                    return refusal
            self.samples.append(value)
            if self.arrivals is not None:
                self.arrivals.append(self)
            self.guard.notify_all()
        if self.on_arrival is not None:
            self.on_arrival()
        return PORT_OK

    def _make_room(self) -> PortStatus | None:
        policy = self.settings.full_policy
        if policy is FullPolicy.OVERWRITE:
            self.overwritten += 1
            self.drop()
            return None
        if policy is FullPolicy.DO_NOTHING:
            return PortStatus.BUFFER_FULL
        self.guard.wait_for(self._has_room_or_closed, self.settings.write_timeout)
        if self.closed:
            return PortStatus.CONNECTION_LOST
        return (
            PortStatus.BUFFER_TIMEOUT
            if len(self.samples) >= self.settings.length
            else None
        )

    def _has_room_or_closed(self) -> bool:
        return self.closed or len(self.samples) < self.settings.length

    def take(self) -> T:
        """Remove and return the oldest sample, which must exist; the caller holds the guard."""
        if self.arrivals is not None:
            self.arrivals.remove(self)
        return self.samples.popleft()

    def drop(self) -> None:
        """Remove the oldest sample, which nobody reads; the caller holds the guard."""
        if self.arrivals is not None:
            self.arrivals.remove(self)
        del self.samples[0]

    def close(self) -> int:
        """Wake waiting threads, drop unread samples and return their number."""
        with self.guard:
            self.closed = True
            unread = len(self.samples)
            while self.samples:
                self.drop()
            self.guard.notify_all()
        return unread
