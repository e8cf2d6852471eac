"""The sending half of connections with subscription type `new` or `periodic`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from rtgen.facts.connector_properties import PushPolicy
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.ports.buffers import RingBuffer
from rtgen.runtime.ports.connector_properties import ConnectorSettings
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.timing.guards import Guard

T = TypeVar("T", bound=DataType)


def _do_nothing() -> None:
    return None


class Publisher(Generic[T]):
    """The sending half of a `new` or `periodic` connection: a buffer and a push policy.

    `signal` is called after each write; the publisher's driver sets it. A sample that the reader's
    buffer rejects is kept and offered again next time, one that cannot be sent at all is dropped.
    """

    def __init__(
        self, settings: ConnectorSettings, target: RingBuffer[T], guard: Guard
    ) -> None:
        self.subscription = settings.subscription
        self.rate = settings.push_rate
        self.waiting: RingBuffer[T] = RingBuffer(settings.outport_buffer, guard)
        self.dropped = 0
        self.signal: Callable[[], None] = _do_nothing
        self._policy = settings.push_policy
        self._skip_count = settings.skip_count
        self._skipped = 0
        self._target = target
        self._in_hand: T | None = None

    @property
    def idle(self) -> bool:
        """Whether no sample waits for delivery."""
        return self._in_hand is None and not self.waiting.samples

    def publish(self) -> None:
        """Deliver the samples selected by the policy."""
        if self._policy is PushPolicy.NEW:
            self._drop_all_but_newest()
        while self._pick() and self._deliver() and self._policy is not PushPolicy.FIFO:
            continue

    def wait(self) -> None:
        """Wait for work, or until the connection is removed."""
        guard = self.waiting.guard if self._in_hand is None else self._target.guard
        with guard:
            guard.wait_for(self._can_go_on)

    @property
    def closed(self) -> bool:
        """Whether the connection was removed."""
        return self.waiting.closed

    @property
    def in_hand(self) -> int:
        """Number of samples taken from the buffer and not delivered: 0 or 1."""
        return self._in_hand is not None

    def _can_go_on(self) -> bool:
        if self.waiting.closed or self._target.closed:
            return True
        if self._in_hand is None:
            return bool(self.waiting.samples)
        return len(self._target.samples) < self._target.settings.length

    def _drop_all_but_newest(self) -> None:
        with self.waiting.guard:
            if self._in_hand is not None and self.waiting.samples:
                self._in_hand = None
                self.dropped += 1
            while len(self.waiting.samples) > 1:
                self.waiting.take()
                self.dropped += 1

    def _pick(self) -> bool:
        with self.waiting.guard:
            while self._in_hand is None and self.waiting.samples:
                sample = self.waiting.take()
                if self._policy is PushPolicy.SKIP and self._skipped < self._skip_count:
                    self._skipped += 1
                    self.dropped += 1
                else:
                    self._skipped = 0
                    self._in_hand = sample
            self.waiting.guard.notify_all()
        return self._in_hand is not None

    def _deliver(self) -> bool:
        sample = self._in_hand
        if sample is None:
            return False
        status = self._target.write(sample)
        if status not in (PORT_OK, PortStatus.PORT_ERROR):
            return False
        self._in_hand = None
        return True
