"""ROS 2 over Zenoh, compatible with rmw_zenoh: key expressions, liveliness tokens, attachments."""

from __future__ import annotations

import threading
import time
from functools import partial
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import Any

import zenoh

from rtgen.facts import ros_zenoh
from rtgen.facts.files import UnreadableError, check_file
from rtgen.facts.ros_names import GID_SIZE
from rtgen.facts.ros_qos import PROFILES, Durability, History, Profile, Reliability
from rtgen.facts.ros_zenoh import Attachment, Entity, Node
from rtgen.runtime.failures import log
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
from rtgen.runtime.services.servants import (
    CallEnded,
    CallTimeout,
    CommunicationFailure,
    ObjectNotExist,
)
from rtgen.runtime.zenoh.declared import matches
from rtgen.runtime.zenoh.session import plain

ROUTER = "tcp/localhost:7447"
"""Default address of rmw_zenoh's router."""

_REPORT_AFTER = 1.5
"""Seconds after which a session without peers is reported."""
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


class ZenohNetwork:
    """See `RosNetwork`. `config` is a Zenoh file or configuration; rmw_zenoh's by default.

    Raises Ros2Error.
    """

    def __init__(self, node: RosNode, *, config: Path | Any | None = None) -> None:
        try:
            if isinstance(config, Path):
                check_file(config)
                config = zenoh.Config.from_file(str(config))
            self._session: Any = zenoh.open(config or configuration())
        except UnreadableError as error:
            raise Ros2Error(f"{config} cannot be read: {error}") from error
        except (zenoh.ZError, OSError, ValueError) as error:
            raise Ros2Error(f"Zenoh cannot be opened: {plain(error)}") from error
        identity = str(self._session.zid())
        self._node = Node(node.domain, identity, 0, node.name, node.namespace)
        self._nodes: dict[str, Node] = {}
        self._numbers = count()
        self._closed = False
        self._kept: list[Any] = []
        self._calls: set[Any] = set()
        self._shown_node("")
        self._looking = threading.Timer(_REPORT_AFTER, self._tell_if_alone)
        self._looking.daemon = True
        self._looking.start()

    def publisher(self, topic: RosTopic, profile: Profile) -> Publish:
        """See `RosNetwork`."""
        key = self._key(topic)
        reliable = profile.reliability is Reliability.RELIABLE
        options: dict[str, Any] = {
            "reliability": (
                zenoh.Reliability.RELIABLE
                if reliable
                else zenoh.Reliability.BEST_EFFORT
            ),
            "congestion_control": (
                zenoh.CongestionControl.BLOCK
                if reliable and profile.history is History.KEEP_ALL
                else zenoh.CongestionControl.DROP
            ),
        }
        try:
            if profile.durability is Durability.TRANSIENT_LOCAL:
                keep_all = profile.history is History.KEEP_ALL
                cache = zenoh.ext.CacheConfig(
                    _MAX_HISTORY if keep_all else profile.depth
                )
                publisher: Any = zenoh.ext.declare_advanced_publisher(
                    self._session, key, cache=cache, publisher_detection=True, **options
                )
            else:
                publisher = self._session.declare_publisher(key, **options)
            gid = self._present(ros_zenoh.PUBLISHER, topic, profile)
        except zenoh.ZError as error:
            raise Ros2Error(f"{topic.name}: {error}") from error
        self._kept.append(publisher)
        numbers = count(1)
        lock = threading.Lock()

        def publish(octets: bytes) -> None:
            with lock:
                with_it = Attachment(next(numbers), time.time_ns(), gid)
                try:
                    publisher.put(octets, attachment=ros_zenoh.attachment(with_it))
                except zenoh.ZError as error:
                    raise Ros2Error(f"{topic.name}: {error}") from error

        return publish

    def subscribe(
        self, topic: RosTopic, profile: Profile, on_message: OnMessage
    ) -> None:
        """See `RosNetwork`."""

        def take(sample: Any) -> None:
            try:
                on_message(sample.payload.to_bytes())
            except Exception:
                # Zenoh prints exceptions of callbacks and continues.
                log.exception("a message of %s cannot be handled", topic.name)

        key = self._key(topic)
        try:
            if profile.durability is Durability.TRANSIENT_LOCAL:
                history = zenoh.ext.HistoryConfig(
                    detect_late_publishers=True, max_samples=profile.depth
                )
                subscriber: Any = zenoh.ext.declare_advanced_subscriber(
                    self._session, key, take, history=history
                )
            else:
                subscriber = self._session.declare_subscriber(key, take)
            self._kept.append(subscriber)
            self._present(ros_zenoh.SUBSCRIPTION, topic, profile)
        except zenoh.ZError as error:
            raise Ros2Error(f"{topic.name}: {error}") from error

    def serve(self, service: RosService, on_request: OnRequest) -> None:
        """See `RosNetwork`."""
        key = self._service_key(service)
        kind = ros_zenoh.SERVICE

        def reply(query: Any, response: bytes) -> None:
            try:
                came = ros_zenoh.parse_attachment(query.attachment.to_bytes())
                sent = came._replace(time=time.time_ns())
                with query:
                    query.reply(key, response, attachment=ros_zenoh.attachment(sent))
            except zenoh.ZError as error:
                log.debug("%s: the client is gone: %s", service.name, error)

        def take(query: Any) -> None:
            try:
                if query.attachment is None or query.payload is None:
                    raise ValueError("it has no payload or attachment")
                ros_zenoh.parse_attachment(query.attachment.to_bytes())
            except ValueError as error:
                log.warning("%s: a request cannot be read: %s", service.name, error)
                return
            on_request(query.payload.to_bytes(), partial(reply, query))

        try:
            self._kept.append(self._session.declare_queryable(key, take, complete=True))
            self._present_service(kind, service)
        except zenoh.ZError as error:
            raise Ros2Error(f"{service.name}: {error}") from error

    def client(self, service: RosService) -> Call:
        """See `RosNetwork`."""
        key = self._service_key(service)
        try:
            querier = self._session.declare_querier(
                key,
                target=zenoh.QueryTarget.ALL_COMPLETE,
                consolidation=zenoh.ConsolidationMode.LATEST,
            )
            self._kept.append(querier)
            gid = self._present_service(ros_zenoh.CLIENT, service)
        except zenoh.ZError as error:
            raise Ros2Error(f"{service.name}: {error}") from error
        numbers = count(1)
        calls = self._calls

        def call(octets: bytes, timeout: float) -> bytes:
            with_it = Attachment(next(numbers), time.time_ns(), gid)
            started = time.monotonic()
            token = zenoh.CancellationToken()
            calls.add(token)
            try:
                served = matches(querier)
                replies = self._session.get(
                    key,
                    payload=octets,
                    attachment=ros_zenoh.attachment(with_it),
                    target=zenoh.QueryTarget.ALL_COMPLETE,
                    consolidation=zenoh.ConsolidationMode.LATEST,
                    timeout=timeout,
                    cancellation_token=token,
                )
                for reply in replies:
                    if reply.ok is not None:
                        response: bytes = reply.ok.payload.to_bytes()
                        return response
            except zenoh.ZError as error:
                if token in calls:
                    message = f"{service.name}: {error}"
                    raise CommunicationFailure(message) from error
            finally:
                ended = token not in calls
                calls.discard(token)
            if ended:
                raise CallEnded(f"the run ended while a call of {service.name} waited")
            if time.monotonic() - started >= timeout:
                raise CallTimeout(f"no response of {service.name}")
            if served:
                raise CommunicationFailure(f"{service.name} is served no more")
            raise ObjectNotExist(f"nobody serves {service.name}, or it does not answer")

        return call

    def _service_key(self, service: RosService) -> str:
        return ros_zenoh.key_expression(
            self._node.domain, service.name, service.type_name, service.type_hash
        )

    def _present_service(self, kind: str, service: RosService) -> bytes:
        profile = PROFILES["services_default"]
        return self._shown(
            service.node,
            Entity(kind, service.name, service.type_name, service.type_hash, profile),
        )

    def end_calls(self) -> None:
        """See `RosNetwork`."""
        for token in tuple(self._calls):
            # Before: a token says that it is cancelled only after the replies have ended.
            self._calls.discard(token)
            token.cancel()

    def close(self) -> None:
        """See `RosNetwork`."""
        if self._closed:
            return
        self._closed = True
        self._looking.cancel()
        # That withdraws all declarations, including those in use.
        self._session.close()

    def _tell_if_alone(self) -> None:
        info = self._session.info
        if not (info.routers_zid() or info.peers_zid()):
            log.warning(
                "no router or peer of Zenoh was found, so no node of another process is seen: "
                "rmw_zenoh's router is expected at %s, unless a configuration is given",
                ROUTER,
            )

    def _key(self, topic: RosTopic) -> str:
        return ros_zenoh.key_expression(
            self._node.domain, topic.name, topic.type_name, topic.type_hash
        )

    def _present(self, kind: str, topic: RosTopic, profile: Profile) -> bytes:
        """Declare the token of an entity; return its identifier for attachments."""
        return self._shown(
            topic.node,
            Entity(kind, topic.name, topic.type_name, topic.type_hash, profile),
        )

    def _shown_node(self, name: str) -> Node:
        """Return a node of this process, whose token is declared; without a name, its own."""
        name = name or self._node.name
        if name not in self._nodes:
            node = self._node._replace(name=name, number=next(self._numbers))
            self._kept.append(self._token(ros_zenoh.node_token(node)))
            self._nodes[name] = node
        return self._nodes[name]

    def _shown(self, node: str, entity: Entity) -> bytes:
        shown = self._shown_node(node)
        token = ros_zenoh.entity_token(shown, next(self._numbers), entity)
        self._kept.append(self._token(token))
        return sha256(token.encode()).digest()[:GID_SIZE]

    def _token(self, text: str) -> Any:
        return self._session.liveliness().declare_token(text)
