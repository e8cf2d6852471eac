"""ROS 2 over Zenoh, compatible with rmw_zenoh: key expressions, liveliness tokens, attachments."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Sequence
from itertools import count
from pathlib import Path
from typing import Any

import zenoh

from rtgen.facts import ros_zenoh
from rtgen.facts.files import UnreadableError, check_file
from rtgen.facts.ros_qos import PROFILES, Profile
from rtgen.facts.ros_zenoh import Entity, Node
from rtgen.runtime.distribution.medium import (
    Client,
    NotServedError,
    OnRequest,
    OnSample,
    PeerLostError,
    Token,
)
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.network import (
    Ros2Error,
    RosNetwork,
    RosNode,
    RosQos,
    RosService,
    RosTopic,
)
from rtgen.runtime.ros2.qos import Own
from rtgen.runtime.ros2.zenoh_topics import (
    Attachments,
    Discovery,
    RosPublisher,
    RosSubscription,
    Shown,
    gid_of,
    report_ignored,
)
from rtgen.runtime.zenoh.medium import ZenohEngine
from rtgen.runtime.zenoh.services import ZenohClient, ZenohService
from rtgen.runtime.zenoh.session import plain, reported
from rtgen.runtime.zenoh.topics import reliability

ROUTER = "tcp/localhost:7447"
"""Default address of rmw_zenoh's router."""

_REPORT_AFTER = 1.5
"""Seconds after which a session without peers is reported."""
_SERVICE = PROFILES["services_default"]
_MAX_HISTORY = 1000
"""Number of samples kept for late subscribers by a publisher with unbounded history."""


def configuration(
    *, connect: str | None = ROUTER, listen: str = "tcp/127.0.0.1:0"
) -> Any:
    """Return the configuration of a peer as in rmw_zenoh: no multicast, gossip."""
    config = zenoh.Config()
    config.insert_json5("mode", '"peer"')
    config.insert_json5("connect/endpoints", f'["{connect}"]' if connect else "[]")
    config.insert_json5("listen/endpoints", f'["{listen}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("timestamping/enabled", "true")
    return config


def open_zenoh(node: RosNode, *, config: Path | Any | None = None) -> RosNetwork:
    """Open a network. `config` is a Zenoh file or configuration; rmw_zenoh's by default.

    Raises Ros2Error.
    """
    try:
        if isinstance(config, Path):
            check_file(config)
            config = zenoh.Config.from_file(str(config))
        session = zenoh.open(config or configuration())
    except UnreadableError as error:
        raise Ros2Error(f"{config} cannot be read: {error}") from error
    except (zenoh.ZError, OSError, ValueError) as error:
        raise Ros2Error(f"Zenoh cannot be opened: {plain(error)}") from error
    return RosNetwork(RosZenoh(node, session))


class RosZenoh(ZenohEngine):
    """The nodes of one process on a session, which it owns; see `Messaging`."""

    def __init__(self, node: RosNode, session: zenoh.Session) -> None:
        super().__init__(session)
        self._node = Node(node.domain, str(session.zid()), 0, node.name, node.namespace)
        self._nodes: dict[str, Node] = {}
        self._tokens: list[Any] = []
        self._numbers = count()
        self._discovery = Discovery(session)
        self._show_node("")
        self._looking = threading.Timer(_REPORT_AFTER, self._tell_if_alone)
        self._looking.daemon = True
        self._looking.start()

    def publisher(self, topic: RosTopic, qos: RosQos) -> RosPublisher:
        """See `Messaging`."""
        key = self._key(topic)
        waits = qos.reliable and qos.depth is None
        options: dict[str, Any] = {
            "reliability": reliability(qos),
            "congestion_control": (
                zenoh.CongestionControl.BLOCK if waits else zenoh.CongestionControl.DROP
            ),
        }
        with reported("Zenoh"):
            if qos.durable:
                publisher: Any = zenoh.ext.declare_advanced_publisher(
                    self._session,
                    key,
                    cache=zenoh.ext.CacheConfig(qos.depth or _MAX_HISTORY),
                    publisher_detection=True,
                    **options,
                )
            else:
                publisher = self._session.declare_publisher(key, **options)
            shown = self._show(ros_zenoh.PUBLISHER, topic, qos.profile)
            made = RosPublisher(
                self._session, publisher, shown, qos.profile, is_durable=qos.durable
            )
            made.add(self._compare(topic, shown, qos.profile, writes=True))
        return made

    def subscribe(
        self, topic: RosTopic, qos: RosQos, on_sample: OnSample
    ) -> RosSubscription:
        """See `Messaging`."""
        profile = qos.profile
        history = profile.depth if qos.durable else None
        with reported("Zenoh"):
            made = RosSubscription(
                self._session, self._key(topic), on_sample, history, profile
            )
            shown = self._show(ros_zenoh.SUBSCRIPTION, topic, profile)
            made.add(shown.token)
            made.add(self._compare(topic, shown, profile, writes=False))
        return made

    def _compare(
        self, topic: RosTopic, shown: Shown, profile: Profile, *, writes: bool
    ) -> Any:
        """Return what reports ends of the topic that do not fit."""
        report_ignored(topic.name, profile, writes=writes)
        space = self._node.namespace.rstrip("/")
        node = f"{space}/{topic.node or self._node.name}"
        own = Own(shown.text, node, profile, writes)
        domain, type_name = self._node.domain, topic.type_name
        return self._discovery.watch(domain, topic.name, type_name, own)

    def serve(
        self, service: str, types: Sequence[RosService], on_request: OnRequest
    ) -> Token:
        """See `Messaging`."""
        [described] = types
        with reported("Zenoh"):
            made = AttachedService(self._session, self._key(described), on_request)
            made.add(self._show(ros_zenoh.SERVICE, described, _SERVICE).token)
        return made.kept_by(self._kept)

    def client(self, service: str, types: RosService) -> Client:
        """See `Messaging`."""
        key = self._key(types)
        with reported("Zenoh"):
            querier = self._session.declare_querier(
                key,
                target=zenoh.QueryTarget.ALL_COMPLETE,
                consolidation=zenoh.ConsolidationMode.LATEST,
            )
            shown = self._show(ros_zenoh.CLIENT, types, _SERVICE)
        return AttachingClient(self._session, key, service, querier, shown)

    def close(self) -> None:
        """See `Messaging`."""
        self._looking.cancel()
        super().close()

    def _tell_if_alone(self) -> None:
        info = self._session.info
        if not (info.routers_zid() or info.peers_zid()):
            log.warning(
                "no router or peer of Zenoh was found, so no node of another process is seen: "
                "rmw_zenoh's router is expected at %s, unless a configuration is given",
                ROUTER,
            )

    def _key(self, described: RosTopic | RosService) -> str:
        name, type_hash = described.name, described.type_hash
        domain = self._node.domain
        return ros_zenoh.key_expression(domain, name, described.type_name, type_hash)

    def _show_node(self, name: str) -> Node:
        """Return a node of this process, whose token is declared; without a name, its own."""
        name = name or self._node.name
        if name not in self._nodes:
            node = self._node._replace(name=name, number=next(self._numbers))
            self._tokens.append(self._token(ros_zenoh.node_token(node)))
            self._nodes[name] = node
        return self._nodes[name]

    def _show(
        self, kind: str, described: RosTopic | RosService, profile: Profile
    ) -> Shown:
        """Declare the token of an entity."""
        entity = Entity(
            kind, described.name, described.type_name, described.type_hash, profile
        )
        node = self._show_node(described.node)
        text = ros_zenoh.entity_token(node, next(self._numbers), entity)
        return Shown(self._token(text), text, gid_of(text))

    def _token(self, text: str) -> Any:
        return self._session.liveliness().declare_token(text)


class AttachedService(ZenohService):
    """A service whose requests and responses have attachments."""

    def _on_query(self, query: zenoh.Query) -> None:
        try:
            if query.attachment is None or query.payload is None:
                raise ValueError("it has no payload or attachment")
            came = ros_zenoh.parse_attachment(query.attachment.to_bytes())
        except ValueError as error:
            log.warning("%s: a request cannot be read: %s", self._key, error)
            return

        def respond(octets: bytes) -> None:
            sent = came._replace(time=time.time_ns())
            self._reply(query, octets, attachment=ros_zenoh.attachment(sent))

        self._on_request(query.payload.to_bytes(), respond)


class AttachingClient(ZenohClient):
    """A client whose requests have attachments, and go to all servers."""

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        service: str,
        querier: zenoh.Querier,
        shown: Shown,
    ) -> None:
        super().__init__(session, service, querier)
        self._key = key
        self._attachments = Attachments(shown.gid)
        self._closing.add(shown.token)

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `medium.Client`. A server that is not discovered yet may answer."""
        with reported("Zenoh"):
            is_served = self._closing.matches(self._querier)
        try:
            return super().call(octets, timeout)
        except PeerLostError as error:
            if is_served:
                raise
            raise NotServedError(
                f"nobody serves {self._service}, or it does not answer"
            ) from error

    def _ask(
        self, octets: bytes, timeout: float, cancellation: zenoh.CancellationToken
    ) -> Iterable[zenoh.Reply]:
        return self._session.get(
            self._key,
            payload=octets,
            attachment=self._attachments.next(),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.LATEST,
            timeout=timeout,
            cancellation_token=cancellation,
        )
