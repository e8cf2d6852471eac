"""The transport of a system's samples and calls over a medium, between processes."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import msgspec

from rtgen.runtime.closable import Closable
from rtgen.runtime.distribution.control import BURST, SHARE, Control, serve
from rtgen.runtime.distribution.data import (
    Arrivals,
    OutTopic,
    OwnTopic,
    ReceivingConnector,
    SendingConnector,
    encoder,
)
from rtgen.runtime.distribution.descriptions import DataPort
from rtgen.runtime.distribution.medium import (
    Medium,
    MediumError,
    Publisher,
    Sample,
    Subscription,
    Token,
)
from rtgen.runtime.distribution.names import (
    ending_name,
    in_topic,
    out_topic,
    presence_name,
)
from rtgen.runtime.distribution.peers import Peers, Presence
from rtgen.runtime.distribution.qos import DEFAULT, WATCHING, fails_on_loss
from rtgen.runtime.distribution.services import RemoteProvider, ServedProvider
from rtgen.runtime.distribution.workers import Desk, Workers
from rtgen.runtime.errors import (
    PortTypeError,
    ServedElsewhereError,
    TransportError,
)
from rtgen.runtime.marshalling.comparison import definition, text_difference
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.ports import (
    Carrier,
    Consumer,
    PortOwner,
    Provider,
    ServicePort,
)
from rtgen.runtime.services.remote_connectors import RemoteServiceConnector
from rtgen.runtime.services.servants import ServiceError
from rtgen.runtime.services.transports import RemotePort
from rtgen.runtime.timing.guards import Guard

if TYPE_CHECKING:
    from rtgen.runtime.system.system import System

_POLL_INTERVAL = 0.05


class _Published(msgspec.Struct):
    """The publications of a component of this process; `tokens` are closed in reverse order."""

    component: Component
    topics: dict[str, OutTopic] = msgspec.field(default_factory=dict)
    tokens: list[Any] = msgspec.field(default_factory=list)

    def close(self) -> None:
        while self.tokens:
            self.tokens.pop().close()


class DistributedTransport(Closable):
    """Carries samples and service calls to other processes over a medium, which it owns.

    `timeout` [s] of every call. Calls and samples within the process do not leave it; every data
    port has its topic nevertheless. All methods raise TransportError.
    """

    def __init__(self, medium: Medium, *, timeout: float = 2.0) -> None:
        self._medium = medium
        self._timeout = timeout
        self._process = os.urandom(8).hex()
        self._workers = Workers()
        self._desk = Desk(SHARE, BURST)
        self._published: dict[str, _Published] = {}
        self._calls: list[RemoteServiceConnector[RemoteProvider]] = []
        self._data: list[SendingConnector | ReceivingConnector] = []
        self._failing: dict[str, tuple[str, str]] = {}
        """By connection: the component that fails, and the instance whose loss makes it fail."""
        self._givers: dict[RemotePort, Publisher] = {}
        self._endings: dict[str, Token] = {}
        """The announcements of the ends of instances."""
        self._system: System | None = None
        self._closing = threading.Lock()
        try:
            with _reported():
                self.peers = Peers(medium, self._process, timeout)
                self.peers.listeners.append(self._on_presence)
        except TransportError:
            medium.close()
            raise

    def close(self) -> None:
        """Withdraw everything, and close the medium. A second call has no effect."""
        with self._closing:
            for instance in self._published:
                self._announce_end(instance)
            for published in self._published.values():
                published.close()
            self._published.clear()
            self.peers.close()
            for giver in self._givers.values():
                giver.close()
            for connector in self._calls:
                for provider in connector.providers:
                    provider.close()
            self._workers.close()
            self._desk.close()
            self._medium.close()

    def allow_control(self, system: System) -> None:
        """Let other processes watch and control the components of a system."""
        self._system = system

    # Interface to the system

    def serve(self, component: PortOwner) -> None:
        """Publish ports and providers of a component, then its presence."""
        assert isinstance(component, Component)
        instance = component.instance_name
        published = self._published[instance] = _Published(component)
        ending = self._endings.pop(instance, None)
        if ending is not None:
            ending.close()
        medium = self._medium
        try:
            with _reported():
                for out_port in component.out_ports.values():
                    topic = OutTopic(medium, out_port)
                    published.topics[out_port.name] = topic
                    published.tokens.append(topic)
                for in_port in component.in_ports.values():
                    published.tokens.append(OwnTopic(medium, in_port))
                for provider in component.providers.values():
                    served = ServedProvider(medium, self._workers, provider)
                    published.tokens.append(served)
                control = Control(
                    self._desk, self._workers, component, lambda: self._system
                )
                published.tokens.append(serve(medium, control, instance))
                presence = presence_name(instance, self._process)
                published.tokens.append(medium.announce(presence))
        except TransportError:
            self.withdraw(component)
            raise

    def withdraw(self, component: PortOwner) -> None:
        """Withdraw a component, its presence first."""
        published = self._published.pop(component.instance_name, None)
        if published is not None:
            self._announce_end(component.instance_name)
            published.close()

    def _announce_end(self, instance: str) -> None:
        """Tell other processes that an instance is not lost, but ends."""
        if instance not in self._endings:
            with suppress(MediumError):
                name = ending_name(instance, self._process)
                self._endings[instance] = self._medium.announce(name)

    def carrier_of(self, interface: Any, provider: Provider[Any]) -> Carrier:
        """Return the provider itself: calls within a process do not leave it."""
        return provider

    def connector(
        self,
        name: str,
        here: ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteServiceConnector[RemoteProvider]:
        """Return a connection to a service port of another process. Raises ConnectError."""

        def made(
            consumer: Consumer[Any], selected: str | None, alone: bool
        ) -> RemoteProvider:
            return RemoteProvider(
                self._medium,
                self.peers.description,
                self._timeout,
                consumer,
                there,
                selected,
                alone=alone,
            )

        connector = RemoteServiceConnector(
            name, here, there, properties, made, "in this system"
        )
        self._calls.append(connector)
        self._watch_loss(here.instance, there, name, properties)
        return connector

    def sending(
        self,
        name: str,
        here: OutPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> SendingConnector:
        """Return a connection to an InPort of another process. Raises ConnectError."""
        topic = self._published[here.owner].topics[here.name]

        def is_lost() -> bool:
            return self.peers.is_lost(there.instance)

        connector = SendingConnector(name, topic, here, there, properties, is_lost)
        self._data.append(connector)
        self._watch_loss(here.owner, there, name, properties)
        return connector

    def receiving(
        self,
        name: str,
        here: InPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> ReceivingConnector:
        """Return a connection from an OutPort of another process. Raises ConnectError."""
        connector = ReceivingConnector(
            name, self._medium, there, here, properties, guard
        )
        self._data.append(connector)
        self._watch_loss(here.owner, there, name, properties)
        return connector

    def listen(
        self, there: RemotePort, type_: type[Any], take: Callable[[Any], None]
    ) -> Subscription:
        """Take the values of an OutPort of another process, which waits for none of them.

        Values are taken in a thread of the engine. Raises MediumError.
        """
        arrivals = Arrivals(str(there), type_)

        def on_sample(sample: Sample) -> None:
            value = arrivals.taken(sample)
            if value is not None:
                take(value)

        topic = out_topic(there.instance, there.port, type_)
        subscription = self._medium.subscribe(topic, WATCHING, on_sample)
        arrivals.subscription = subscription
        return subscription

    def give(self, there: RemotePort, type_: type[Any], value: Any) -> None:
        """Give a sample to an InPort of another process. Raises MediumError, CdrError."""
        publisher = self._givers.get(there)
        if publisher is None:
            topic = in_topic(there.instance, there.port, type_)
            publisher = self._givers[there] = self._medium.publisher(topic, DEFAULT)
        publisher.publish(encoder(type_)(value))

    def _watch_loss(
        self, instance: str, there: RemotePort, name: str, properties: Mapping[str, str]
    ) -> None:
        if fails_on_loss(properties):
            self._failing[name] = instance, there.instance

    def _on_presence(self, lost: str, presence: Presence) -> None:
        """Put the components in ERROR that need a lost instance."""
        if presence is Presence.BACK:
            return
        standing = {c.name for c in (*self._data, *self._calls) if c.connected}
        failing = {
            instance: name
            for name, (instance, needed) in tuple(self._failing.items())
            if needed == lost and name in standing
        }
        for instance, name in failing.items():
            published = self._published.get(instance)
            if published is not None and published.component.is_active:
                reason = f"{name}: {lost} {Presence.LOST.value}"
                published.component._request_failure(reason)

    # Other processes

    def await_others(self, seconds: float) -> None:
        """Wait for all connected ports of other processes.

        Raises PortTypeError for incompatible types, ServedElsewhereError.
        """
        deadline = time.monotonic() + seconds
        with _reported():
            for published in self._published.values():
                for topic in published.topics.values():
                    topic.open()
            for connection in self._calls:
                if connection.connected:
                    connection.await_providers(deadline)
            for connector in self._data:
                if connector.connected:
                    self._await_port(connector, deadline)
        for instance in self._published:
            if self.peers.is_elsewhere(instance):
                raise ServedElsewhereError(
                    f"another process of this system runs {instance}, too"
                )

    @property
    def missing(self) -> list[str]:
        """The missing instances of other processes that connections need, sorted."""
        data = [c.ends[1] for c in self._data if c.connected]
        calls = [c.target for c in self._calls if c.connected]
        needed = {there.instance for there in (*data, *calls)}
        return sorted(each for each in needed if not self.peers.is_present(each))

    def await_instance(self, instance: str, seconds: float) -> None:
        """Wait until a process has an instance. Raises TransportError after the time-out [s]."""
        deadline = time.monotonic() + seconds
        while not self.peers.is_present(instance):
            if time.monotonic() > deadline:
                raise TransportError(f"no process of this system has {instance}")
            self.peers.wait(_POLL_INTERVAL)

    def is_ready(self, instance: str, before: Collection[str]) -> bool:
        """Return whether an instance's providers that other processes activate first are ACTIVE."""
        return all(
            self._exists(provider)
            for connector in self._calls
            if connector.connected
            for provider in connector.providers
            if provider.consumer.owner == instance and provider.port.instance in before
        )

    def _exists(self, provider: RemoteProvider) -> bool:
        description = self.peers.fresh(provider.port.instance)
        if description is None:
            return False
        return any(
            each.exists
            for each in description.providers
            if each.port == provider.port.port
        )

    def _await_port(
        self, connector: SendingConnector | ReceivingConnector, deadline: float
    ) -> None:
        here, there = connector.ends
        while not (self._fits(here, there) and connector.matched):
            if time.monotonic() > deadline:
                raise TransportError(
                    f"{here} waits for {there}, which no process of this system has"
                )
            self.peers.wait(_POLL_INTERVAL)

    def _fits(self, here: InPort[Any] | OutPort[Any], there: RemotePort) -> bool:
        """Return whether the other end exists. Raises PortTypeError if it is incompatible."""
        description = self.peers.description(there.instance)
        if description is None:
            return False
        sends = isinstance(here, OutPort)
        ports = description.in_ports if sends else description.out_ports
        port = ports.get(there.port)
        if port is None:
            kind = "InPort" if sends else "OutPort"
            names = ", ".join(ports) or "none"
            raise PortTypeError(f"{there} is not an {kind}; known: {names}")
        _check_type(here, there, port)
        return True


def _check_type(
    here: InPort[Any] | OutPort[Any], there: RemotePort, port: DataPort
) -> None:
    differs = text_difference(definition(here.type._descriptor_), port.definition)
    if differs is not None:
        raise PortTypeError(f"{here} and {there} have different types\n{differs}")


@contextmanager
def _reported() -> Iterator[None]:
    """Convert the errors of engines and of codecs of calls to TransportError."""
    try:
        yield
    except (MediumError, ServiceError) as error:
        raise TransportError(str(error)) from error
