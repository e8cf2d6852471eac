"""Operations of service ports as ROS 2 services, both servers and clients.

An operation is a service if its argument is a request of ROS 2 and its result the response:
`std_srvs::srv::SetBool_Response set(in std_srvs::srv::SetBool_Request request)`.
"""

from __future__ import annotations

import threading
import time
from _thread import interrupt_main
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

import msgspec

from rtgen.facts.ros_qos import Profile
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.medium import MediumError, Reply
from rtgen.runtime.distribution.workers import Workers
from rtgen.runtime.errors import RtcError
from rtgen.runtime.failures import ends_run, log
from rtgen.runtime.marshalling.descriptors import StructDescriptor, plain
from rtgen.runtime.return_codes import ACTIVE_STATE
from rtgen.runtime.ros2.network import (
    Call,
    Ros2Error,
    RosNetwork,
    RosService,
    RosTopic,
)
from rtgen.runtime.ros2.turns import Turns
from rtgen.runtime.ros2.types import decoded, encoded, request_of
from rtgen.runtime.services import calls
from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.servants import (
    CommunicationFailure,
    MarshalError,
    ObjectNotExist,
    ServiceError,
)

if TYPE_CHECKING:
    from rtgen.runtime.system.records import StateRecord
    from rtgen.runtime.system.system import System

_MAX_EARLY = 64
_EARLY_LIFETIME = 10.0
"""Number of requests of an operation that wait for its component, and for how long [s]."""
_NO_LIMIT = 86_400.0
"""Time-out of calls without a limit, in seconds; the loss of the server ends them."""


class ServiceJoint(msgspec.Struct, frozen=True):
    """An operation of a provider or consumer with its service.

    `waits`: the response has no time limit.
    """

    port: Provider[Any] | Consumer[Any]
    operation: str
    service: RosService
    waits: bool = False


class EventJoint(msgspec.Struct, frozen=True):
    """A oneway operation with its topic: a consumer publishes, a provider receives."""

    port: Provider[Any] | Consumer[Any]
    operation: str
    topic: RosTopic
    profile: Profile


class Answer(msgspec.Struct, frozen=True):
    """A service that a function answers; requests of one `queue` do not delay those of others."""

    service: RosService
    function: Callable[[Any], Any]
    queue: str | None = None


def messages_of(interface: type[Any], operation: str) -> tuple[type[Any], type[Any]]:
    """Return request and response of an operation. Raises ServiceError if it is not a service."""
    call = calls.calls_of(interface).get(operation)
    name = f"{interface._descriptor_.name}::{operation}"
    if call is None:
        known = ", ".join(calls.calls_of(interface)) or "none"
        raise ServiceError(f"there is no operation {name}; known: {known}")
    request, response = _only(call.request), _only(call.reply)
    service = request_of(request)
    if service is None or response is None or call.raises:
        raise ServiceError(f"{name} does not take a request of ROS 2 alone")
    if str(response._descriptor_.name) != f"{service}_Response":
        raise ServiceError(f"{name} does not return {service}_Response")
    assert request is not None
    return request, response


def message_of(interface: type[Any], operation: str) -> type[Any]:
    """Return the only argument of an operation, a message. Raises ServiceError."""
    message = _only(calls.calls_of(interface)[operation].request)
    if message is None:
        name = interface._descriptor_.name
        raise ServiceError(f"{name}::{operation} does not take a message alone")
    return message


def _only(body: type[Any] | None) -> type[Any] | None:
    """Return the struct that is the whole body; None for other bodies."""
    members = () if body is None else body._descriptor_.members
    match [plain(member.type) for member in members]:
        case [StructDescriptor() as struct]:
            class_: type[Any] = struct.class_
            return class_
    return None


class _Start:
    """Keeps the requests to a provider that come before its component is ACTIVE for the first time.

    ROS 2 has no errors: their clients, who see the service, would wait in vain.
    """

    def __init__(self, provider: Provider[Any]) -> None:
        self.instance = provider.owner
        self._provider = provider
        self._lock = threading.Lock()
        self._has_begun = False
        self._requests: list[tuple[float, Callable[[], None]]] = []

    def keep(self, request: Callable[[], None]) -> bool:
        """Return whether a request waits; it is called later."""
        with self._lock:
            if self._has_begun or self._provider.exists:
                return False
            latest = time.monotonic() - _EARLY_LIFETIME
            self._requests = [each for each in self._requests if each[0] > latest]
            if len(self._requests) >= _MAX_EARLY:
                return False
            if not self._requests:
                log.warning(
                    "%s: a request waits until the component is active", self._provider
                )
            self._requests.append((time.monotonic(), request))
            return True

    def begin(self) -> None:
        """Let the requests go on, except those that have waited for too long."""
        with self._lock:
            self._has_begun = True
            requests, self._requests = self._requests, []
        latest = time.monotonic() - _EARLY_LIFETIME
        for came, request in requests:
            if came > latest:
                request()


class Server(msgspec.Struct, eq=False):
    """Answers the requests of a service by a function, in separate threads.

    ROS 2 has no errors: a failed call has no response. Requests of one `queue` do not delay those
    of others.
    """

    _service: RosService
    _function: Callable[[Any], Any]
    _workers: Workers
    _queue: str | None = None
    start: _Start | None = None

    def take(self, octets: bytes, reply: Reply) -> None:
        """Queue a request."""
        work = partial(self._answer, octets, reply)
        if self.start is None or not self.start.keep(partial(self._submit, work)):
            self._submit(work)

    def _submit(self, work: Callable[[], None]) -> None:
        if not self._workers.submit(work, self._queue):
            log.warning("%s: a request is left out: too many wait", self._service.name)

    def _answer(self, octets: bytes, reply: Reply) -> None:
        name = self._service.name
        try:
            response = self._function(decoded(self._service.request, octets))
            reply(encoded(response))
        except (CdrError, MediumError, RtcError, ServiceError) as error:
            log.warning("%s: a request has no response: %s", name, error)
        except BaseException as error:
            if ends_run(error):
                # This is not a thread of the run, which ends in the main thread.
                interrupt_main()
                return
            log.exception("%s: a request cannot be answered", name)


class _Receiver:
    """Passes the messages of a topic to a provider, in order."""

    def __init__(
        self, joint: EventJoint, workers: Workers, turns: Turns | None
    ) -> None:
        self._joint = joint
        self._workers = workers
        self._turns = turns

    def take(self, octets: bytes) -> None:
        """Queue a message."""
        if self._turns is not None:
            self._hand_on(octets)  # It is its turn.
        elif not self._workers.submit(partial(self._hand_on, octets)):
            log.warning(
                "%s: a message is left out: too many wait", self._joint.topic.name
            )

    def _hand_on(self, octets: bytes) -> None:
        topic, provider = self._joint.topic, self._joint.port
        assert isinstance(provider, Provider)
        try:
            message = decoded(topic.type, octets)
            provider.carry_out(self._joint.operation, (message,))
        except CdrError as error:
            log.warning("%s: a message cannot be decoded: %s", topic.name, error)
        except ServiceError as error:
            log.debug("%s: a message is left out: %s", topic.name, error)
        except BaseException as error:
            if not ends_run(error):
                log.exception("%s: a message cannot be handled", topic.name)
                return
            interrupt_main()


def _carried_out(joint: ServiceJoint, turns: Turns | None) -> Callable[[Any], Any]:
    provider = joint.port
    assert isinstance(provider, Provider)

    def carry_out(request: Any) -> Any:
        return provider.carry_out(joint.operation, (request,))

    return _in_turn(carry_out, None if joint.waits else turns)


def _in_turn(
    function: Callable[[Any], Any], turns: Turns | None
) -> Callable[[Any], Any]:
    """Return the function as it is called in the thread of simulated time."""
    if turns is None:
        return function
    return lambda request: turns.call(lambda: function(request))


def _requested(joint: ServiceJoint, call: Call, timeout: float) -> Callable[[Any], Any]:
    def carry(request: Any) -> Any:
        octets = call(encoded(request), timeout)
        try:
            return decoded(joint.service.reply, octets)
        except CdrError as error:
            raise MarshalError(
                f"{joint.operation}: the response is wrong: {error}"
            ) from error

    return carry


def _published(publish: Callable[[bytes], None]) -> Callable[[Any], None]:
    lock = threading.Lock()

    def carry(message: Any) -> None:
        octets = encoded(message)
        try:
            with lock:
                publish(octets)
        except Ros2Error as error:
            raise CommunicationFailure(str(error)) from error

    return carry


class _Carrier:
    """Makes the calls of a consumer, by operation."""

    reachable = True

    def __init__(self) -> None:
        self.operations: dict[str, Callable[[Any], object]] = {}

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """See `Carrier`. Raises ServiceError, CdrError."""
        if operation not in self.operations:
            raise ObjectNotExist(f"{operation!r} is not a service of ROS 2")
        return self.operations[operation](arguments[0])


class RosServices:
    """The operations of a system visible in ROS 2, until `close`; the network stays open."""

    def __init__(
        self,
        network: RosNetwork,
        joints: Iterable[ServiceJoint | EventJoint],
        timeout: float = 10.0,
        answers: Iterable[Answer] = (),
        *,
        system: System | None = None,
    ) -> None:
        """Serve and connect the operations. Raises Ros2Error.

        Requests that come before a component of `system` is ACTIVE for the first time wait for it.
        Those of `answers` that the network cannot serve are reported and left out.
        """
        self._network = network
        self._timeout = timeout
        self._short = Workers()
        self._in_order = Workers(1)
        self._workers = [self._short, self._in_order]
        self._consumers: dict[int, tuple[Consumer[Any], _Carrier]] = {}
        self._starts: list[_Start] = []
        self._system = system
        if system is not None:
            system.watch_states(self._on_state)
        for joint in joints:
            if isinstance(joint, EventJoint):
                self._join_event(joint)
            else:
                self._join_service(joint)
        failures: list[str] = []
        for each in answers:
            function = _in_turn(each.function, network.turns)
            server = Server(each.service, function, self._short, each.queue)
            try:
                network.serve(each.service, server.take)
            except Ros2Error as error:
                failures.append(str(error))
        if failures:
            log.warning("services without a server: %d, %s", len(failures), failures[0])

    def _join_service(self, joint: ServiceJoint) -> None:
        if isinstance(joint.port, Provider):
            workers = self._short
            if joint.waits:
                # Calls that wait must not block the responses to others.
                workers = Workers()
                self._workers.append(workers)
            carry_out = _carried_out(joint, self._network.turns)
            start = None
            if self._system is not None:
                start = _Start(joint.port)
                self._starts.append(start)
            server = Server(joint.service, carry_out, workers, start=start)
            self._network.serve(joint.service, server.take)
            return
        call = self._network.client(joint.service)
        timeout = _NO_LIMIT if joint.waits else self._timeout
        carrier = self._carrier(joint.port)
        carrier.operations[joint.operation] = _requested(joint, call, timeout)

    def _on_state(self, record: StateRecord) -> None:
        if record.after is ACTIVE_STATE:
            for start in self._starts:
                if start.instance == record.instance:
                    start.begin()

    def _join_event(self, joint: EventJoint) -> None:
        if isinstance(joint.port, Provider):
            receiver = _Receiver(joint, self._in_order, self._network.turns)
            self._network.subscribe(joint.topic, joint.profile, receiver.take)
            return
        publish = self._network.publisher(joint.topic, joint.profile)
        carrier = self._carrier(joint.port)
        carrier.operations[joint.operation] = _published(publish)

    def _carrier(self, consumer: Consumer[Any]) -> _Carrier:
        known = self._consumers.get(id(consumer))
        if known is None:
            known = consumer, _Carrier()
            self._consumers[id(consumer)] = known
            consumer._provider = known[1]
        return known[1]

    def close(self) -> None:
        """Stop serving."""
        self._starts.clear()
        for workers in self._workers:
            workers.close()
        for consumer, carrier in self._consumers.values():
            if consumer._provider is carrier:
                consumer._provider = None
