"""The manager with nodes of the `canopen` package, over python-can's virtual bus."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import count

import canopen
import pytest
from canopen.objectdictionary import (
    DOMAIN,
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED32,
    ODRecord,
    ODVariable,
)
from msgspec.structs import replace
from patience import until

from rtgen.runtime import RealClock
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.description import Network, NodeDescription, Write
from rtgen.runtime.canopen.master.managed_node import ManagedNode, NodePhase
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState

CHANNELS = count()
IDENTITY = (0x20192, 0x9A, 0x1234, 0x00010002, 77)
TEXT = bytes(range(200))


def variable(index: int, sub: int, kind: int, value: object, access: str) -> ODVariable:
    found = ODVariable(f"o{index:04X}_{sub}", index, sub)
    found.data_type, found.default, found.access_type = kind, value, access
    return found


def dictionary(node_id: int) -> canopen.ObjectDictionary:
    objects = canopen.ObjectDictionary()
    objects.add_object(variable(0x1000, 0, UNSIGNED32, IDENTITY[0], "ro"))
    objects.add_object(variable(0x1017, 0, UNSIGNED16, 0, "rw"))
    identity = ODRecord("Identity", 0x1018)
    identity.add_member(variable(0x1018, 0, UNSIGNED8, 4, "ro"))
    for sub, value in enumerate(IDENTITY[1:], 1):
        identity.add_member(variable(0x1018, sub, UNSIGNED32, value, "ro"))
    objects.add_object(identity)
    objects.add_object(variable(0x2000, 0, UNSIGNED32, 0, "rw"))
    objects.add_object(variable(0x2001, 0, DOMAIN, b"", "rw"))
    objects.add_object(variable(0x2002, 0, UNSIGNED32, 0, "ro"))
    objects.node_id = node_id
    return objects


class Slave:
    """A LocalNode with additions: boot, and answers to a reset."""

    def __init__(self, channel: str, node_id: int) -> None:
        self.network = canopen.Network()
        self.network.NOTIFIER_CYCLE = 0.05
        self.network.connect(interface="virtual", channel=channel)
        self.node = canopen.LocalNode(node_id, dictionary(node_id))
        self.network.add_node(self.node)
        self.commands: list[int] = []
        self.syncs: list[bytes] = []
        self.network.subscribe(0, self._command)
        self.network.subscribe(0x80, lambda can_id, data, t: self.syncs.append(data))

    def boot(self) -> None:
        self.node.nmt.stop_heartbeat()
        self.node.nmt.send_command(0)
        self.node.nmt.send_command(128)

    def close(self) -> None:
        self.node.nmt.stop_heartbeat()
        self.network.disconnect()

    def _command(self, can_id: int, data: bytes, stamp: float) -> None:
        if data[1] in (0, self.node.id):
            self.commands.append(data[0])
            if data[0] in (0x81, 0x82):
                self.boot()


def described(node_id: int) -> NodeDescription:
    return NodeDescription(
        name=f"n{node_id}",
        id=node_id,
        module="Thing",
        identity=IDENTITY,
        configuration=(
            Write(0x1017, 0, (50).to_bytes(2, "little")),
            Write(0x2000, 0, b"\x01\x02\x03\x04"),
            Write(0x2001, 0, TEXT),
        ),
        pdos=(),
        heartbeat=50,
        heartbeat_timeout=1000,
    )


class Bench:
    def __init__(self) -> None:
        self.channel = f"manager{next(CHANNELS)}"
        self.slaves = {number: Slave(self.channel, number) for number in (5, 6)}
        link = open_link(RealClock(), "virtual", self.channel)
        network = Network("net", 0, 127, 20_000, 50, tuple(map(described, self.slaves)))
        self.manager = ManagerStation(link, network)

    def node(self, node_id: int = 5) -> ManagedNode:
        return self.manager.nodes[node_id]

    def until(self, condition: Callable[[], bool]) -> None:
        until(condition, shown=self.manager.reports)

    def start(self) -> None:
        self.manager.start()
        self.until(
            lambda: {node.phase for node in self.manager.nodes.values()}
            == {NodePhase.RUNNING}
        )


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.manager.close()
    for slave in bench.slaves.values():
        slave.close()


def test_nodes_are_configured_started_and_supervised(bench: Bench) -> None:
    bench.start()
    for slave in bench.slaves.values():
        assert slave.commands[:2] == [NmtCommand.RESET_COMMUNICATION, NmtCommand.START]
        assert slave.node.get_data(0x2000, 0) == b"\x01\x02\x03\x04"
        assert slave.node.get_data(0x2001, 0) == TEXT
        assert slave.node.nmt.state == "OPERATIONAL"
    assert bench.node().nmt is NmtState.OPERATIONAL
    bench.until(lambda: len(bench.slaves[5].syncs) > 3)
    bench.slaves[5].node.nmt.stop_heartbeat()
    bench.until(lambda: bench.node().phase is NodePhase.FAILED)
    assert bench.manager.failure.endswith("its heartbeat is lost: none for 1000 ms")
    assert bench.node(6).phase is NodePhase.RUNNING
    bench.manager.request(NmtCommand.RESET_NODE, 5)
    bench.until(lambda: bench.node().phase is NodePhase.RUNNING)
    assert bench.manager.failure == ""


def test_commands(bench: Bench) -> None:
    bench.start()
    nmt = bench.slaves[6].node.nmt
    bench.manager.request(NmtCommand.ENTER_PRE_OPERATIONAL, 6)
    bench.until(lambda: nmt.state == "PRE-OPERATIONAL")
    bench.manager.request(NmtCommand.START, 6)
    bench.until(lambda: bench.node(6).phase is NodePhase.RUNNING)
    bench.manager.halt()
    bench.until(lambda: nmt.state == "PRE-OPERATIONAL")
    assert bench.node(6).phase is NodePhase.IDLE


@pytest.mark.parametrize(
    ("node", "reason"),
    [
        (
            replace(described(5), identity=(None, 0x9B, None, None, None)),
            "wrong identity: vendor (1018:1) is 0000009Ah, not 0000009Bh",
        ),
        (
            replace(described(5), configuration=(Write(0x2002, 0, bytes(4)),)),
            "2002:0 cannot be written: 06010002h write of a read-only object",
        ),
        (
            replace(described(5), configuration=(Write(0x2003, 0, bytes(4)),)),
            "2003:0 cannot be written: 06020000h object does not exist",
        ),
        (
            replace(described(5), configuration=(Write(0x2000, 0, bytes(3)),)),
            "2000:0 cannot be written: 06070010h type or length does not match",
        ),
        (
            replace(described(7), boot_timeout=100),
            "no boot-up message within 100 ms",
        ),
    ],
)
def test_refusals(bench: Bench, node: NodeDescription, reason: str) -> None:
    network = Network("net", 0, 127, 0, 0, (node,))
    bench.manager = ManagerStation(bench.manager.link, network)
    bench.manager.start()
    bench.until(lambda: bench.manager.failure != "")
    assert bench.manager.failure == f"{node.name} (node {node.id}): {reason}"
