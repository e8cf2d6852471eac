"""A bus with all 127 nodes: 126 equal slaves, each of which receives the values of another."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from hashlib import sha256

from device_bench import pdo, pdo_objects, var

from rtgen.runtime import System
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    Network,
    NodeDescription,
    Write,
)
from rtgen.runtime.canopen.master.managed_node import NodePhase
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.node.node_events import NodeEvents
from rtgen.runtime.canopen.wire.frames import Frame

MS = 1_000_000
SECOND = 1000 * MS
SLAVES = 126
MANAGER = 127
SYNC_PERIOD = 100 * MS
HEARTBEAT = 1000
"""Heartbeat time of every node [ms]."""
TIMEOUT = 3000

COUNT, NODE, HEARD = 0x2000, 0x2001, 0x2002
"""Objects: executions of the application; its node-id; values received from another slave."""

SLAVE = DeviceDescription(
    "Counter",
    (
        var(0x1000, 0, "u32", "ro", 0x00000191),
        var(0x1001, 0, "u8", "ro", 0),
        var(0x1005, 0, "u32", "rw", 0x80),
        var(0x1014, 0, "u32", "rw", 0x80, relative=True),
        var(0x1016, 0, "u8", "const", 1),
        var(0x1016, 1, "u32", "rw", 0),
        var(0x1017, 0, "u16", "rw", 0),
        var(0x1018, 0, "u8", "const", 4),
        *(var(0x1018, sub, "u32", "ro", None) for sub in range(1, 5)),
        *pdo_objects(0x1400, 4),
        *pdo_objects(0x1800, 4),
        var(COUNT, 0, "u32", "ro", 0, mappable=True),
        var(NODE, 0, "u8", "ro", 0, relative=True, mappable=True),
        var(HEARD, 0, "u32", "rww", 0, mappable=True),
        var(HEARD, 1, "u8", "rww", 0, mappable=True),
    ),
    (pdo("rpdo", 1), pdo("tpdo", 1)),
    vendor_id=0x9A,
    product_code=0x1234,
    revision_number=0x00010000,
)


def before(node_id: int) -> int:
    """Return the slave from which a slave receives."""
    return (node_id - 2) % SLAVES + 1


def _u32(value: int) -> bytes:
    return value.to_bytes(4, "little")


def _pdo_writes(
    base: int, cob_id: int, transmission_type: int, *entries: int
) -> tuple[Write, ...]:
    """Return the writes that set a mapping, in the order of CiA 301."""
    mapped = base + 0x200
    return (
        Write(base, 1, _u32(cob_id | 1 << 31)),
        Write(base, 2, bytes((transmission_type,))),
        Write(mapped, 0, b"\0"),
        *(Write(mapped, place, _u32(entry)) for place, entry in enumerate(entries, 1)),
        Write(mapped, 0, bytes((len(entries),))),
        Write(base, 1, _u32(cob_id)),
    )


def described(node_id: int) -> NodeDescription:
    """Return a slave that sends at every SYNC, and receives the values of the previous slave."""
    sent, heard = 0x180 + node_id, 0x180 + before(node_id)
    return NodeDescription(
        name=f"n{node_id}",
        id=node_id,
        module="Counter",
        identity=(0x191, 0x9A, 0x1234, 0x00010000, 1000 + node_id),
        configuration=(
            Write(0x1017, 0, HEARTBEAT.to_bytes(2, "little")),
            Write(0x1016, 1, _u32(MANAGER << 16 | TIMEOUT)),
            *_pdo_writes(0x1400, heard, 255, HEARD << 16 | 0x20, HEARD << 16 | 0x108),
            *_pdo_writes(0x1800, sent, 1, COUNT << 16 | 0x20, NODE << 16 | 0x08),
        ),
        pdos=(),
        heartbeat=HEARTBEAT,
        heartbeat_timeout=TIMEOUT,
    )


NETWORK = Network(
    name="full",
    bit_rate=1000,
    manager=MANAGER,
    sync=SYNC_PERIOD // 1000,
    heartbeat=HEARTBEAT,
    nodes=tuple(described(node_id) for node_id in range(1, SLAVES + 1)),
)


class Counter:
    """A slave with its application, a counter; `heard` are the values received by RPDO."""

    def __init__(self, node_id: int) -> None:
        self.heard: list[tuple[int, int]] = []
        self.node = DeviceNode(
            SLAVE,
            node_id,
            events=NodeEvents(received=self._received),
            serial_number=1000 + node_id,
        )

    def _received(self, number: int) -> None:
        get = self.node.get
        self.heard.append((int(get(HEARD)), int(get(HEARD, 1))))


class Collector:
    """A station that records every PDO, and a check sum of all frames with their times."""

    identifiers = None
    deadline = None

    def __init__(self) -> None:
        self.samples: dict[int, list[tuple[int, int]]] = {}
        self.frames = 0
        self._sum = sha256()

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        self.frames += 1
        self._sum.update(struct.pack("<QH", now, frame.can_id) + frame.data)
        if 0x180 < frame.can_id < 0x200:
            self.samples.setdefault(frame.can_id - 0x180, []).append(
                struct.unpack("<IB", frame.data)
            )
        return ()

    def poll(self, now: int) -> Iterable[Frame]:
        return ()

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()

    @property
    def sum(self) -> str:
        """The check sum of a run, to compare runs."""
        return self._sum.hexdigest()


class FullNetwork:
    """The system: applications run between two SYNCs."""

    def __init__(self, slaves: int = SLAVES) -> None:
        self.system = System()
        assert self.system.clock.network is not None
        self.bus = simulated_bus(self.system.clock.network, "can0", 1_000_000)
        self.collector = Collector()
        self.bus.attach(self.collector)
        self.slaves = [Counter(node_id) for node_id in range(1, slaves + 1)]
        for slave in self.slaves:
            self.bus.attach(slave.node)
            self.bus.send(slave.node.boot(0), slave.node)
        self.manager = ManagerStation(self.bus, NETWORK)
        self.system.at(SYNC_PERIOD // 2, self._begin)
        self.system.at(SYNC_PERIOD, self.manager.start)
        self._runs = 0

    def run(self, seconds: float) -> None:
        """Run up to a time."""
        self.system.run(round(seconds * SECOND))

    @property
    def phases(self) -> set[NodePhase]:
        """The phases of all nodes."""
        return {node.phase for node in self.manager.nodes.values()}

    def lost_or_doubled(self) -> int:
        """Return the number of samples not received exactly once and in order."""
        wrong = 0
        for node_id, samples in self.collector.samples.items():
            first = samples[0][0]
            wrong += sum(
                sample != (first + place, node_id)
                for place, sample in enumerate(samples)
            )
        for slave in self.slaves:
            sent = self.collector.samples[before(slave.node.node_id)]
            wrong += slave.heard != sent[len(sent) - len(slave.heard) :]
        return wrong

    def _begin(self) -> None:
        self.system.every(SYNC_PERIOD, self._applications)

    def _applications(self) -> None:
        self._runs += 1
        now = self.bus.now()
        for slave in self.slaves:
            slave.node.set(COUNT, 0, self._runs)
            frames = slave.node.flush(now)
            if frames:
                self.bus.send(frames, slave.node)
            self.bus.refresh(slave.node)
