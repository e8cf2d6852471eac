"""Messages of a CANopen bus in operation, each with its minimum period."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias

import msgspec

from rtgen.compiler.layouts.can_services import emergency_cob_id
from rtgen.compiler.layouts.can_supervision import guard_time, heartbeat
from rtgen.compiler.layouts.can_timing import NANOSECONDS, Message
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.model.canopen import Pdo, PdoDirection, resolved
from rtgen.facts.canopen import (
    ERROR_CONTROL,
    EXTENDED,
    INVALID,
    MAX_STANDARD_ID,
    MAX_SYNC_CYCLIC,
    NMT,
    SDO_REQUEST,
    SDO_RESPONSE,
    can_id_of,
)

MAX_DATA = 8
HOST = "host"
"""Name of the queue of the manager and the proxies, whose process sends in order."""
SPORADIC = 1.0
"""The minimum time in seconds between two sporadic messages of a kind.

These are NMT commands, the request and the answer of an SDO client and a node, and emergencies
without inhibit time.
"""

_EMERGENCY_INHIBIT = 0x1015


class Writing(msgspec.Struct, frozen=True):
    """Periodic writes of a component to an RPDO's port, in s; `jitter`: the delay of a sample."""

    period: float
    jitter: float = 0.0


Writings: TypeAlias = Mapping[tuple[str, int], Writing]
"""Writes by node name and RPDO number."""


def identifier_of(pdo: Pdo, node: BusNode) -> int | None:
    """Return the CAN identifier of a valid PDO."""
    if not pdo.valid:
        return None
    cob_id = resolved(pdo.cob_id, node.id)
    assert isinstance(cob_id, int)
    return can_id_of(cob_id)


def messages(bus: Bus, writings: Writings | None = None) -> list[Message]:
    """Return the messages of nodes, their proxies and the manager.

    An RPDO without a link is sent by the node's proxy: a synchronous one once per SYNC, others with
    the period of the inhibit time, `writings`, or the bus file's `event`, in this order.
    """
    traffic = [_host("NMT", NMT, 2, SPORADIC)] if bus.nodes else []
    if bus.sync:
        octets = 1 if bus.sync_counter else 0
        cob_id = bus.sync_cob_id
        traffic.append(_host("SYNC", can_id_of(cob_id), octets, bus.sync, cob_id))
    if bus.heartbeat:
        can_id = ERROR_CONTROL + bus.manager
        traffic.append(_host("manager heartbeat", can_id, 1, bus.heartbeat))
    fed = {link.target for link in bus.links}
    for node in bus.nodes:
        traffic += _services(node)
        for pdo in node.device.pdos:
            identifier = identifier_of(pdo, node)
            if identifier is not None and (
                pdo.direction is PdoDirection.TPDO or (node.name, pdo.number) not in fed
            ):
                traffic.append(_pdo(pdo, identifier, node, bus, writings or {}))
    return traffic


def _services(node: BusNode) -> Iterator[Message]:
    """Yield the messages of a node other than PDOs: supervision, emergencies, SDO."""
    name, can_id = node.name, ERROR_CONTROL + node.id
    if period := heartbeat(node):
        yield Message(f"{name} heartbeat", can_id, 1, _nanoseconds(period / 1000))
    if period := guard_time(node):
        time = _nanoseconds(period / 1000)
        # The answer inherits the worst-case delay of the request.
        yield Message(f"{name} guarding", can_id, 1, time, jitter=time)
        yield Message(
            f"{name} guarding request", can_id, 0, time, remote=True, queue=HOST
        )
    inhibit_time = node.device.number(_EMERGENCY_INHIBIT)
    pause = inhibit_time / 10_000 if inhibit_time else SPORADIC
    emergency = emergency_cob_id(node)
    if not emergency & INVALID:
        yield Message(
            f"{name} emergency",
            can_id_of(emergency),
            8,
            _nanoseconds(pause),
            extended=bool(emergency & EXTENDED),
        )
    yield _host(f"{name} SDO request", SDO_REQUEST + node.id, 8, SPORADIC)
    sporadic = _nanoseconds(SPORADIC)
    yield Message(f"{name} SDO answer", SDO_RESPONSE + node.id, 8, sporadic)


def _pdo(
    pdo: Pdo, identifier: int, node: BusNode, bus: Bus, writings: Writings
) -> Message:
    received = pdo.direction is PdoDirection.RPDO
    kind = pdo.transmission_type
    synchronous = kind is not None and kind <= MAX_SYNC_CYCLIC and bus.sync > 0
    jitter = 0.0
    if synchronous:
        period = bus.sync * (1 if received else max(kind or 0, 1))
    elif pdo.inhibit_time:
        period = pdo.inhibit_time / 10_000
    elif received:
        writing = writings.get((node.name, pdo.number), Writing(bus.event))
        period, jitter = writing.period, writing.jitter
    elif pdo.event_timer:
        period = min(pdo.event_timer / 1000, bus.event)
    else:
        period = bus.event
    return Message(
        f"{node.name}.{pdo.direction}{pdo.number}",
        identifier,
        MAX_DATA if pdo.multiplexed else (pdo.bits + 7) // 8,
        _nanoseconds(period),
        jitter=round(jitter * NANOSECONDS),
        extended=identifier > MAX_STANDARD_ID,
        queue=HOST if received else "",
        trigger="SYNC" if synchronous else "",
    )


def _host(
    name: str, can_id: int, octets: int, period: float, cob_id: int = 0
) -> Message:
    extended = bool(cob_id & EXTENDED)
    return Message(
        name, can_id, octets, _nanoseconds(period), queue=HOST, extended=extended
    )


def _nanoseconds(seconds: float) -> int:
    return max(1, round(seconds * NANOSECONDS))
