"""Networks of ROS 2: a naming of topics and services over a messaging engine."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property, partial
from typing import Any, TypeAlias

import msgspec

from rtgen.facts import ros_names
from rtgen.facts.ros_qos import Durability, History, Profile, Reliability
from rtgen.runtime.distribution.medium import (
    Client,
    MediumError,
    Messaging,
    NotServedError,
    OnRequest,
    PeerLostError,
    Qos,
    ReplyTimeoutError,
    Sample,
    ServiceTypes,
    Subscription,
    Token,
    Topic,
)
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.qos import QosWatch
from rtgen.runtime.ros2.turns import Turns
from rtgen.runtime.ros2.types import (
    Described,
    ros_name,
    service_description,
    service_hash,
    type_description,
    type_hash,
)
from rtgen.runtime.services.servants import (
    CallEnded,
    CallTimeout,
    CommunicationFailure,
    ObjectNotExist,
    ServiceError,
)

_PATIENCE = 0.5
"""Seconds that a message waits for slow subscriptions."""


class Ros2Error(Exception):
    """A port cannot be a topic, or the network cannot work as configured."""


class RosTopic(Topic, frozen=True, dict=True):
    """A topic: its fully qualified name, and the generated class of its messages.

    `node` is the node that shows it, in the network's namespace; by default the network's own.
    """

    node: str = ""

    @cached_property
    def type_name(self) -> str:
        """The type's name, `std_msgs/msg/Float32`. Raises Ros2Error for other classes."""
        name = ros_name(self.type)
        if name is None:
            own = self.type._descriptor_.name
            raise Ros2Error(f"{self.name}: {own} is not a message of ROS 2")
        return name

    @cached_property
    def type_hash(self) -> str:
        """The type's hash, `RIHS01_...`."""
        return type_hash(self.type)

    @property
    def described(self) -> Described:
        """The type's description."""
        return type_description(self.type)


class RosService(ServiceTypes, frozen=True, dict=True):
    """A service: the generated classes of its two messages, and its fully qualified name.

    `event_info` is the class of service_msgs/msg/ServiceEventInfo, for its hash. `node` is the node
    that shows it, in the network's namespace; by default the network's own.
    """

    name: str
    event_info: type[Any]
    node: str = ""

    @cached_property
    def type_name(self) -> str:
        """The type's name, `std_srvs/srv/SetBool`."""
        return str(ros_name(self.request)).removesuffix("_Request")

    @cached_property
    def type_hash(self) -> str:
        """The hash `RIHS01_...` of the service itself."""
        return service_hash(self.request, self.reply, self.event_info)

    @property
    def described(self) -> Described:
        """The description of the service itself."""
        return service_description(self.request, self.reply, self.event_info)

    @cached_property
    def hashes(self) -> tuple[str, str]:
        """The hashes of request and response."""
        return type_hash(self.request), type_hash(self.reply)


class RosQos(Qos, frozen=True, gc=False):
    """The QoS of an end with its profile, which has policies that only ROS 2 knows."""

    profile: Profile = Profile()

    @classmethod
    def of(cls, profile: Profile) -> RosQos:
        """Return the QoS of a profile."""
        return cls(
            reliable=profile.reliability is Reliability.RELIABLE,
            depth=None if profile.history is History.KEEP_ALL else profile.depth,
            patience=_PATIENCE,
            durable=profile.durability is Durability.TRANSIENT_LOCAL,
            profile=profile,
        )


class RosNode(msgspec.Struct, frozen=True, gc=False):
    """A node of a process, with its domain."""

    name: str
    namespace: str = "/"
    domain: int = 0

    def qualified(self, name: str) -> str:
        """Return the name of a topic in the node's namespace. Raises Ros2Error."""
        try:
            return ros_names.qualified(name, self.namespace)
        except ValueError as error:
            raise Ros2Error(str(error)) from error


OnMessage: TypeAlias = Callable[[bytes], None]
"""Function called with a serialized message and its encapsulation header, in a network thread."""
Call: TypeAlias = Callable[[bytes, float], bytes]
"""Function that sends a request and waits for its response. Raises ServiceError.

The second argument is the time-out in seconds.
"""
Publish: TypeAlias = Callable[[bytes], None]
"""Function that sends a serialized message with encapsulation header; from one thread at a time."""


Observer: TypeAlias = Callable[[RosTopic, Profile, bool], OnMessage | None]
"""Function called with the topic and profile of each end, True for one that publishes.

It returns a function that gets the end's messages, in the thread of a writer or of the network.
"""


class RosNetwork:
    """Nodes of one process on one network, whose medium it owns. Methods raise Ros2Error.

    The medium takes `RosTopic`, `RosService` and `RosQos`.
    """

    def __init__(self, medium: Messaging[RosTopic, RosQos, RosService]) -> None:
        self.medium = medium
        self.turns: Turns | None = None
        """In simulated time, what does the work of messages and requests."""
        self.used: dict[str, dict[str, RosTopic | RosService]] = {}
        """An end for each type that a node uses, by the names of node and type."""
        self._ends: list[Token] = []
        self._clients: list[Client] = []
        self._observers: list[Observer] = []
        self._qos = QosWatch()
        self._ending = threading.Lock()
        self._times_ended = 0

    def observe(self, observer: Observer) -> None:
        """Show the messages of ends that are made from now on to an observer."""
        self._observers.append(observer)

    def _observed(
        self, topic: RosTopic, profile: Profile, *, sent: bool
    ) -> list[OnMessage]:
        observed = (observer(topic, profile, sent) for observer in self._observers)
        return [each for each in observed if each is not None]

    def _use(self, end: RosTopic | RosService) -> None:
        self.used.setdefault(end.node, {}).setdefault(end.type_name, end)

    def publisher(self, topic: RosTopic, profile: Profile) -> Publish:
        """Return a publisher of a topic."""
        self._use(topic)
        with _as_ros2(topic.name):
            publisher = self.medium.publisher(topic, RosQos.of(profile))
        self._ends.append(publisher)
        self._qos.add(topic.name, publisher, profile, writes=True)
        observed = self._observed(topic, profile, sent=True)

        def publish(octets: bytes) -> None:
            with _as_ros2(topic.name):
                publisher.publish(octets)
            for each in observed:
                each(octets)

        return publish

    def subscribe(
        self, topic: RosTopic, profile: Profile, on_message: OnMessage
    ) -> Subscription:
        """Receive the messages of a topic until `close`."""
        self._use(topic)
        observed = self._observed(topic, profile, sent=False)

        def handle(octets: bytes) -> None:
            try:
                for each in observed:
                    each(octets)
                on_message(octets)
            except Exception:
                log.exception("a message of %s cannot be handled", topic.name)

        def take(sample: Sample) -> None:
            if self.turns is None:
                handle(sample.octets)
            else:
                self.turns.post(partial(handle, sample.octets))

        with _as_ros2(topic.name):
            subscription = self.medium.subscribe(topic, RosQos.of(profile), take)
        self._ends.append(subscription)
        self._qos.add(topic.name, subscription, profile, writes=False)
        return subscription

    def serve(self, service: RosService, on_request: OnRequest) -> None:
        """Serve a service until `close`."""
        self._use(service)
        with _as_ros2(service.name):
            self._ends.append(self.medium.serve(service.name, (service,), on_request))

    def client(self, service: RosService) -> Call:
        """Return a client of a service."""
        self._use(service)
        with _as_ros2(service.name):
            client = self.medium.client(service.name, service)
        self._clients.append(client)

        def call(octets: bytes, timeout: float) -> bytes:
            before = self._times_ended
            try:
                return client.call(octets, timeout)
            except MediumError as error:
                with self._ending:
                    ended = self._times_ended != before
                if ended:
                    raise CallEnded(
                        f"the run ended while a call of {service.name} waited"
                    ) from None
                raise _service_error(service.name, error) from error

        return call

    def end_calls(self) -> None:
        """Make calls that wait raise CallEnded."""
        with self._ending:
            self._times_ended += 1
            for client in self._clients:
                client.cancel()

    def close(self) -> None:
        """Close the network with all nodes."""
        self._qos.close()
        self.medium.close()


@contextmanager
def _as_ros2(name: str) -> Iterator[None]:
    try:
        yield
    except MediumError as error:
        raise Ros2Error(f"{name}: {error}") from error


def _service_error(service: str, error: MediumError) -> ServiceError:
    match error:
        case NotServedError():
            return ObjectNotExist(str(error))
        case PeerLostError():
            return CommunicationFailure(f"{service} is served no more")
        case ReplyTimeoutError():
            return CallTimeout(f"no response of {service}")
    return CommunicationFailure(f"{service}: {error}")
