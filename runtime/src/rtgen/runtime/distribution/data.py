"""Data ports over a medium: an OutPort's topic, and connections from and to other processes.

Every OutPort has a topic, `INSTANCE/out/PORT`, whether it is connected or not, so programs without
rtgen can read it. A connection from another process subscribes to that topic; its buffers and
policies are those of a connection within a process, at the receiving end. Every InPort also takes
samples from a topic of its own, `INSTANCE/in/PORT`, which programs without rtgen can write.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import Any

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.medium import (
    SEQUENCES,
    Medium,
    MediumError,
    Publisher,
    PublishTimeoutError,
    Qos,
    Sample,
    Subscription,
    representation,
)
from rtgen.runtime.distribution.names import in_topic, out_topic
from rtgen.runtime.distribution.payloads import received
from rtgen.runtime.distribution.qos import DEFAULT, qos_of, strongest
from rtgen.runtime.errors import TransportError
from rtgen.runtime.failures import log
from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.layouts.formats import Format
from rtgen.runtime.ports.data_ports import DataConnector, Demand, InPort, OutPort
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.services.transports import RemotePort
from rtgen.runtime.timing.guards import Guard

_SOURCES = 256
"""Publishers of one topic whose sequence numbers are remembered."""


def encoder(type_: type[Any]) -> Callable[[Any], bytes]:
    """A function that serializes samples of a type. It raises CdrError."""
    version = Format(representation(type_).version)
    return compiled("to_payload", type_._descriptor_, version)


class OutTopic:
    """The topic of an OutPort; `connections` of this process share it.

    The publisher is made at `open`, or by the first sample, with the strongest QoS of the
    connections known by then; a connection that needs more replaces it.
    """

    def __init__(self, medium: Medium, port: OutPort[Any]) -> None:
        self._medium = medium
        self._port = port
        self._topic = out_topic(port.owner, port.name, port.type)
        self._type = port.type
        self._encode = encoder(port.type)
        self._qos = DEFAULT
        self._lock = threading.Lock()
        self._publisher: Publisher | None = None
        self._closed = False
        self.connections: tuple[SendingConnector, ...] = ()
        port.add_outlet(self.send, self._demand)

    def _demand(self) -> Demand:
        """Return who reads the topic now."""
        if self.connections:
            return Demand.CONNECTION
        with self._lock:
            publisher = self._publisher
            try:
                is_read = publisher is not None and publisher.matched
            except MediumError as error:
                log.warning("%s: %s", self._port, error)
                return Demand.NOBODY
        return Demand.PAGES if is_read else Demand.NOBODY

    def require(self, qos: Qos) -> None:
        """Offer at least this QoS."""
        with self._lock:
            needed = strongest(self._qos, qos)
            if needed != self._qos and self._publisher is not None:
                self._publisher.close()
                self._publisher = None
            self._qos = needed

    def open(self) -> Publisher:
        """The publisher. Raises MediumError."""
        with self._lock:
            return self._opened()

    def _opened(self) -> Publisher:
        if self._publisher is None:
            if self._closed:
                raise MediumError(f"the topic of {self._port} is closed")
            self._publisher = self._medium.publisher(self._topic, self._qos)
        return self._publisher

    def send(self, value: Any) -> PortStatus:
        """Publish a sample. Raises CdrError, and SampleTypeError for a foreign type.

        CONNECTION_LOST if the other end of a connection is lost, BUFFER_TIMEOUT if there was no
        room in time, PORT_ERROR if the engine fails.
        """
        if value.__class__ is not self._type:
            self._port._checked(value)
        try:
            octets = self._encode(value)
        except CdrError as error:
            raise self._port.located(error) from None
        try:
            with self._lock:
                publisher = self._publisher or self._opened()
                publisher.publish(octets)
        except PublishTimeoutError:
            return self._refused(PortStatus.BUFFER_TIMEOUT)
        except MediumError as error:
            log.warning("%s: %s", self._port, error)
            return self._refused(PortStatus.PORT_ERROR)
        for connection in self.connections:
            if connection.is_lost():
                return PortStatus.CONNECTION_LOST
        return PORT_OK

    def _refused(self, status: PortStatus) -> PortStatus:
        for connection in self.connections:
            connection.refused += 1
        return status

    def close(self) -> None:
        """Withdraw the topic."""
        self._port.remove_outlet(self.send)
        with self._lock:
            self._closed = True
            if self._publisher is not None:
                self._publisher.close()
                self._publisher = None


class SendingConnector:
    """A connection from an OutPort of this process to an InPort of another one.

    Its samples are those of the OutPort's topic; what the receiving end loses is counted there.
    `refused` writes were answered with a status.
    """

    def __init__(
        self,
        name: str,
        topic: OutTopic,
        source: OutPort[Any],
        target: RemotePort,
        properties: Mapping[str, str],
        is_lost: Callable[[], bool],
    ) -> None:
        self.name = name
        self.source = source
        self.target = target
        self.properties = dict(properties)
        self.connected = False
        self.refused = 0
        self.is_lost = is_lost
        self._topic = topic
        self._qos = qos_of(properties)

    def __repr__(self) -> str:
        return f"<SendingConnector {self.name}: {self.source} -> {self.target}>"

    @property
    def ends(self) -> tuple[OutPort[Any], RemotePort]:
        """The end in this process, and the other one."""
        return self.source, self.target

    @property
    def matched(self) -> bool:
        """Whether the engine knows a reader. Raises MediumError."""
        return self._topic.open().matched

    def attach(self) -> None:
        """Establish the connection."""
        self.connected = True
        self._topic.require(self._qos)
        self._topic.connections += (self,)

    def detach(self) -> None:
        """Remove the connection. The topic stays, for others."""
        self.connected = False
        self._topic.connections = tuple(
            c for c in self._topic.connections if c is not self
        )


class Arrivals:
    """Checks and decodes the samples of a subscription.

    `missed` samples were lost on the way, `doubles` came twice and were dropped, `invalid` ones
    could not be decoded.
    """

    def __init__(self, what: str, type_: type[Any]) -> None:
        self._what = what
        self._type = type_
        self._sequences: OrderedDict[Hashable, int] = OrderedDict()
        self._missed = 0
        self.doubles = 0
        self.invalid = 0
        self.subscription: Subscription | None = None

    @property
    def missed(self) -> int:
        """Samples that were lost between the processes."""
        engine = self.subscription.lost if self.subscription is not None else 0
        return self._missed + engine

    def taken(self, sample: Sample) -> Any:
        """The value of a sample; None if it is a double or invalid."""
        if sample.sequence is not None and self._is_double(sample):
            return None
        try:
            return received(self._type, sample.octets)
        except CdrError as error:
            self.invalid += 1
            if self.invalid == 1:
                log.warning("%s: a sample cannot be decoded: %s", self._what, error)
            return None

    def _is_double(self, sample: Sample) -> bool:
        source, number = sample.source, sample.sequence or 0
        last = self._sequences.get(source)
        if last is not None:
            step = (number - last) % SEQUENCES
            if not 0 < step < SEQUENCES // 2:
                self.doubles += 1
                return True
            self._missed += step - 1
        self._sequences[source] = number
        if len(self._sequences) > _SOURCES:
            self._sequences.popitem(last=False)
        return False


class ReceivingConnector(DataConnector[Any]):
    """A connection from an OutPort of another process to an InPort of this one.

    `source` stands for the other end.
    """

    def __init__(
        self,
        name: str,
        medium: Medium,
        source: RemotePort,
        target: InPort[Any],
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> None:
        remote: OutPort[Any] = OutPort(source.port, target.type, source.instance)
        super().__init__(name, remote, target, properties, guard)
        self.arrivals = Arrivals(name, target.type)
        self.remote = source
        self._medium = medium
        self._topic = out_topic(source.instance, source.port, target.type)
        self._qos = qos_of(properties)

    @property
    def ends(self) -> tuple[InPort[Any], RemotePort]:
        """The end in this process, and the other one."""
        return self.target, self.remote

    @property
    def matched(self) -> bool:
        """True: the other end waits until it knows this one."""
        return True

    @property
    def missed(self) -> int:
        """See `DataConnector`."""
        return self.arrivals.missed + self.arrivals.invalid

    @property
    def missed_deadlines(self) -> int:
        """See `DataConnector`."""
        subscription = self.arrivals.subscription
        return 0 if subscription is None else subscription.missed_deadlines

    def attach(self) -> None:
        """Makes the connection: from now on samples flow. Raises TransportError."""
        super().attach()
        try:
            subscription = self._medium.subscribe(
                self._topic, self._qos, self._on_sample
            )
        except MediumError as error:
            super().detach()
            raise TransportError(f"{self.name}: {error}") from error
        self.arrivals.subscription = subscription

    def detach(self) -> None:
        """Cuts the connection; unread samples are dropped and counted."""
        if self.arrivals.subscription is not None:
            self.arrivals.subscription.close()
        super().detach()

    def _on_sample(self, sample: Sample) -> None:
        value = self.arrivals.taken(sample)
        if value is not None:
            self.give(value)


class Feed:
    """Gives samples from outside to an InPort; `source` names the writer.

    Its connection is made when the first sample comes, so it costs nothing before.
    """

    def __init__(self, port: InPort[Any], source: str) -> None:
        self._port = port
        self._source = source
        self._connector: DataConnector[Any] | None = None

    def give(self, value: Any) -> None:
        """Give a sample that nothing else refers to."""
        if self._connector is None:
            port = self._port
            outside: OutPort[Any] = OutPort(self._source, port.type, f"{port.owner}.in")
            name = f"{port.owner}.in.{port.name}"
            self._connector = DataConnector(
                name, outside, port, {}, lambda: port._guard
            )
            self._connector.attach()
        self._connector.give(value)

    def close(self) -> None:
        """Give no more samples."""
        if self._connector is not None:
            self._connector.detach()


class OwnTopic:
    """The topic of an InPort, for programs without rtgen."""

    def __init__(self, medium: Medium, port: InPort[Any]) -> None:
        self._arrivals = Arrivals(str(port), port.type)
        self._feed = Feed(port, "topic")
        topic = in_topic(port.owner, port.name, port.type)
        # Whatever a writer offers is enough.
        least = Qos(reliable=False, depth=DEFAULT.depth)
        self._arrivals.subscription = medium.subscribe(topic, least, self._on_sample)

    def _on_sample(self, sample: Sample) -> None:
        value = self._arrivals.taken(sample)
        if value is not None:
            self._feed.give(value)

    def close(self) -> None:
        """Take no more samples."""
        if self._arrivals.subscription is not None:
            self._arrivals.subscription.close()
        self._feed.close()
