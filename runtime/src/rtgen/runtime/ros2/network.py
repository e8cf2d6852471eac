"""Interface of the networks of ROS 2, and the names of topics and services on them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Protocol, TypeAlias

import msgspec

from rtgen.facts import ros_names
from rtgen.facts.ros_qos import Profile
from rtgen.runtime.ros2.types import ros_name, service_hash, type_hash


class Ros2Error(Exception):
    """A port cannot be a topic, or the network cannot work as configured."""


class RosTopic(msgspec.Struct, frozen=True, dict=True):
    """A topic: its fully qualified name, and the generated class of its messages.

    `node` is the node that shows it, in the network's namespace; by default the network's own.
    """

    name: str
    type: type[Any]
    node: str = ""

    @cached_property
    def type_name(self) -> str:
        """The type's name, `std_msgs/msg/Float32`. Raises Ros2Error for other classes."""
        found = ros_name(self.type)
        if found is None:
            own = self.type._descriptor_.name
            raise Ros2Error(f"{self.name}: {own} is not a message of ROS 2")
        return found

    @cached_property
    def type_hash(self) -> str:
        """The type's hash, `RIHS01_...`."""
        return type_hash(self.type)


class RosService(msgspec.Struct, frozen=True, dict=True):
    """A service: its fully qualified name, and the generated classes of its two messages.

    `event_info` is the class of service_msgs/msg/ServiceEventInfo, for its hash. `node` is the node
    that shows it, in the network's namespace; by default the network's own.
    """

    name: str
    request: type[Any]
    response: type[Any]
    event_info: type[Any]
    node: str = ""

    @cached_property
    def type_name(self) -> str:
        """The type's name, `std_srvs/srv/SetBool`."""
        return str(ros_name(self.request)).removesuffix("_Request")

    @cached_property
    def type_hash(self) -> str:
        """The hash `RIHS01_...` of the service itself."""
        return service_hash(self.request, self.response, self.event_info)

    @cached_property
    def hashes(self) -> tuple[str, str]:
        """The hashes of request and response."""
        return type_hash(self.request), type_hash(self.response)


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
Reply: TypeAlias = Callable[[bytes], None]
"""Function that sends a serialized response with encapsulation header; from any thread, once."""
OnRequest: TypeAlias = Callable[[bytes, Reply], None]
Call: TypeAlias = Callable[[bytes, float], bytes]
"""Function that sends a request and waits for its response. Raises ServiceError.

The second argument is the time-out in seconds.
"""
Publish: TypeAlias = Callable[[bytes], None]
"""Function that sends a serialized message with encapsulation header; from one thread at a time."""


class RosNetwork(Protocol):
    """Nodes of one process on one network. Methods raise Ros2Error."""

    def publisher(self, topic: RosTopic, profile: Profile) -> Publish:
        """Return a publisher of a topic."""

    def subscribe(
        self, topic: RosTopic, profile: Profile, on_message: OnMessage
    ) -> None:
        """Receive the messages of a topic until `close`."""

    def serve(self, service: RosService, on_request: OnRequest) -> None:
        """Serve a service until `close`."""

    def client(self, service: RosService) -> Call:
        """Return a client of a service."""

    def end_calls(self) -> None:
        """Make calls that wait raise CallEnded."""

    def close(self) -> None:
        """Close the network with all nodes."""
