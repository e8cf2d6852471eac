"""ROS 2 over Cyclone DDS, as in rmw_cyclonedds: names, USER_DATA, `ros_discovery_info`."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from cyclonedds import idl
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
from rtgen.runtime.ros2.types import ros_name

_FOREVER = (1 << 63) - 1
_WRITE_TIMEOUT = 0.5
"""Seconds that a message waits for slow readers."""
_ID_SIZE = 16
_NO_USER_DATA: Mapping[str, str] = {}
SERVICE = PROFILES["services_default"]
_HEAD = b"\x00\x01\x00\x00"
_OnSample: TypeAlias = Callable[[bytes, Any, int], None]
"""Function called with a sample, its reader, and the handle of its writer."""


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

    def publisher(self, topic: RosTopic, profile: Profile) -> Publish:
        """See `RosNetwork`."""
        with _as_ros2(topic.name):
            writer = self._made_writer(_data(topic), profile)

        def publish(octets: bytes) -> None:
            with _as_ros2(topic.name):
                entities.write(writer, octets, _WRITE_TIMEOUT)

        return publish

    def subscribe(
        self, topic: RosTopic, profile: Profile, on_message: OnMessage
    ) -> None:
        """See `RosNetwork`."""
        with _as_ros2(topic.name):
            self._read(_data(topic), profile, _octets(on_message))

    def serve(self, service: RosService, on_request: OnRequest) -> None:
        """See `RosNetwork`."""
        requests, replies = self._service_topics(service)
        identity = {"serviceid": ros_names.endpoint_id(os.urandom(_ID_SIZE))}
        with _as_ros2(service.name):
            writer = self._made_writer(replies, SERVICE, identity)
            server = Server(
                service.name, partial(entities.write, writer, patience=_WRITE_TIMEOUT)
            )

            def take(octets: bytes, reader: Any, handle: int) -> None:
                reads = partial(_reads, reader, handle, writer)
                server.take(octets, reads, on_request)

            self._read(requests, SERVICE, take, identity)

    def client(self, service: RosService) -> Call:
        """See `RosNetwork`."""
        requests, replies = self._service_topics(service)
        identity = {"clientid": ros_names.endpoint_id(os.urandom(_ID_SIZE))}
        with _as_ros2(service.name):
            writer = self._made_writer(requests, SERVICE, identity)
            readers: list[Any] = []
            client = Client(
                service.name,
                partial(entities.write, writer, patience=_WRITE_TIMEOUT),
                lambda: _is_served(writer, readers[0]),
            )

            readers.append(self._read(replies, SERVICE, _octets(client.take), identity))
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

    def _read(
        self,
        topic: _Topic,
        profile: Profile,
        on_sample: _OnSample,
        identity: Mapping[str, str] = _NO_USER_DATA,
    ) -> Any:
        """Return a reader, whose messages are dispatched. Raises MediumError."""
        with entities.reported(topic.name):
            qos = _qos(profile, topic.type_hash, identity)
            reader: Any = DataReader(self._subscriber, self._topic(topic), qos)
            condition = entities.condition(reader)
        with self._lock:
            self._entities += (condition, reader)
            self._ends(topic).readers.append(_gid(reader))
            self._announce()

        def take() -> None:
            for octets, info in entities.taken(reader):
                if info.valid_data:
                    on_sample(octets, reader, info.publication_handle)

        self._entries.append(self._dispatcher.add(condition, take))
        return reader

    def _topic(self, topic: _Topic) -> Any:
        type_name = ros_names.dds_type(topic.type_name)
        members = dict(idl_class(topic.type).__annotations__)
        if topic.is_call:
            members = {"rmw_client": uint64, "rmw_sequence": int64, **members}
        made = idl.make_idl_struct(type_name.replace("::", "_"), type_name, members)
        made.__idl_annotations__["extensibility"] = "final"
        return Topic(self._participant, topic.name, made)

    def _made_writer(
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
        entities.write(self._graph, _HEAD + own.to_cdr(True))

    def _ends(self, topic: _Topic) -> _Ends:
        return self._nodes.setdefault(topic.node or self._node.name, _Ends([], []))


def _octets(on_message: OnMessage) -> _OnSample:
    return lambda octets, reader, handle: on_message(octets)


def _reads(reader: Any, handle: int, writer: Any) -> bool:
    """Return whether the client of a request, or any if it is unknown, reads replies."""
    with entities.reported("the client of a request"):
        known = entities.matched_readers(writer)
        client = _client(entities.matched_writer(reader, handle))
        found = (entities.matched_reader(writer, each) for each in known)
        return bool(known) if client is None else client in map(_client, found)


def _client(endpoint: entities.Endpoint | None) -> str | None:
    data = b"" if endpoint is None else endpoint.user_data
    return ros_names.parse_user_data(data).get("clientid")


def _is_served(writer: Any, reader: Any) -> bool:
    with entities.reported("the server of a client"):
        return bool(
            entities.matched_readers(writer) and entities.matched_writers(reader)
        )


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
