"""ROS 2 over Cyclone DDS, as in rmw_cyclonedds: names, USER_DATA, `ros_discovery_info`."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple, TypeVar

from cyclonedds import idl
from cyclonedds.idl.types import int64, uint64
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.qos import Policy
from cyclonedds.qos import Qos as DdsQos
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic as DdsTopic

from rtgen.facts import ros_names
from rtgen.facts.ros_qos import (
    GRAPH,
    PROFILES,
    Durability,
    History,
    Liveliness,
    Profile,
    Reliability,
)
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.medium import (
    DdsEngine,
    DdsPublisher,
    DdsSubscription,
    configuration,
)
from rtgen.runtime.dds.types import idl_class
from rtgen.runtime.distribution.medium import MediumError, OnRequest, OnSample, Token
from rtgen.runtime.ros2.dds_ends import CLIENT, SERVER, Role, Strangers
from rtgen.runtime.ros2.dds_services import Client, Server
from rtgen.runtime.ros2.dds_topics import (
    Discovery,
    RosPublisher,
    RosSubscription,
    room,
)
from rtgen.runtime.ros2.graph import Gid, NodeEntitiesInfo, ParticipantEntitiesInfo
from rtgen.runtime.ros2.network import (
    Ros2Error,
    RosNetwork,
    RosNode,
    RosQos,
    RosService,
    RosTopic,
)
from rtgen.runtime.ros2.qos import Own
from rtgen.runtime.ros2.types import encoded, ros_name

_FOREVER = (1 << 63) - 1
_ID_SIZE = 16
_NO_USER_DATA: Mapping[str, str] = {}
SERVICE = PROFILES["services_default"]
_E = TypeVar("_E", DataReader[Any], DataWriter[Any])


class _Topic(NamedTuple):
    """A DDS topic; `is_call`: its messages have the header of requests."""

    name: str
    type_name: str
    type: type[Any]
    type_hash: str
    node: str
    is_call: bool = False


class _Ends(NamedTuple):
    """The readers and writers of a node."""

    readers: list[Gid]
    writers: list[Gid]


def _data(topic: RosTopic) -> _Topic:
    name = ros_names.dds_topic(topic.name)
    return _Topic(name, topic.type_name, topic.type, topic.type_hash, topic.node)


def open_dds(node: RosNode, *, interface: str | None = None) -> RosNetwork:
    """Open a network. `interface` is a name or address, loopback by default. Raises Ros2Error."""
    try:
        return RosNetwork(RosDds(node, interface))
    except MediumError as error:
        raise Ros2Error(str(error)) from error


class RosDds(DdsEngine):
    """The nodes of one process in a domain; see `Messaging`. Raises MediumError."""

    def __init__(self, node: RosNode, interface: str | None = None) -> None:
        data = Policy.Userdata(ros_names.PARTICIPANT_DATA)
        super().__init__(node.domain, configuration(interface), data)
        self._node = node
        self._announcing = threading.Lock()
        self._nodes = {node.name: _Ends([], [])}
        self._strangers = Strangers()
        graph = _Topic(
            ros_names.DISCOVERY_TOPIC,
            ros_names.DISCOVERY_TYPE,
            ParticipantEntitiesInfo,
            RosTopic("", ParticipantEntitiesInfo).type_hash,
            node.name,
        )
        with self._closing_on_error():
            self._publisher = Publisher(self._participant)
            self._subscriber = Subscriber(self._participant)
            self._graph = self._keep(
                DdsPublisher(self._end(DataWriter, graph, GRAPH), 0.0)
            )
            self._announce()
            named = self._strangers.when_named
            self._discovery = self._keep(
                Discovery(self._participant, self._control, named)
            )
            self._keep(self._strangers)
            every = GRAPH._replace(history=History.KEEP_ALL)
            self._keep(
                DdsSubscription(
                    self._end(DataReader, graph, every),
                    self._data,
                    lambda sample: self._strangers.take_graph(sample.octets),
                    are_numbered=False,
                )
            )

    def publisher(self, topic: RosTopic, qos: RosQos) -> RosPublisher:
        """See `Messaging`."""
        data = _data(topic)
        writer = self._announced(DataWriter, data, qos.profile)
        made = self._keep(RosPublisher(writer, qos.patience))
        self._compare(topic, data, writer, qos.profile)
        return made

    def subscribe(
        self, topic: RosTopic, qos: RosQos, on_sample: OnSample
    ) -> RosSubscription:
        """See `Messaging`."""
        data, profile = _data(topic), qos.profile
        roomy = profile._replace(depth=room(profile, topic.type))
        reader = self._announced(DataReader, data, roomy)
        made = self._keep(RosSubscription(reader, self._data, on_sample, qos.depth))
        self._compare(topic, data, reader, profile)
        return made

    def _compare(
        self, topic: RosTopic, data: _Topic, end: Any, profile: Profile
    ) -> None:
        """Report readers and writers of the topic that do not fit."""
        space = self._node.namespace.rstrip("/")
        node = f"{space}/{topic.node or self._node.name}"
        own = Own(end.guid.bytes, node, profile, isinstance(end, DataWriter))
        type_name = ros_names.dds_type(topic.type_name)
        self._discovery.add(data.name, topic.name, type_name, own)

    def serve(
        self, service: str, types: Sequence[RosService], on_request: OnRequest
    ) -> Token:
        """See `Messaging`."""
        ends = self._service_ends(types[0], SERVER)
        return self._keep(
            Server(service, *ends, self._strangers, on_request, self._control)
        )

    def client(self, service: str, types: RosService) -> Client:
        """See `Messaging`."""
        ends = self._service_ends(types, CLIENT)
        return self._keep(Client(service, *ends, self._strangers, self._control))

    def _service_ends(
        self, service: RosService, role: Role
    ) -> tuple[DataWriter[Any], DataReader[Any]]:
        names = ros_names.dds_service_topics(service.name)
        types = service.request, service.reply
        requests, replies = (
            _Topic(name, str(ros_name(type_)), type_, type_hash, service.node, True)
            for name, type_, type_hash in zip(names, types, service.hashes, strict=True)
        )
        sent, received = (replies, requests) if role is SERVER else (requests, replies)
        identity = {role.key: ros_names.endpoint_id(os.urandom(_ID_SIZE))}
        return (
            self._announced(DataWriter, sent, SERVICE, identity),
            self._announced(DataReader, received, SERVICE, identity),
        )

    def _announced(
        self,
        kind: type[_E],
        topic: _Topic,
        profile: Profile,
        identity: Mapping[str, str] = _NO_USER_DATA,
    ) -> _E:
        """Return a reader or writer that other nodes are told of."""
        end = self._end(kind, topic, profile, identity)
        with self._announcing:
            node = topic.node or self._node.name
            ends = self._nodes.setdefault(node, _Ends([], []))
            gids = ends.writers if isinstance(end, DataWriter) else ends.readers
            gids.append(_gid(end))
            self._announce()
        return end

    def _end(
        self,
        kind: type[_E],
        topic: _Topic,
        profile: Profile,
        identity: Mapping[str, str] = _NO_USER_DATA,
    ) -> _E:
        writes = issubclass(kind, DataWriter)
        with entities.reported(topic.name):
            owner: Any = self._publisher if writes else self._subscriber
            qos = _qos(profile, topic.type_hash, identity, writes=writes)
            return kind(owner, self._topic(topic), qos)

    def _topic(self, topic: _Topic) -> Any:
        type_: Any = topic.type
        class_ = _idl_class(type_, topic.type_name, topic.is_call)
        return DdsTopic(self._participant, topic.name, class_)

    def _announce(self) -> None:
        """Announce the readers and writers of this process to other nodes."""
        nodes = [
            NodeEntitiesInfo(
                node_namespace=self._node.namespace,
                node_name=name,
                reader_gid_seq=list(ends.readers),
                writer_gid_seq=list(ends.writers),
            )
            for name, ends in self._nodes.items()
        ]
        own = ParticipantEntitiesInfo(_gid(self._participant), nodes)
        self._graph.publish(encoded(own))


@cache
def _idl_class(type_: Any, type_name: str, is_call: bool) -> Any:
    """Return the class of cyclonedds for a message.

    It is kept: what a domain knows of a type has to outlive the networks that brought it.
    """
    name = ros_names.dds_type(type_name)
    members = dict(idl_class(type_, ros2=True).__annotations__)
    if is_call:
        members = {"rmw_client": uint64, "rmw_sequence": int64, **members}
    class_ = idl.make_idl_struct(name.replace("::", "_"), name, members)
    class_.__idl_annotations__["extensibility"] = "final"
    return class_


def _gid(entity: Any) -> Gid:
    return Gid(entity.guid.bytes)


def _qos(
    profile: Profile,
    type_hash: str,
    identity: Mapping[str, str],
    *,
    writes: bool = False,
) -> DdsQos:
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
            # A write of cyclonedds that waits holds Python's lock.
            Policy.Reliability.Reliable(0)
            if reliable
            else Policy.Reliability.BestEffort
        ),
        Policy.Durability.TransientLocal if durable else Policy.Durability.Volatile,
        (
            Policy.Liveliness.ManualByTopic(lease)
            if profile.liveliness is Liveliness.MANUAL_BY_TOPIC
            else Policy.Liveliness.Automatic(lease)
        ),
        Policy.Userdata(ros_names.user_data(type_hash, **identity)),
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
