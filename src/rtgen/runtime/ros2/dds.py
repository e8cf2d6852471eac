"""ROS 2 over Cyclone DDS, as rmw_cyclonedds does it: names, USER_DATA, `ros_discovery_info`."""

from __future__ import annotations

import threading
from typing import Any

from cyclonedds import idl
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.qos import Policy
from cyclonedds.qos import Qos as DdsQos
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic

from rtgen.facts import ros_names
from rtgen.facts.ros_qos import (
    GRAPH,
    Durability,
    History,
    Liveliness,
    Profile,
    Reliability,
)
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.dispatcher import Dispatcher
from rtgen.runtime.dds.medium import DOMAINS, configuration
from rtgen.runtime.dds.types import idl_class
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.ros2.graph import Gid, NodeEntitiesInfo, ParticipantEntitiesInfo
from rtgen.runtime.ros2.network import (
    OnMessage,
    Publish,
    Ros2Error,
    RosNode,
    RosTopic,
)

_FOREVER = (1 << 63) - 1
_HEAD = b"\x00\x01\x00\x00"


class DdsNetwork:
    """See `RosNetwork`. `interface` by name or address, loopback by default.

    Raises Ros2Error.
    """

    def __init__(self, node: RosNode, *, interface: str | None = None) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._readers: list[Gid] = []
        self._writers: list[Gid] = []
        self._entities: list[Any] = []
        self._entries: list[Any] = []
        self._closed = False
        try:
            DOMAINS.open(node.domain, configuration(interface))
        except MediumError as error:
            raise Ros2Error(str(error)) from error
        try:
            self._open()
        except MediumError as error:
            DOMAINS.close(node.domain)
            raise Ros2Error(str(error)) from error

    def _open(self) -> None:
        with entities.reported(f"domain {self._node.domain}"):
            data = DdsQos(Policy.Userdata(ros_names.participant_data()))
            self._participant = DomainParticipant(self._node.domain, qos=data)
            self._publisher = Publisher(self._participant)
            self._subscriber = Subscriber(self._participant)
            self._dispatcher = Dispatcher(self._participant, "rtgen ros2")
            graph = RosTopic(ros_names.DISCOVERY_TOPIC, ParticipantEntitiesInfo)
            self._graph = self._writer(ros_names.DISCOVERY_TOPIC, graph, GRAPH)
            self._announce()

    def publisher(self, topic: RosTopic, profile: Profile) -> Publish:
        """See `RosNetwork`."""
        try:
            writer = self._writer(ros_names.dds_topic(topic.name), topic, profile)
            with self._lock:
                self._writers.append(_gid(writer))
                self._announce()
        except MediumError as error:
            raise Ros2Error(str(error)) from error

        def publish(octets: bytes) -> None:
            try:
                entities.write(writer, octets)
            except MediumError as error:
                raise Ros2Error(str(error)) from error

        return publish

    def subscribe(
        self, topic: RosTopic, profile: Profile, on_message: OnMessage
    ) -> None:
        """See `RosNetwork`."""
        try:
            with entities.reported(topic.name):
                reader: Any = DataReader(
                    self._subscriber,
                    self._topic(ros_names.dds_topic(topic.name), topic),
                    _qos(profile, topic.type_hash),
                )
                condition = entities.condition(reader)
            with self._lock:
                self._entities += (condition, reader)
                self._readers.append(_gid(reader))
                self._announce()
        except MediumError as error:
            raise Ros2Error(str(error)) from error

        def take() -> None:
            for octets, info in entities.taken(reader):
                if info.valid_data:
                    on_message(octets)

        self._entries.append(self._dispatcher.add(condition, take))

    def close(self) -> None:
        """See `RosNetwork`."""
        if self._closed:
            return
        self._closed = True
        for entry in self._entries:
            entry.close()
        self._dispatcher.close()
        for entity in self._entities:
            entities.delete(entity)
        entities.delete(self._participant)
        DOMAINS.close(self._node.domain)

    def _topic(self, name: str, topic: RosTopic) -> Any:
        type_name = ros_names.dds_type(topic.type_name)
        own = idl_class(topic.type)
        made = idl.make_idl_struct(
            type_name.replace("::", "_"), type_name, dict(own.__annotations__)
        )
        made.__idl_annotations__["extensibility"] = "final"
        return Topic(self._participant, name, made)

    def _writer(self, name: str, topic: RosTopic, profile: Profile) -> DataWriter[Any]:
        with entities.reported(name):
            qos = _qos(profile, topic.type_hash, writes=True)
            writer: DataWriter[Any] = DataWriter(
                self._publisher, self._topic(name, topic), qos
            )
        self._entities.append(writer)
        return writer

    def _announce(self) -> None:
        """Tell other nodes which readers and writers this one has."""
        node = NodeEntitiesInfo(
            node_namespace=self._node.namespace,
            node_name=self._node.name,
            reader_gid_seq=list(self._readers),
            writer_gid_seq=list(self._writers),
        )
        own = ParticipantEntitiesInfo(_gid(self._participant), [node])
        entities.write(self._graph, _HEAD + own.to_cdr(True))


def _gid(entity: Any) -> Gid:
    return Gid(entity.guid.bytes)


def _qos(profile: Profile, type_hash: str, *, writes: bool = False) -> DdsQos:
    history = (
        Policy.History.KeepAll
        if profile.history is History.KEEP_ALL
        else Policy.History.KeepLast(profile.depth)
    )
    reliable = profile.reliability is Reliability.RELIABLE
    durable = profile.durability is Durability.TRANSIENT_LOCAL
    lease = _FOREVER if profile.lease is None else profile.lease
    policies: list[Any] = [
        history,
        (
            Policy.Reliability.Reliable(_FOREVER)
            if reliable
            else Policy.Reliability.BestEffort
        ),
        Policy.Durability.TransientLocal if durable else Policy.Durability.Volatile,
        (
            Policy.Liveliness.ManualByTopic(lease)
            if profile.liveliness is Liveliness.MANUAL_BY_TOPIC
            else Policy.Liveliness.Automatic(lease)
        ),
        Policy.Userdata(ros_names.user_data(type_hash)),
        Policy.DataRepresentation(True, False),
    ]
    if durable:
        policies.append(Policy.DurabilityService(0, history, -1, -1, -1))
    if profile.deadline is not None:
        policies.append(Policy.Deadline(profile.deadline))
    if writes:
        policies.append(Policy.WriterDataLifecycle(False))
        if profile.lifespan is not None:
            policies.append(Policy.Lifespan(profile.lifespan))
    return DdsQos(*policies)
