"""Scans a bus for nodes, by their heartbeats and by SDO requests for their identity."""

from __future__ import annotations

import time
from dataclasses import dataclass

from rtgen.runtime.canopen.bus.python_can import OpenBus
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    MAX_NODE_ID,
    SDO_RESPONSE,
    SECOND,
    Frame,
)
from rtgen.runtime.canopen.wire.nmt import NmtState
from rtgen.runtime.canopen.wire.sdo import TIMED_OUT, SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.tools.can.live.bus_session import BusSession

_DEVICE_TYPE = (0x1000, 0)
_IDENTITY = tuple((0x1018, part) for part in (1, 2, 3, 4))
_NAME = (0x1008, 0)
_AT_ONCE = 8
"""Number of parallel requests: a burst of 127 would overflow many queues."""
_PROFILES = {401: "I/O device", 402: "drive", 404: "measuring device", 406: "encoder"}


@dataclass(slots=True)
class Found:
    """A node on the bus; `identity` is device type, vendor, product, revision and serial number."""

    state: NmtState | None = None
    identity: tuple[int | None, ...] = (None,) * 5
    name: str = ""

    @property
    def state_text(self) -> str:
        """The name of the NMT state, empty without a heartbeat."""
        return "" if self.state is None else self.state.name.lower().replace("_", "-")

    @property
    def device_text(self) -> str:
        """The name of the node, with the profile of its device type."""
        kind = self.identity[0]
        profile = 0 if kind is None else kind & 0xFFFF
        words = [self.name] if self.name else []
        if profile:
            words.append(f"CiA {profile}")
            words += [f"({_PROFILES[profile]})"] if profile in _PROFILES else []
        elif kind is not None:
            words.append("no profile")
        return " ".join(words)


class _Nodes:
    """Records the nodes whose frames are received."""

    def __init__(self) -> None:
        self.found: dict[int, Found] = {}

    def node(self, node_id: int) -> Found:
        return self.found.setdefault(node_id, Found())

    def __call__(self, frame: Frame) -> None:
        if frame.extended or frame.remote:
            return
        node_id = frame.can_id & MAX_NODE_ID
        if not node_id:
            return
        if frame.can_id == SDO_RESPONSE + node_id:
            # A response counts even if it came after its time-out.
            self.node(node_id)
        if frame.can_id == ERROR_CONTROL + node_id and len(frame.data) == 1:
            self._beat(node_id, frame)

    def _beat(self, node_id: int, frame: Frame) -> None:
        try:
            state = NmtState(frame.data[0] & 0x7F)
        except ValueError:
            return
        if state is NmtState.INITIALISING:
            state = NmtState.PRE_OPERATIONAL
        self.node(node_id).state = state


def scanned(bus: OpenBus, seconds: float) -> dict[int, Found]:
    """Return the nodes that answer or send heartbeats, by id; waits up to `seconds` for the others.

    Raises ToolError if the bus is lost.
    """
    nodes = _Nodes()
    session = BusSession(bus, nodes)
    begin = time.monotonic()
    rounds = -(-MAX_NODE_ID // _AT_ONCE)
    timeout = max(round(seconds * SECOND / rounds / 2), 1_000_000)
    ids = list(range(1, MAX_NODE_ID + 1))
    for first in range(0, len(ids), _AT_ONCE):
        _upload(session, ids[first : first + _AT_ONCE], _DEVICE_TYPE, timeout)
    for node_id, node in list(nodes.found.items()):
        octets = _one(session, node_id, _DEVICE_TYPE, seconds)
        if octets is None:
            continue
        parts = [_number(_one(session, node_id, n, seconds)) for n in _IDENTITY]
        node.identity = (_number(octets), *parts)
        node.name = _printable(_one(session, node_id, _NAME, seconds) or b"")
    session.listen(seconds - (time.monotonic() - begin))
    return dict(sorted(nodes.found.items()))


def _upload(
    session: BusSession, ids: list[int], number: tuple[int, int], timeout: int
) -> dict[int, bytes | None]:
    """Read an object of several nodes: None for a node that is silent, empty if it aborts."""
    clients = {node_id: SdoClient(node_id, timeout=timeout) for node_id in ids}
    for client in clients.values():
        session.send(client.upload(*number, time.monotonic_ns()))
    session.run(list(clients.values()))
    return {node_id: _result(client) for node_id, client in clients.items()}


def _result(client: SdoClient) -> bytes | None:
    try:
        return client.result()
    except SdoAbort as abort:
        return None if abort.code == TIMED_OUT else b""


def _one(
    session: BusSession, node_id: int, number: tuple[int, int], seconds: float
) -> bytes | None:
    timeout = round(min(seconds, 0.5) * SECOND)
    return _upload(session, [node_id], number, timeout)[node_id]


def _number(octets: bytes | None) -> int | None:
    return int.from_bytes(octets, "little") if octets else None


def _printable(octets: bytes) -> str:
    text = octets.rstrip(b"\0").decode("latin-1")
    return "".join(c if c.isprintable() else "." for c in text[:64]).strip()
