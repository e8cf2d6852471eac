"""The messages of a CANopen bus in operation, with the least time between two of each."""

from __future__ import annotations

from rtgen.layouts.can_timing import NANOSECONDS, Message
from rtgen.model.can_bus import Bus, BusNode
from rtgen.model.canopen import EXTENDED, Pdo, PdoDirection, resolved

_SYNC = 0x080
_ERROR_CONTROL = 0x700
_HEARTBEAT_TIME = 0x1017
_LAST_SYNCHRONOUS = 240


def identifier_of(pdo: Pdo, node: BusNode) -> int | None:
    """The CAN identifier of a valid PDO."""
    if not pdo.valid or pdo.cob_id is None:
        return None
    told = resolved(pdo.cob_id, node.id)
    assert isinstance(told, int)
    return told & (0x1FFFFFFF if told & EXTENDED else 0x7FF)


def messages(bus: Bus) -> list[Message]:
    """SYNC, heartbeats, and the PDOs that nodes and their proxies send.

    An RPDO that no link feeds comes from the node's proxy, as often as SYNC, else as the bus
    file's `event` says.
    """
    found = []
    if bus.sync:
        octets = 1 if bus.sync_counter else 0
        found.append(Message("SYNC", _SYNC, octets, _nanoseconds(bus.sync)))
    if bus.heartbeat:
        found.append(_heartbeat("manager", bus.manager, bus.heartbeat))
    fed = {link.target for link in bus.links}
    for node in bus.nodes:
        time = node.device.find(_HEARTBEAT_TIME)
        if time is not None and isinstance(time.current, int) and time.current:
            found.append(_heartbeat(node.name, node.id, time.current / 1000))
        for pdo in node.device.pdos:
            identifier = identifier_of(pdo, node)
            received = pdo.direction is PdoDirection.RPDO
            if identifier is None or (received and (node.name, pdo.number) in fed):
                continue
            name = f"{node.name}.{pdo.direction}{pdo.number}"
            found.append(
                Message(
                    name,
                    identifier,
                    (pdo.bits + 7) // 8,
                    _nanoseconds(_period(pdo, bus)),
                    extended=identifier > 0x7FF,
                )
            )
    return found


def _heartbeat(name: str, node_id: int, period: float) -> Message:
    return Message(
        f"{name} heartbeat", _ERROR_CONTROL + node_id, 1, _nanoseconds(period)
    )


def _period(pdo: Pdo, bus: Bus) -> float:
    """The least time between two of them in seconds."""
    kind = pdo.transmission_type
    if kind is not None and kind <= _LAST_SYNCHRONOUS and bus.sync:
        return bus.sync * max(kind, 1)
    if pdo.direction is PdoDirection.RPDO:
        return bus.sync or bus.event
    if pdo.inhibit_time:
        return pdo.inhibit_time / 10_000
    if pdo.event_timer:
        return min(pdo.event_timer / 1000, bus.event)
    return bus.event


def _nanoseconds(seconds: float) -> int:
    return max(1, round(seconds * NANOSECONDS))
