"""ROS 2 over rclpy of the sourced installation, with any middleware that it has."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import partial
from typing import Any, TypeVar

import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

from rtgen.facts.ros_qos import PROFILES, Profile
from rtgen.runtime.distribution.medium import MediumError, OnRequest, OnSample, Token
from rtgen.runtime.freed_memory import keep_freed_memory
from rtgen.runtime.ros2.network import (
    Ros2Error,
    RosNetwork,
    RosNode,
    RosQos,
    RosService,
    RosTopic,
)
from rtgen.runtime.ros2.qos import Own, Peers
from rtgen.runtime.ros2.rclpy_ends import (
    Client,
    Publisher,
    Server,
    Subscription,
    Waiter,
    reported,
)
from rtgen.runtime.ros2.rclpy_qos import OF_PUBLISHER, OF_SUBSCRIPTION, Status
from rtgen.runtime.ros2.rclpy_types import installed

_SERVICE = PROFILES["services_default"]
_T = TypeVar("_T", bound=Token)


def middleware() -> str:
    """Return the middleware that nodes have, `rmw_fastrtps_cpp`. Raises Ros2Error."""
    try:
        with reported("rclpy"):
            return str(rclpy.get_rmw_implementation_identifier())
    except MediumError as error:
        raise Ros2Error(str(error)) from error


def open_rclpy(node: RosNode) -> RosNetwork:
    """Open a network. Raises Ros2Error."""
    try:
        return RosNetwork(RosRclpy(node))
    except MediumError as error:
        raise Ros2Error(str(error)) from error


class RosRclpy:
    """The nodes of one process on rclpy; see `Messaging`. Raises MediumError.

    It has a context of its own, so neither handles signals nor reads the command line.
    """

    def __init__(self, node: RosNode) -> None:
        keep_freed_memory()
        self._node = node
        self._lock = threading.Lock()
        self._nodes: dict[str, Node] = {}
        self._open: list[Token] = []
        self._closed = False
        self._peers = Peers()
        self._context = Context()
        with reported("rclpy"):
            self._context.init(args=[], initialize_logging=False, domain_id=node.domain)
            self._topics = Waiter(self._context, "ros2-topics")
            self._services = Waiter(self._context, "ros2-services")
        try:
            self._node_of("")
        except MediumError:
            self.close()
            raise

    def publisher(self, topic: RosTopic, qos: RosQos) -> Publisher:
        """See `Messaging`."""
        class_ = installed(topic.type_name, topic.type_hash)
        node = self._node_of(topic.node)
        with reported(topic.name):
            silent = PublisherEventCallbacks(use_default_callbacks=False)
            publisher = node.create_publisher(
                class_, topic.name, _qos(qos.profile), event_callbacks=silent
            )
            status = self._status(topic, node, publisher, qos.profile, writes=True)
        return self._keep(Publisher(node, publisher, status, is_durable=qos.durable))

    def subscribe(
        self, topic: RosTopic, qos: RosQos, on_sample: OnSample
    ) -> Subscription:
        """See `Messaging`."""
        class_ = installed(topic.type_name, topic.type_hash)
        node = self._node_of(topic.node)
        with reported(topic.name):
            silent = SubscriptionEventCallbacks(use_default_callbacks=False)
            subscription = node.create_subscription(
                class_,
                topic.name,
                _unused,
                _qos(qos.profile),
                event_callbacks=silent,
                raw=True,
            )
            status = self._status(topic, node, subscription, qos.profile, writes=False)
            return self._keep(
                Subscription(node, subscription, on_sample, self._topics, status)
            )

    def _status(
        self, topic: RosTopic, node: Node, end: Any, profile: Profile, *, writes: bool
    ) -> Status:
        """Return the QoS events of an end."""
        name = node.get_fully_qualified_name()
        own = Own(f"{end.handle.pointer} {writes}", name, profile, writes)
        types = OF_PUBLISHER if writes else OF_SUBSCRIPTION
        others = (
            node.get_subscriptions_info_by_topic
            if writes
            else node.get_publishers_info_by_topic
        )
        return Status(
            end.handle, types, own, topic, self._peers, partial(others, topic.name)
        )

    def serve(
        self, service: str, types: Sequence[RosService], on_request: OnRequest
    ) -> Token:
        """See `Messaging`."""
        [described] = types
        class_ = installed(described.type_name, described.type_hash)
        node = self._node_of(described.node)
        with reported(service):
            server = node.create_service(
                class_, service, _unused, qos_profile=_qos(_SERVICE)
            )
            return self._keep(Server(node, server, on_request, self._services))

    def client(self, service: str, types: RosService) -> Client:
        """See `Messaging`."""
        class_ = installed(types.type_name, types.type_hash)
        node = self._node_of(types.node)
        with reported(service):
            client = node.create_client(class_, service, qos_profile=_qos(_SERVICE))
            return self._keep(Client(node, client, service, self._services))

    def close(self) -> None:
        """See `Messaging`."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        for end in self._open:
            end.close()
        for waiter in (self._topics, self._services):
            waiter.close()
        for node in self._nodes.values():
            node.destroy_node()
        self._context.try_shutdown()
        self._context.destroy()

    def _node_of(self, name: str) -> Node:
        """Return a node of this process; without a name, its own."""
        name = name or self._node.name
        with self._lock, reported(name):
            if name not in self._nodes:
                self._nodes[name] = Node(
                    name,
                    context=self._context,
                    namespace=self._node.namespace,
                    use_global_arguments=False,
                    enable_rosout=False,
                    start_parameter_services=False,
                    parameter_overrides=[
                        Parameter("start_type_description_service", value=False)
                    ],
                )
            return self._nodes[name]

    def _keep(self, end: _T) -> _T:
        with self._lock:
            self._open.append(end)
        return end


def _unused(*_: Any) -> None:
    """Stand for the callback of an end, which rclpy's executor would call."""


def _qos(profile: Profile) -> QoSProfile:
    """Return a profile as rclpy has it; policies have the same numbers."""
    times = {
        "deadline": profile.deadline,
        "lifespan": profile.lifespan,
        "liveliness_lease_duration": profile.lease,
    }
    return QoSProfile(
        history=HistoryPolicy(profile.history),
        depth=profile.depth,
        reliability=ReliabilityPolicy(profile.reliability),
        durability=DurabilityPolicy(profile.durability),
        liveliness=LivelinessPolicy(profile.liveliness),
        **{
            key: Duration(nanoseconds=time)
            for key, time in times.items()
            if time is not None
        },
    )
