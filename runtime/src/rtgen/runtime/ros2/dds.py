"""ROS 2 over Cyclone DDS, as in rmw_cyclonedds: names, USER_DATA, `ros_discovery_info`."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from cyclonedds import idl
from cyclonedds.core import DDSStatus
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl.types import int64, uint64
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.qos import Policy
from cyclonedds.qos import Qos as DdsQos
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic

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
from rtgen.runtime.dds.dispatcher import Dispatcher
from rtgen.runtime.dds.medium import DOMAINS, configuration
from rtgen.runtime.dds.types import idl_class
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.failures import log
from rtgen.runtime.ros2 import dds_ends
from rtgen.runtime.ros2.dds_ends import CLIENT, SERVER, Ends, Role, Servers, Strangers
from rtgen.runtime.ros2.dds_services import Client, Server
from rtgen.runtime.ros2.graph import Gid, NodeEntitiesInfo, ParticipantEntitiesInfo
from rtgen.runtime.ros2.network import (
    Call,
    OnMessage,
    OnRequest,
    Publish,
    Ros2Error,
    RosNode,
    RosService,
    RosTopic,
)
from rtgen.runtime.ros2.types import encoded, ros_name

_FOREVER = (1 << 63) - 1
_WRITE_TIMEOUT = 0.5
"""Seconds that a message waits for slow readers."""
_ID_SIZE = 16
_NO_USER_DATA: Mapping[str, str] = {}
SERVICE = PROFILES["services_default"]
_OnSample: TypeAlias = Callable[[bytes, int], None]
"""Function called with a sample, and the handle of its writer."""


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


@contextmanager
def _as_ros2(what: str) -> Iterator[None]:
    try:
        yield
    except MediumError as error:
        raise Ros2Error(f"{what}: {error}") from error


class DdsNetwork:
    """See `RosNetwork`. `interface` is a name or address, loopback by default.

    Raises Ros2Error.
    """

    def __init__(self, node: RosNode, *, interface: str | None = None) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._nodes = {node.name: _Ends([], [])}
        self._entities: list[Any] = []
        self._entries: list[Any] = []
        self._clients: list[Client] = []
        self._strangers = Strangers()
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
            shown = _data(graph)._replace(name=ros_names.DISCOVERY_TOPIC)
            self._graph = self._writer(shown, GRAPH)
            self._announce()
            others = self._reader(shown, GRAPH._replace(history=History.KEEP_ALL))
            self._dispatch(others, lambda octets, _: self._strangers.take_graph(octets))

    def publisher(self, topic: RosTopic, profile: Profile) -> Publish:
        """See `RosNetwork`."""
        with _as_ros2(topic.name):
            writer = self._announced_writer(_data(topic), profile)

        def publish(octets: bytes) -> None:
            with _as_ros2(topic.name):
                entities.write(writer, octets, _WRITE_TIMEOUT)

        return publish

    def subscribe(
        self, topic: RosTopic, profile: Profile, on_message: OnMessage
    ) -> None:
        """See `RosNetwork`."""
        with _as_ros2(topic.name):
            reader = self._announced_reader(_data(topic), profile)
            self._dispatch(reader, lambda octets, _: on_message(octets))

    def serve(self, service: RosService, on_request: OnRequest) -> None:
        """See `RosNetwork`."""
        requests, replies = self._service_topics(service)
        identity = {SERVER.key: ros_names.endpoint_id(os.urandom(_ID_SIZE))}
        with _as_ros2(service.name):
            writer = self._announced_writer(replies, SERVICE, identity)
            reader = self._announced_reader(requests, SERVICE, identity)
            clients = dds_ends.writers(reader, CLIENT)
            readers = dds_ends.readers(writer, CLIENT)
            server = Server(service.name, partial(_write, writer))

            def take(octets: bytes, handle: int) -> None:
                client = clients.find(handle)
                if client is None:
                    log.debug("%s: a request of an unknown client", service.name)
                elif client.id is None:
                    self._strangers.report(service.name, CLIENT, client.guid)
                else:
                    server.take(octets, partial(readers.have, client.id), on_request)

            self._dispatch(reader, take)
            self._watch(service, CLIENT, reader, clients)

    def client(self, service: RosService) -> Call:
        """See `RosNetwork`."""
        requests, replies = self._service_topics(service)
        identity = {CLIENT.key: ros_names.endpoint_id(os.urandom(_ID_SIZE))}
        with _as_ros2(service.name):
            writer = self._announced_writer(requests, SERVICE, identity)
            reader = self._announced_reader(replies, SERVICE, identity)
            readers = dds_ends.readers(writer, SERVER)
            writers = dds_ends.writers(reader, SERVER)
            servers = Servers(service.name, readers, writers, self._strangers)
            client = Client(service.name, partial(_write, writer), servers)

            def take(octets: bytes, handle: int) -> None:
                server = writers.find(handle)
                if server is not None and server.id is not None:
                    client.take(octets)

            self._dispatch(reader, take)
            self._watch(service, SERVER, writer, readers)
        self._clients.append(client)
        return client.call

    def _service_topics(self, service: RosService) -> tuple[_Topic, _Topic]:
        names = ros_names.dds_service_topics(service.name)
        types = service.request, service.response
        requests, replies = (
            _Topic(name, str(ros_name(type_)), type_, type_hash, service.node, True)
            for name, type_, type_hash in zip(names, types, service.hashes, strict=True)
        )
        return requests, replies

    def end_calls(self) -> None:
        """See `RosNetwork`."""
        for client in self._clients:
            client.end_calls()

    def close(self) -> None:
        """See `RosNetwork`."""
        if self._closed:
            return
        self._closed = True
        for client in self._clients:
            client.close()
        for entry in self._entries:
            entry.close()
        self._dispatcher.close()
        for entity in self._entities:
            entities.delete(entity)
        entities.delete(self._participant)
        DOMAINS.close(self._node.domain)

    def _announced_reader(
        self,
        topic: _Topic,
        profile: Profile,
        identity: Mapping[str, str] = _NO_USER_DATA,
    ) -> DataReader[Any]:
        """Return a reader, announced. Raises MediumError."""
        reader = self._reader(topic, profile, identity)
        with self._lock:
            self._ends(topic).readers.append(_gid(reader))
            self._announce()
        return reader

    def _reader(
        self,
        topic: _Topic,
        profile: Profile,
        identity: Mapping[str, str] = _NO_USER_DATA,
    ) -> DataReader[Any]:
        with entities.reported(topic.name):
            qos = _qos(profile, topic.type_hash, identity)
            reader: DataReader[Any] = DataReader(
                self._subscriber, self._topic(topic), qos
            )
        self._entities.append(reader)
        return reader

    def _dispatch(self, reader: DataReader[Any], on_sample: _OnSample) -> None:
        """Pass on the samples of a reader. Raises MediumError."""
        with entities.reported(reader.topic.name):
            condition = entities.condition(reader)
        self._entities.insert(0, condition)

        def take() -> None:
            for octets, info in entities.taken(reader):
                if info.valid_data:
                    on_sample(octets, info.publication_handle)

        self._entries.append(self._dispatcher.add(condition, take))

    def _watch(self, service: RosService, role: Role, entity: Any, ends: Ends) -> None:
        """Report strangers that an end of a service is matched with."""
        matched = (
            DDSStatus.SubscriptionMatched
            if isinstance(entity, DataReader)
            else DDSStatus.PublicationMatched
        )

        def look() -> None:
            with entities.reported(service.name):
                entity.take_status(matched)
            for end in ends.all():
                if end.id is None:
                    self._strangers.discovered(service.name, role, end.guid)

        with entities.reported(service.name):
            entity.set_status_mask(matched)
        self._entries.append(self._dispatcher.add(entity, look))

    def _topic(self, topic: _Topic) -> Any:
        type_name = ros_names.dds_type(topic.type_name)
        members = dict(idl_class(topic.type, ros2=True).__annotations__)
        if topic.is_call:
            members = {"rmw_client": uint64, "rmw_sequence": int64, **members}
        made = idl.make_idl_struct(type_name.replace("::", "_"), type_name, members)
        made.__idl_annotations__["extensibility"] = "final"
        return Topic(self._participant, topic.name, made)

    def _announced_writer(
        self,
        topic: _Topic,
        profile: Profile,
        identity: Mapping[str, str] = _NO_USER_DATA,
    ) -> Any:
        """Return a writer, announced. Raises MediumError."""
        writer = self._writer(topic, profile, identity)
        with self._lock:
            self._ends(topic).writers.append(_gid(writer))
            self._announce()
        return writer

    def _writer(
        self,
        topic: _Topic,
        profile: Profile,
        identity: Mapping[str, str] = _NO_USER_DATA,
    ) -> DataWriter[Any]:
        with entities.reported(topic.name):
            qos = _qos(profile, topic.type_hash, identity, writes=True)
            writer: DataWriter[Any] = DataWriter(
                self._publisher, self._topic(topic), qos
            )
        self._entities.append(writer)
        return writer

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
        entities.write(self._graph, encoded(own))

    def _ends(self, topic: _Topic) -> _Ends:
        return self._nodes.setdefault(topic.node or self._node.name, _Ends([], []))


def _write(writer: Any, octets: bytes) -> None:
    entities.write(writer, octets, _WRITE_TIMEOUT)


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
