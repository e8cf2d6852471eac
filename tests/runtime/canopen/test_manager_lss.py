"""Nodes without a node-id, or with another one, get theirs from the manager."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from device_bench import DEVICE
from msgspec.structs import replace

from rtgen.runtime import System
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.description import Network, NodeDescription, Write
from rtgen.runtime.canopen.master.managed_node import NodePhase, NodeReport
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.master.node_control import NodeControl, NodeError
from rtgen.runtime.canopen.master.proxied_node import ProxiedNode
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState

SECOND = 1_000_000_000
UNCONFIGURED = 255
KIND = (0x00020192, 0x00FFFF01, 0x4242, 0x00010002)


def described(node_id: int, serial: int | None, **changes: object) -> NodeDescription:
    node = NodeDescription(
        name=f"n{node_id}",
        id=node_id,
        module="Bench",
        identity=(*KIND, serial),
        configuration=(Write(0x1017, 0, b"\x64\x00"),),
        pdos=(),
        heartbeat=100,
        heartbeat_timeout=300,
        boot_timeout=500,
        lss=True,
    )
    return replace(node, **changes)  # type: ignore[arg-type]


class Bench:
    """A manager, and slaves by their serial numbers."""

    def __init__(self, *nodes: NodeDescription, **slaves: int) -> None:
        self.system = System()
        assert self.system.clock.network is not None
        self.bus = simulated_bus(self.system.clock.network, "can0", 1_000_000)
        self.slaves: dict[int, DeviceNode] = {}
        for name, node_id in slaves.items():
            serial = int(name.removeprefix("s"))
            slave = DeviceNode(DEVICE, node_id, serial_number=serial)
            self.slaves[serial] = slave
            self.bus.attach(slave)
            self.bus.send(slave.boot(0), slave)
        self.reports: list[NodeReport] = []
        network = Network("net", 1000, 127, 0, 0, nodes)
        self.manager = ManagerStation(self.bus, network, self.reports.append)
        self.manager.start()

    def run(self, seconds: float) -> None:
        now = self.system.clock.elapsed()
        self.system.run(now + round(seconds * SECOND))

    def ids(self) -> dict[int, int]:
        return {serial: slave.node_id for serial, slave in self.slaves.items()}

    @property
    def phases(self) -> set[NodePhase]:
        return {node.phase for node in self.manager.nodes.values()}


def test_known_addresses_are_selected() -> None:
    bench = Bench(
        described(5, 11), described(6, 12), s11=UNCONFIGURED, s12=UNCONFIGURED
    )
    bench.run(1.5)
    assert bench.ids() == {11: 5, 12: 6}
    assert bench.phases == {NodePhase.RUNNING}
    phases = [report.phase for report in bench.reports if report.id == 6]
    assert phases[:4] == [
        NodePhase.AWAITED,
        NodePhase.ASSIGNING,
        NodePhase.AWAITED,
        NodePhase.IDENTIFYING,
    ]
    assert all(not node.reason for node in bench.manager.nodes.values())


def test_unknown_serial_numbers_are_found_by_fastscan() -> None:
    bench = Bench(
        described(5, None),
        described(6, None),
        described(7, 3),
        s900=UNCONFIGURED,
        s14=UNCONFIGURED,
        s3=7,
    )
    bench.run(8)
    # Nodes of one kind get their ids in the order of their serial numbers.
    assert bench.ids() == {14: 5, 900: 6, 3: 7}
    assert bench.phases == {NodePhase.RUNNING}


def test_what_is_assigned_is_stored() -> None:
    bench = Bench(described(5, 11), s11=UNCONFIGURED)
    bench.run(1.5)
    bench.reports.clear()
    bench.manager.request(NmtCommand.RESET_NODE, 5)
    bench.run(1)
    assert bench.ids() == {11: 5}
    assert NodePhase.ASSIGNING not in [report.phase for report in bench.reports]
    assert bench.phases == {NodePhase.RUNNING}


def test_a_node_that_has_another_id_moves() -> None:
    bench = Bench(described(5, 11), s11=99)
    bench.run(1.5)
    assert bench.ids() == {11: 5}
    assert bench.slaves[11].state is NmtState.OPERATIONAL
    assert bench.phases == {NodePhase.RUNNING}


def test_nobody_has_the_address() -> None:
    bench = Bench(described(5, 11), described(6, None, mandatory=False), s12=9)
    bench.run(3)
    assert bench.manager.failure == (
        "n5 (node 5): no boot-up message within 500 ms, and no node answers to the LSS "
        "address 00FFFF01h 00004242h 00010002h 0000000Bh"
    )
    assert bench.manager.nodes[6].phase is NodePhase.MISSING
    assert bench.ids() == {12: 9}


def test_a_node_with_an_id_is_not_asked_by_lss() -> None:
    bench = Bench(described(5, 11, lss=False), s11=UNCONFIGURED)
    bench.run(3)
    assert bench.ids() == {11: UNCONFIGURED}
    assert "no boot-up message" in bench.manager.failure
    assert "LSS" not in bench.manager.failure


def test_a_halt_ends_the_assignment() -> None:
    bench = Bench(described(5, None), s11=UNCONFIGURED)
    bench.run(0.6)
    assert bench.phases == {NodePhase.ASSIGNING}
    bench.manager.halt()
    bench.run(10)
    assert bench.phases == {NodePhase.IDLE}
    assert bench.ids() == {11: UNCONFIGURED}
    bench.manager.start()
    bench.run(10)
    assert bench.phases == {NodePhase.RUNNING}


def test_the_proxy_of_a_node_that_forgets_its_id_waits_for_lss() -> None:
    """Without storage LSS follows the boot time-out: a reset of the proxy takes longer."""
    bench = Bench(described(5, 7), s7=UNCONFIGURED)
    slave = bench.slaves[7]
    slave.lss.stored.node_id = UNCONFIGURED
    bench.run(5)
    assert slave.state is NmtState.OPERATIONAL
    slave.lss.stored.node_id = UNCONFIGURED
    proxied = ProxiedNode(5, {}, {}, Silent())
    bench.bus.attach(proxied)
    control = NodeControl(
        bench.bus,
        proxied,
        DEVICE,
        described(5, 7),
        master=False,
        heartbeat_timeout=0,
        boot_timeout=500 * 10**6,
    )

    def reset() -> None:
        for _ in control.reset():
            bench.run(0.01)

    begun = bench.system.clock.elapsed()
    reset()
    assert slave.node_id == 5
    assert bench.system.clock.elapsed() - begun > 500 * 10**6
    slave.lss.stored.node_id = UNCONFIGURED
    bench.bus.detach(slave)
    with pytest.raises(NodeError, match="no boot-up message within 500 ms, and no"):
        reset()


class Silent:
    """A watcher that does nothing."""

    def timeout(self) -> int:
        return 0

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *arguments: None
