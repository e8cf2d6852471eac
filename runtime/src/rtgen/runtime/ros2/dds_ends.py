"""Ends of services on DDS: those that have the header of rmw_cyclonedds, and strangers.

An end that has it says so in its USER_DATA (`clientid=`, `serviceid=`). Any other, such as one of
rmw_fastrtps, would take the header for data: its requests are left out, and it is sent none.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable
from typing import Any, Final, NamedTuple, TypeAlias

import msgspec
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader

from rtgen.facts import ros_names
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.dds import entities
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.graph import ParticipantEntitiesInfo
from rtgen.runtime.ros2.types import decoded

_MAX_PARTICIPANTS: Final = 512
_MAX_SIZE: Final = 1 << 16
"""Maximum number of participants whose nodes are known, and of octets that describe them."""
_MAX_REPORTS: Final = 1024
_NAME_TIMEOUT: Final = 3.5
"""Seconds that the report of an end waits for the name of its node.

Fast DDS sends what it keeps for later readers with its next heartbeat, every 3 s.
"""
_MAX_ENDS: Final = 4096
"""Maximum number of remembered ends of a service, of which some may have gone."""
_PREFIX = 12
"""Octets of a GUID that are those of its participant (DDSI-RTPS 2.5, 8.2.4.1)."""
_HEAD = 4
_ACTION = "/_action/"


WhenNamed: TypeAlias = Callable[[str | None], None]


class Graph:
    """The nodes of `ros_discovery_info`, by their readers and writers."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._described: OrderedDict[bytes, bytes] = OrderedDict()

    def take(self, octets: bytes) -> None:
        """Keep a message, which describes a participant until the next one."""
        if _HEAD + ros_names.GID_SIZE <= len(octets) <= _MAX_SIZE:
            participant = octets[_HEAD : _HEAD + _PREFIX]
            with self._lock:
                self._described[participant] = octets
                self._described.move_to_end(participant)
                if len(self._described) > _MAX_PARTICIPANTS:
                    self._described.popitem(last=False)

    def node(self, guid: bytes) -> str | None:
        """Return the fully qualified name of the node that has a reader or writer."""
        with self._lock:
            octets = self._described.get(guid[:_PREFIX])
        if octets is None:
            return None
        try:
            described = decoded(ParticipantEntitiesInfo, octets)
        except CdrError:
            return None
        for node in described.node_entities_info_seq:
            gids = (*node.reader_gid_seq, *node.writer_gid_seq)
            if any(gid.data == guid for gid in gids):
                return f"{node.node_namespace.rstrip('/')}/{node.node_name}"
        return None


class Role(NamedTuple):
    """What the other end of a service is: the key that it says, and words for it."""

    key: str
    name: str
    fate: str


CLIENT: Final = Role("clientid", "client", "gets no response")
SERVER: Final = Role("serviceid", "server", "is not called")


class End(NamedTuple):
    """A reader or writer of another participant; `id` is None for a stranger."""

    guid: bytes
    id: str | None


class Strangers:
    """Reports each end without the header once, with the name of its node."""

    def __init__(self) -> None:
        self._graph = Graph()
        self._lock = threading.Lock()
        self._named = threading.Condition()
        self._pending: dict[bytes, tuple[str, Role, bytes]] = {}
        self._reported: set[bytes] = set()
        self._waiting: list[tuple[bytes, WhenNamed]] = []
        self._timer: threading.Timer | None = None

    def when_named(self, guid: bytes, call: WhenNamed) -> None:
        """Call a function with the name of the node of an end, with None if it stays unknown."""
        with self._lock:
            self._waiting.append((guid, call))
            if self._timer is None and self._graph.node(guid) is None:
                self._timer = threading.Timer(_NAME_TIMEOUT, self._end_waiting)
                self._timer.daemon = True
                self._timer.start()
        self._call_known()

    def close(self) -> None:
        """Wait for names no more."""
        with self._lock:
            self._waiting.clear()
            if self._timer is not None:
                self._timer.cancel()

    def _end_waiting(self) -> None:
        with self._lock:
            self._timer = None
        self._call_known(all_=True)

    def _call_known(self, *, all_: bool = False) -> None:
        with self._lock:
            named = [(self._graph.node(guid), call) for guid, call in self._waiting]
            known = [all_ or node is not None for node, _ in named]
            self._waiting = [
                each
                for each, is_known in zip(self._waiting, known, strict=True)
                if not is_known
            ]
        for (node, call), is_known in zip(named, known, strict=True):
            if is_known:
                call(node)

    def discovered(self, service: str, role: Role, ends: Iterable[End]) -> None:
        """Report those of the ends that have no header once the names of their nodes are known."""
        with self._lock:
            for end in ends:
                key = _key(service, end.guid)
                is_new = end.id is None and key not in self._reported
                if is_new and len(self._pending) < _MAX_REPORTS:
                    self._pending[key] = service, role, end.guid
        self._report_known()

    def take_graph(self, octets: bytes) -> None:
        """Process a message of `ros_discovery_info`: ends of its nodes can be reported."""
        with self._named:
            self._graph.take(octets)
            self._named.notify_all()
        self._report_known()
        self._call_known()

    def wait_for_node(self, guid: bytes, timeout: float) -> None:
        """Wait for the name of a node, of which readers may be discovered before."""
        with self._named:
            self._named.wait_for(
                lambda: self._graph.node(guid) is not None, min(timeout, _NAME_TIMEOUT)
            )

    def _report_known(self) -> None:
        with self._lock:
            pending = [*self._pending.values()]
        for service, role, guid in pending:
            if self._graph.node(guid) is not None:
                self.report(service, role, guid)

    def has_reported(self, service: str, guid: bytes) -> bool:
        """Return whether an end has been reported."""
        with self._lock:
            return _key(service, guid) in self._reported

    def report(self, service: str, role: Role, guid: bytes) -> str:
        """Report an end, unless that has been done; return the text."""
        node = self._graph.node(guid)
        name = f"DDS entity {guid.hex()}" if node is None else f"node {node}"
        text = (
            f"{service}: the {role.name} in {name} {role.fate}: its middleware, such as "
            "rmw_fastrtps, has other service messages than rmw_cyclonedds; use --ros2 rclpy where "
            "ROS 2 is installed, or start the node with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp"
        )
        key = _key(service, guid)
        with self._lock:
            self._pending.pop(key, None)
            is_new = key not in self._reported and len(self._reported) < _MAX_REPORTS
            self._reported.add(key)
        if is_new:
            log.warning("%s", text)
        return text


def _key(service: str, guid: bytes) -> bytes:
    """Return what is reported once: an end, but all ends of an action's client or server."""
    action, is_one, _ = service.partition(_ACTION)
    return guid[:_PREFIX] + action.encode() if is_one else guid


class Ends(msgspec.Struct, eq=False):
    """The ends that a reader or writer of a service is matched with, by their handles."""

    _own: DataReader[Any] | DataWriter[Any]
    _role: Role
    _known: OrderedDict[int, End] = msgspec.field(default_factory=OrderedDict)

    def find(self, handle: int) -> End | None:
        """Return an end; None for one that is not matched, and was not seen before."""
        known = self._known.get(handle)
        if known is None:
            endpoint = entities.counterpart(self._own, handle)
            if endpoint is None:
                return None
            said = ros_names.parse_user_data(endpoint.user_data)
            known = End(endpoint.guid, said.get(self._role.key))
            self._known[handle] = known
            if len(self._known) > _MAX_ENDS:
                self._known.popitem(last=False)
        return known

    def all(self) -> list[End]:
        """Return the ends that are matched. Raises MediumError."""
        with entities.reported(f"each {self._role.name}"):
            found = map(self.find, entities.matched(self._own))
            return [end for end in found if end is not None]

    def have(self, id_: str) -> bool:
        """Return whether one of the ends has this identity. Raises MediumError."""
        return any(end.id == id_ for end in self.all())
