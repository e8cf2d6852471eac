"""Operations of service ports as services of ROS 2: both its servers and its clients.

An operation is a service if it takes a request of ROS 2 and returns the response:
`std_srvs::srv::SetBool_Response set(in std_srvs::srv::SetBool_Request request)`.
"""

from __future__ import annotations

from _thread import interrupt_main
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeAlias

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.distribution.workers import Workers
from rtgen.runtime.errors import RtcError
from rtgen.runtime.failures import ends_run, log
from rtgen.runtime.marshalling.descriptors import StructDescriptor, plain
from rtgen.runtime.ros2.types import (
    decoded,
    request_of,
    ros_name,
    service_hash,
    type_hash,
)
from rtgen.runtime.services import calls
from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.servants import MarshalError, ObjectNotExist, ServiceError

_HEAD = b"\x00\x01\x00\x00"

Reply: TypeAlias = Callable[[bytes], None]
"""Sends a serialized response with its encapsulation header; from any thread, once."""
OnRequest: TypeAlias = Callable[[bytes, Reply], None]
Call: TypeAlias = Callable[[bytes, float], bytes]
"""Sends a request and waits for its response, at most so many seconds. Raises ServiceError."""


@dataclass(frozen=True)
class RosService:
    """A service: its fully qualified name, and the generated classes of its two messages.

    `event_info` is the class of service_msgs/msg/ServiceEventInfo, of which its hash is made.
    `node` is the node that shows it, in the network's namespace; by default the network's own.
    """

    name: str
    request: type[Any]
    response: type[Any]
    event_info: type[Any]
    node: str = ""

    @cached_property
    def type_name(self) -> str:
        """`std_srvs/srv/SetBool`."""
        return str(ros_name(self.request)).removesuffix("_Request")

    @cached_property
    def type_hash(self) -> str:
        """`RIHS01_...` of the service itself."""
        return service_hash(self.request, self.response, self.event_info)

    @cached_property
    def hashes(self) -> tuple[str, str]:
        """Those of request and response."""
        return type_hash(self.request), type_hash(self.response)


@dataclass(frozen=True, slots=True)
class ServiceJoint:
    """An operation of a provider or consumer with the service that it is."""

    port: Provider[Any] | Consumer[Any]
    operation: str
    service: RosService


def messages_of(interface: type[Any], operation: str) -> tuple[type[Any], type[Any]]:
    """Request and response of an operation. Raises ServiceError if it is not a service."""
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


def _only(body: type[Any] | None) -> type[Any] | None:
    """The struct that a body consists of; None for other bodies."""
    members = () if body is None else body._descriptor_.members
    match [plain(member.type) for member in members]:
        case [StructDescriptor() as struct]:
            class_: type[Any] = struct.class_
            return class_
    return None


class Server:
    """Answers the requests of a service by a function, in threads of its own.

    ROS 2 has no errors: a call that fails has no response.
    """

    def __init__(
        self, service: RosService, answer: Callable[[Any], Any], workers: Workers
    ) -> None:
        self._service = service
        self._function = answer
        self._workers = workers

    def take(self, octets: bytes, reply: Reply) -> None:
        """Answer soon."""
        if not self._workers.submit(partial(self._answer, octets, reply)):
            log.warning("%s: too many calls wait", self._service.name)

    def _answer(self, octets: bytes, reply: Reply) -> None:
        name = self._service.name
        try:
            response = self._function(decoded(self._service.request, octets))
            reply(_HEAD + response.to_cdr(True))
        except (CdrError, MediumError, RtcError, ServiceError) as error:
            log.warning("%s: a request has no response: %s", name, error)
        except BaseException as error:
            if ends_run(error):
                # This is not a thread of the run; that ends in the main thread.
                interrupt_main()
                return
            log.exception("%s: a request cannot be answered", name)


def _carried_out(joint: ServiceJoint) -> Callable[[Any], Any]:
    provider = joint.port
    assert isinstance(provider, Provider)
    return lambda request: provider.carry_out(joint.operation, (request,))


class _Carrier:
    """Carries the calls of a consumer to services, each by its operation."""

    reachable = True

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._calls: dict[str, tuple[Call, type[Any]]] = {}

    def add(self, operation: str, call: Call, response: type[Any]) -> None:
        """Carry the calls of an operation."""
        self._calls[operation] = call, response

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """See `Carrier`. Raises ServiceError, CdrError."""
        if operation not in self._calls:
            raise ObjectNotExist(f"{operation!r} is not a service of ROS 2")
        call, response = self._calls[operation]
        request: Any = arguments[0]
        octets = call(_HEAD + request.to_cdr(True), self._timeout)
        try:
            return decoded(response, octets)
        except CdrError as error:
            raise MarshalError(
                f"{operation}: the response is wrong: {error}"
            ) from error


class RosServices:
    """The operations of a system that are services, until `close`; the network stays open."""

    def __init__(
        self, network: Any, joints: Iterable[ServiceJoint], timeout: float = 10.0
    ) -> None:
        """`network` is a RosNetwork. Raises Ros2Error."""
        self._workers = Workers()
        self._consumers: dict[int, tuple[Consumer[Any], _Carrier]] = {}
        for joint in joints:
            if isinstance(joint.port, Provider):
                server = Server(joint.service, _carried_out(joint), self._workers)
                network.serve(joint.service, server.take)
                continue
            carrier = self._carrier(joint.port, timeout)
            call = network.client(joint.service)
            carrier.add(joint.operation, call, joint.service.response)

    def _carrier(self, consumer: Consumer[Any], timeout: float) -> _Carrier:
        known = self._consumers.get(id(consumer))
        if known is None:
            known = consumer, _Carrier(timeout)
            self._consumers[id(consumer)] = known
            consumer._provider = known[1]
        return known[1]

    def close(self) -> None:
        """Serve no more."""
        self._workers.close()
        for consumer, carrier in self._consumers.values():
            if consumer._provider is carrier:
                consumer._provider = None
