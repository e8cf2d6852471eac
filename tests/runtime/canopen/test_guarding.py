"""Node guarding by managers and proxies, life guarding in devices (CiA 301, 7.2.8.2.2)."""

from __future__ import annotations

import logging
import struct
from collections.abc import Iterable
from itertools import pairwise

import pytest
from device_bench import DEVICE, NODE_ID, var
from device_bench import Bench as DeviceBench
from msgspec.structs import replace
from proxy_bench import DESCRIPTION, MS, NODE, Bench, DriveProxy, SimpleNode
from slaves import IDENTITY, Slave
from stations import Recorder

from rtgen.runtime import System
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.description import Network, NodeDescription
from rtgen.runtime.canopen.master.managed_node import NodePhase
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import ERROR_CONTROL, Frame
from rtgen.runtime.canopen.wire.guarding import TOGGLE, NodeGuard
from rtgen.runtime.canopen.wire.nmt import NmtState

REQUEST = Frame(ERROR_CONTROL + NODE, remote=True)


def answer(octet: int) -> Frame:
    return Frame(ERROR_CONTROL + NODE, bytes((octet,)))


# The machine


def test_requests_keep_their_period_and_late_ones_are_left_out() -> None:
    guard = NodeGuard(NODE)
    assert guard.deadline is None
    guard.start(100, now=1000)
    assert guard.poll(1000) == REQUEST
    assert guard.poll(1099) is None
    assert guard.poll(1350) == REQUEST
    assert guard.deadline == 1400
    guard.stop()
    assert guard.poll(2000) is None


def test_a_repeated_toggle_bit_is_no_sign_of_life() -> None:
    guard = NodeGuard(NODE)
    guard.start(100, now=0)
    guard.poll(0)
    assert guard.accepts(answer(0x05))
    guard.poll(100)
    assert not guard.accepts(answer(0x05))
    assert guard.accepts(answer(0x85))
    guard.poll(
        200
    )  # This request is unanswered: the next one may have either toggle bit.
    guard.poll(300)
    assert guard.accepts(answer(0x85))


# Proxies


class GuardedNode(SimpleNode):
    """A node without 1017h that answers node guarding, unless `dead`."""

    def __init__(self, bench: Bench, guard_time: int = 0, factor: int = 0) -> None:
        super().__init__(bench.link)
        self.dead = False
        self.stuck = False
        self.toggle = 0
        self.identifiers |= {ERROR_CONTROL + NODE}
        self.objects.aborts["read", (0x1017, 0)] = sdo.NO_OBJECT
        self.objects.values[0x100C, 0] = struct.pack("<H", guard_time)
        self.objects.values[0x100D, 0] = bytes((factor,))
        self.boot()

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        if self.dead:
            return ()
        if frame.can_id != ERROR_CONTROL + NODE:
            return super().receive(frame, now)
        if not frame.remote:
            return ()
        reply = answer(self.state | self.toggle)
        self.toggle ^= 0 if self.stuck else TOGGLE
        return (reply,)


def guarded(guard_time: int = 0, factor: int = 0) -> tuple[Bench, GuardedNode]:
    """Return a proxy, ACTIVE, that is the master, and its node."""
    bench = Bench()
    node = GuardedNode(bench, guard_time, factor)
    bench.run(0.05)
    bench.activate()
    return bench, node


def requests(bench: Bench) -> list[int]:
    recorded = zip(bench.recorder.frames, bench.recorder.times, strict=True)
    return [time for frame, time in recorded if frame == REQUEST]


def test_a_proxy_guards_a_node_without_heartbeat() -> None:
    bench, node = guarded(guard_time=50, factor=4)
    with bench:
        assert node.state is NmtState.OPERATIONAL
        bench.run(1)
        times = requests(bench)
        assert {b - a for a, b in pairwise(times)} == {50 * MS}
        node.dead = True
        died = bench.system.time
        bench.until("ERROR")
        assert bench.reason == "node 5 is lost: no answer to node guarding for 200 ms"
        assert bench.system.time - died <= 210 * MS
        asked = len(requests(bench))
        bench.run(1)
        assert len(requests(bench)) == asked, "one that is lost is left alone"


def test_a_guarded_node_comes_back_by_a_reset() -> None:
    bench, node = guarded(guard_time=50, factor=4)
    with bench:
        node.dead = True
        bench.until("ERROR")
        node.dead = False
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        bench.activate()
        bench.run(1)
        assert bench.state == "ACTIVE"


def test_a_proxy_sets_the_guard_time_where_there_is_none() -> None:
    bench, node = guarded()
    with bench:
        assert node.objects.writes[:2] == [
            ((0x100C, 0), b"\x64\0"),
            ((0x100D, 0), b"\3"),
        ]
        node.dead = True
        bench.until("ERROR")
        assert bench.reason == "node 5 is lost: no answer to node guarding for 300 ms"


def test_a_node_whose_toggle_bit_sticks_is_lost() -> None:
    bench, node = guarded(guard_time=50, factor=4)
    with bench:
        node.stuck = True
        bench.until("ERROR")
        assert "no answer to node guarding" in bench.reason


def test_a_guarded_node_that_leaves_operational_is_followed() -> None:
    bench, node = guarded(guard_time=50, factor=4)
    with bench:
        node.nmt.state = NmtState.PRE_OPERATIONAL
        bench.until("INACTIVE")
        node.nmt.state = NmtState.STOPPED
        bench.until("ERROR")
        assert bench.reason == "node 5 was stopped"


def test_there_is_a_warning_for_a_node_that_nobody_supervises(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with Bench() as bench:
        node = bench.with_node()
        node.objects.aborts["read", (0x1017, 0)] = sdo.NO_OBJECT
        bench.run(0.05)
        with caplog.at_level(logging.WARNING):
            bench.activate()
        assert (
            "node 5 is not supervised: it has neither heartbeat nor node guarding"
            in caplog.messages
        )
        assert requests(bench) == []


def test_a_proxy_that_only_listens_finds_the_loss_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The master is in another process: its requests and the answers are on the bus."""
    objects = tuple(o for o in DESCRIPTION.objects if o.index != 0x1017)
    guarding = (var(0x100C, 0, "u16", default=50), var(0x100D, 0, "u8", default=4))
    described = replace(DESCRIPTION, objects=(*objects, *guarding))
    monkeypatch.setattr(DriveProxy, "description", described)
    with Bench(settings={"master": 0, "boot_timeout": 100}) as bench:
        node = GuardedNode(bench, 50, 4)
        node.nmt.state = NmtState.OPERATIONAL
        master = Recorder(0x7FF)
        master.period, master.poll_frames = 50 * MS, [REQUEST]
        master.deadline = 0
        bench.link.attach(master)
        bench.until("ACTIVE")
        node.dead = True
        bench.until("ERROR")
        assert bench.reason.endswith("for 200 ms")


# The manager


class GuardedSlave(Slave):
    """A slave of the manager's bench that answers node guarding."""

    def __init__(self) -> None:
        super().__init__(NODE)
        self.toggle = 0
        self.identifiers |= {ERROR_CONTROL + NODE}

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        if frame.can_id != ERROR_CONTROL + NODE:
            return super().receive(frame, now)
        if self.dead or not frame.remote:
            return []
        reply = answer(self.nmt.state | self.toggle)
        self.toggle ^= TOGGLE
        return [reply]


class Supervised:
    """A manager with one node that it guards every 100 ms, lost after 300 ms."""

    def __init__(self, restarts: int = 0) -> None:
        self.system = System()
        assert self.system.clock.network is not None
        self.bus = simulated_bus(self.system.clock.network, "can0", 1_000_000)
        described = NodeDescription(
            name="drive", id=NODE, module="Drive", identity=IDENTITY,
            configuration=(), pdos=(), heartbeat=0, heartbeat_timeout=300,
            guard_time=100, restarts=restarts,
        )  # fmt: skip
        network = Network("net", 1000, 127, 0, 0, (described,))
        self.manager = ManagerStation(self.bus, network)
        self.slave = GuardedSlave()
        self.bus.attach(self.slave)
        self.manager.start()

    def run(self, seconds: float) -> None:
        self.system.run(self.system.clock.elapsed() + round(seconds * 1e9))

    @property
    def phase(self) -> NodePhase:
        return self.manager.nodes[NODE].phase


def test_the_manager_guards_a_node_without_heartbeat() -> None:
    bench = Supervised()
    bench.run(5)
    assert bench.phase is NodePhase.RUNNING
    bench.slave.dead = True
    bench.run(0.5)
    assert bench.phase is NodePhase.FAILED
    assert bench.manager.failure == (
        "drive (node 5): it is lost: no answer to node guarding for 300 ms"
    )
    assert bench.manager.deadline is None, "it is not polled any more"


def test_the_manager_restarts_a_guarded_node() -> None:
    bench = Supervised(restarts=1)
    bench.run(1)
    bench.slave.dead = True
    bench.run(0.4)
    bench.slave.dead = False
    bench.slave.power_on(bench.system.clock.elapsed())
    bench.bus.refresh(bench.slave)
    bench.run(1)
    assert bench.phase is NodePhase.RUNNING


def test_a_bus_without_remote_frames_is_named() -> None:
    bench = Supervised()
    bench.bus.carries_remote_frames = False
    bench.run(1)
    assert bench.manager.failure == (
        "drive (node 5): the simulated bus can0 carries no remote frames, so nodes cannot "
        "be guarded"
    )


# Life guarding


def device(guard_time: int, factor: int, behaviour: int = 0) -> DeviceBench:
    objects = (
        *DEVICE.objects,
        var(0x100C, 0, "u16", default=guard_time),
        var(0x100D, 0, "u8", default=factor),
    )
    node = DeviceNode(replace(DEVICE, objects=objects), NODE_ID)
    bench = DeviceBench(node)
    bench.node.set(0x1029, 1, behaviour)
    bench.start()
    return bench


def test_life_guarding_begins_with_the_first_request() -> None:
    bench = device(100, 3)
    assert bench.run(5000) == []
    assert bench.give(ERROR_CONTROL + NODE_ID, remote=True) == [answer(0x05)]
    assert bench.run(299) == []
    assert bench.node.state is NmtState.OPERATIONAL
    (emergency,) = bench.run(1)
    assert emergency.data[:2] == b"\x30\x81"
    assert bench.node.state is NmtState.PRE_OPERATIONAL
    frames = bench.give(ERROR_CONTROL + NODE_ID, remote=True)
    assert frames[0] == answer(0xFF)
    assert frames[1].data[:2] == b"\0\0", "the error is gone"


@pytest.mark.parametrize(
    ("behaviour", "state"), [(1, NmtState.OPERATIONAL), (2, NmtState.STOPPED)]
)
def test_1029h_says_what_the_loss_of_the_master_means(
    behaviour: int, state: NmtState
) -> None:
    bench = device(50, 2, behaviour)
    bench.give(ERROR_CONTROL + NODE_ID, remote=True)
    bench.run(100)
    assert bench.node.state is state


def test_a_factor_of_0_supervises_nothing() -> None:
    bench = device(100, 0)
    bench.give(ERROR_CONTROL + NODE_ID, remote=True)
    assert bench.run(10_000) == []


def test_requests_in_time_keep_it_operational() -> None:
    bench = device(100, 2)
    for _ in range(50):
        assert len(bench.give(ERROR_CONTROL + NODE_ID, remote=True)) == 1
        assert bench.run(190) == []
