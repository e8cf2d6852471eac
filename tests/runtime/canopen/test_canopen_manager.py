"""The manager as a component: life cycle, ports, service."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from slaves import MS, Slave

from refrobots.rtc import TimedLong
from rtgen.compiler.kit.resources import idl_file
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    RTC_OK,
    Component,
    ComponentProfile,
    LifeCycleState,
    ParameterProfile,
    ReturnCode_t,
    System,
)
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.master.managed_node import NodePhase, NodeReport
from rtgen.runtime.canopen.master.manager import CanopenManager
from rtgen.runtime.canopen.networks import UnknownNetworkError, load_network
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState
from rtgen.runtime.services.servants import Servant, Skeleton

SECOND = 1000 * MS


@dataclass
class Parameters:
    network: str = "pair"
    interface: str = "virtual"
    channel: str = "can0"
    bitrate: int = 0
    options: str = ""


class _Service(Servant):
    _skeleton_ = Skeleton


class SampleManager(CanopenManager):
    """A manager like a generated one, whose samples are 100 times the node-id, and the phase."""

    networks = "sample_networks"
    profile = ComponentProfile(
        "CanopenManager",
        rate=100.0,
        configuration=tuple(
            ParameterProfile(name=name, python_name=name, type=type_, default=default)
            for name, type_, default in (
                ("network", "string", "pair"),
                ("interface", "string", "virtual"),
                ("channel", "string", "can0"),
                ("bitrate", "long", "0"),
                ("options", "string", ""),
            )
        ),
    )

    def __init__(self) -> None:
        super().__init__()
        self.config = self.add_configuration(Parameters())
        self.states = self.add_out_port("states", TimedLong)
        self.manager = self.add_provider("manager", "manager", _Service)

    def _servant(self) -> Any:
        return object()

    def _sample(self, report: NodeReport, time: int) -> TimedLong:
        sample = TimedLong(data=report.id * 100 + report.phase)
        sample.tm.sec, sample.tm.nsec = divmod(time, SECOND)
        return sample


class Listener(Component):
    """Records the states of the manager."""

    profile = ComponentProfile("Listener", rate=1000.0)

    def __init__(self) -> None:
        super().__init__()
        self.port = self.add_in_port("states", TimedLong)
        self.states: list[tuple[int, NodePhase]] = []
        self.times: list[float] = []

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        while self.port.is_new() and (sample := self.port.read()) is not None:
            self.states.append((sample.data // 100, NodePhase(sample.data % 100)))
            self.times.append(sample.tm.sec + sample.tm.nsec * 1e-9)
        return RTC_OK


class Bench:
    def __init__(self, system: System) -> None:
        self.system = system
        assert system.clock.network is not None
        self.bus = simulated_bus(system.clock.network)
        self.slaves = {number: Slave(number) for number in (5, 6)}
        for slave in self.slaves.values():
            self.bus.attach(slave)
        self.manager = SampleManager()
        self.listener = Listener()
        for component in (self.manager, self.listener):
            system.add(component)
        system.connect(("CanopenManager0", "states"), ("Listener0", "states"))
        system.activate("Listener0")

    def run(self, seconds: float) -> LifeCycleState:
        now = self.system.clock.elapsed()
        self.system.run(now + round(seconds * SECOND))
        return self.system.state("CanopenManager0")

    def activate(self, seconds: float = 1.0) -> LifeCycleState:
        self.system.activate("CanopenManager0")
        return self.run(seconds)


@pytest.fixture
def bench() -> Iterator[Bench]:
    with System() as system:
        yield Bench(system)


def test_active_it_runs_the_network(bench: Bench) -> None:
    assert bench.manager.reports() == []
    assert bench.activate() is ACTIVE_STATE
    assert bench.bus.bit_rate == 1_000_000
    for number, slave in bench.slaves.items():
        assert slave.nmt.state is NmtState.OPERATIONAL
        phases = [phase for node, phase in bench.listener.states if node == number]
        assert phases[0] is NodePhase.AWAITED
        assert phases[-1] is NodePhase.RUNNING
        states = zip(bench.listener.states, bench.listener.times, strict=True)
        times = [time for (node, _), time in states if node == number]
        assert times == sorted(times)
    assert [sample.data for sample in bench.manager.reports()] == [507, 607]
    assert bench.manager.lost == 0


def test_deactivated_the_nodes_are_in_pre_operational(bench: Bench) -> None:
    bench.activate()
    bench.system.deactivate("CanopenManager0")
    assert bench.run(0.2) is INACTIVE_STATE
    for number, slave in bench.slaves.items():
        assert slave.nmt.state is NmtState.PRE_OPERATIONAL
        assert (number, NodePhase.IDLE) in bench.listener.states
    assert bench.bus.master is None
    assert bench.activate() is ACTIVE_STATE
    assert bench.bus.master is bench.manager.station
    assert bench.slaves[5].nmt.state is NmtState.OPERATIONAL


def test_a_mandatory_node_that_fails_leads_to_error(bench: Bench) -> None:
    bench.activate()
    bench.slaves[5].dead = True
    assert bench.run(0.32) is ERROR_STATE
    expected = "left (node 5): its heartbeat is lost: none for 300 ms"
    assert bench.manager.reason == expected
    # The other one continues, and is still served.
    assert bench.slaves[6].nmt.state is NmtState.OPERATIONAL
    assert bench.manager.refusal(NmtCommand.STOP, 6) == ""
    bench.run(0.2)
    assert bench.listener.states[-1] == (6, NodePhase.HALTED)
    bench.slaves[5].dead = False
    bench.system.reset("CanopenManager0")
    assert bench.run(0.1) is INACTIVE_STATE
    assert bench.activate() is ACTIVE_STATE
    assert bench.slaves[5].nmt.state is NmtState.OPERATIONAL


def test_a_node_that_may_be_missing_is_no_error(bench: Bench) -> None:
    bench.slaves[6].dead = True
    assert bench.activate(3) is ACTIVE_STATE
    assert (6, NodePhase.MISSING) in bench.listener.states


@pytest.mark.parametrize(
    ("command", "state"),
    [
        (NmtCommand.STOP, NmtState.STOPPED),
        (NmtCommand.ENTER_PRE_OPERATIONAL, NmtState.PRE_OPERATIONAL),
        (NmtCommand.RESET_NODE, NmtState.OPERATIONAL),
    ],
)
def test_commands(bench: Bench, command: NmtCommand, state: NmtState) -> None:
    assert bench.manager.refusal(command, 5) == "the network does not run"
    bench.activate()
    assert bench.manager.refusal(command, 7) == "the network pair has no node 7"
    assert bench.manager.refusal(command, 5) == ""
    bench.run(0.5)
    assert bench.slaves[5].commands[2] is command
    assert bench.slaves[5].nmt.state is state
    assert bench.slaves[6].nmt.state is NmtState.OPERATIONAL
    bench.manager.refusal(NmtCommand.STOP, 0)
    bench.run(0.1)
    assert bench.slaves[6].nmt.state is NmtState.STOPPED


@pytest.mark.parametrize("network", ["", "trio", "../pair"])
def test_unknown_networks(bench: Bench, network: str) -> None:
    bench.system.configure("CanopenManager0", "network", network)
    assert bench.activate(0.1) is ERROR_STATE
    expected = f"there is no network {network!r}; there are pair"
    assert bench.manager.reason == expected


def test_a_project_without_networks() -> None:
    for package in ("", "sample_networks.nothing"):
        with pytest.raises(UnknownNetworkError, match="none is generated"):
            load_network(package, "pair")


def test_a_bus_that_cannot_be_opened(bench: Bench) -> None:
    bench.bus.bit_rate = 125_000
    assert bench.activate(0.1) is ERROR_STATE
    assert "125000 bit/s" in bench.manager.reason


def test_one_manager_for_each_bus(bench: Bench) -> None:
    bench.activate()
    other = SampleManager()
    other.instance_name = "CanopenManager1"
    bench.system.add(other)
    bench.system.activate("CanopenManager1")
    bench.run(0.1)
    assert other.reason == "there is another NMT master on this bus"
    assert bench.bus.master is bench.manager.station


def test_the_phases_are_those_of_the_shared_idl() -> None:
    text = idl_file("Canopen.idl").read_text(encoding="utf-8")
    body = text.partition("enum NodePhase {")[2].partition("}")[0]
    names = re.findall(r"NODE_(\w+),? ///<", body)
    assert names == [phase.name for phase in NodePhase]
