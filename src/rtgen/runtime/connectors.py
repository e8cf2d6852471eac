"""Data connections: from an OutPort to an InPort, with a buffer at the end that is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

from rtgen.runtime import connector_properties
from rtgen.runtime.buffers import FullPolicy, RingBuffer
from rtgen.runtime.connector_properties import Dataflow, PushPolicy, Subscription
from rtgen.runtime.data_ports import InPort, OutPort
from rtgen.runtime.descriptors import DataType, difference
from rtgen.runtime.errors import (
    ConnectionLimitError,
    DuplicateConnectionError,
    PortTypeError,
)
from rtgen.runtime.guards import SINGLE_THREAD, Guard
from rtgen.runtime.return_codes import PORT_OK, PortStatus

T = TypeVar("T", bound=DataType)


class Publisher(Generic[T]):
    """The sending half of a `new` or `periodic` connection: an own buffer and a push policy.

    `signal` is called after each write; whoever runs the publisher sets it. A sample that the
    reader's buffer refuses stays in hand and is offered again at the next turn.
    """

    def __init__(
        self, connector: DataConnector[T], target: RingBuffer[T], guard: Guard
    ) -> None:
        settings = connector.settings
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
        """Whether nothing waits to be delivered."""
        return self._in_hand is None and not self.waiting.samples

    def publish(self) -> None:
        """Delivers what the policy picks of the waiting samples."""
        if self._policy is PushPolicy.NEW:
            self._drop_all_but_newest()
        while self._pick() and self._deliver() and self._policy is not PushPolicy.FIFO:
            continue

    def wait(self) -> None:
        """Waits until there is something to do, or the connection is cut."""
        guard = self.waiting.guard if self._in_hand is None else self._target.guard
        with guard:
            guard.wait_for(self._can_go_on)

    @property
    def closed(self) -> bool:
        """Whether the connection is cut."""
        return self.waiting.closed

    @property
    def in_hand(self) -> int:
        """How many samples were taken from the buffer and not delivered: 0 or 1."""
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
        if sample is None or self._target.write(sample) is not PORT_OK:
            return False
        self._in_hand = None
        return True


class DataConnector(Generic[T]):
    """One connection of data ports, and the count of what it lost.

    `refused` writes were answered with a status, so the writer knows of them; `dropped` samples
    fell to the push policy; `cut` ones were unread when the connection was cut.
    """

    def __init__(
        self,
        name: str,
        source: OutPort[T],
        target: InPort[T],
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> None:
        self.name = name
        self.source = source
        self.target = target
        self.properties = dict(properties)
        self.settings = connector_properties.parse(properties)
        _check_types(source, target)
        _check_limits(self)
        pull = self.settings.dataflow is Dataflow.PULL
        end = self.settings.outport_buffer if pull else self.settings.inport_buffer
        self.buffer: RingBuffer[T] = RingBuffer(end, target._guard)
        self.publisher: Publisher[T] | None = None
        if not pull and self.settings.subscription is not Subscription.FLUSH:
            self.publisher = Publisher(self, self.buffer, guard())
        self.refused = 0
        self.cut = 0
        self.connected = False
        self.end_publishing: Callable[[], None] = _do_nothing
        """Ends whatever runs the publisher; set by whoever started that."""
        self._snapshot = _snapshot_between(source.type, target.type)

    def __repr__(self) -> str:
        return f"<DataConnector {self.name}: {self.source} -> {self.target}>"

    @property
    def overwritten(self) -> int:
        """Samples that a newer one pushed out of a full buffer."""
        sender = self.publisher.waiting.overwritten if self.publisher else 0
        return self.buffer.overwritten + sender

    @property
    def dropped(self) -> int:
        """Samples that the push policy left out."""
        return self.publisher.dropped if self.publisher else 0

    @property
    def lost(self) -> int:
        """All samples that did not reach the reader."""
        return self.overwritten + self.refused + self.dropped + self.cut

    def send(self, value: T) -> PortStatus:
        """Takes a snapshot and delivers it, or leaves it to the publisher."""
        sample = self._snapshot(self.source._checked(value))
        publisher = self.publisher
        if publisher is None:
            status = self.buffer.write(sample)
        else:
            status = publisher.waiting.write(sample)
            publisher.signal()
        if status is not PORT_OK:
            self.refused += 1
        return status

    def short_way(self) -> Callable[[T], PortStatus]:
        """The quickest form of `send` for the present wiring; `send` itself where in doubt."""
        buffer = self.buffer
        if (
            self.publisher is not None
            or buffer.guard is not SINGLE_THREAD
            or buffer.arrivals is not None
        ):
            return self.send
        type_, length, snapshot = (
            self.source.type,
            buffer.settings.length,
            self._snapshot,
        )
        overwrites = buffer.settings.full_policy is FullPolicy.OVERWRITE
        samples, append, send = buffer.samples, buffer.samples.append, self.send

        def write(value: T) -> PortStatus:
            if value.__class__ is not type_:
                return send(value)
            if len(samples) < length:
                append(snapshot(value))
                return PORT_OK
            if not overwrites:
                return send(value)
            sample = snapshot(value)
            samples.popleft()
            buffer.overwritten += 1
            append(sample)
            return PORT_OK

        return write

    def attach(self) -> None:
        """Makes the connection: from now on samples flow."""
        self.connected = True
        self.target._attach(self)
        self.source._attach(self)

    def detach(self) -> None:
        """Cuts the connection; unread samples are dropped and counted."""
        self.connected = False
        self.source._detach(self)
        if self.publisher is not None:
            self.cut += self.publisher.waiting.close()
        self.cut += self.buffer.close()
        self.end_publishing()
        if self.publisher is not None:
            self.cut += self.publisher.in_hand
        self.target._detach(self)


def _do_nothing() -> None:
    return None


def _check_types(source: OutPort[T], target: InPort[T]) -> None:
    differs = difference(source.type._descriptor_, target.type._descriptor_)
    if differs is not None:
        raise PortTypeError(f"{source} and {target} have different types\n{differs}")


def _check_limits(connector: DataConnector[T]) -> None:
    settings, source, target = connector.settings, connector.source, connector.target
    existing = [c for c in source.connectors if c.target is target]
    if existing and not settings.allow_duplicate:
        raise DuplicateConnectionError(
            f"{source} and {target} are connected already, by {existing[0].name!r}"
        )
    for key, limit, port in (
        ("dataport.fan_out", settings.fan_out, source),
        ("dataport.fan_in", settings.fan_in, target),
    ):
        if limit is not None and len(port.connectors) >= limit:
            raise ConnectionLimitError(
                f"{port} has {len(port.connectors)} connections; {key} allows {limit}"
            )


def _snapshot_between(source: type[T], target: type[T]) -> Callable[[T], T]:
    """How to copy a sample. Types of two generated packages differ as classes, not on the wire."""
    if source is target:
        return source._snapshot_
    return lambda value: target.from_cdr(value.to_cdr())
