"""The manager of a network: boot, supervision, restarts, requests of other stations, faults."""

from __future__ import annotations

from collections.abc import Iterable
from random import Random

import pytest
from msgspec.structs import replace
from slaves import IDENTITY, MS, Slave
from stations import Recorder

from rtgen.runtime import System
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.description import Network, NodeDescription, Write
from rtgen.runtime.canopen.master.managed_node import ManagedNode, NodePhase, NodeReport
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.emergency import Emergency, ErrorRegister
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState

SECOND = 1000 * MS
START, STOP, PRE, RESET_NODE, RESET_COMMUNICATION = NmtCommand
VALUE = b"\x11\x22\x33\x44"
HEARTBEAT = Write(0x1017, 0, (100).to_bytes(2, "little"))


def described(node_id: int = 5, **changes: object) -> NodeDescription:
    node = NodeDescription(
        name=f"n{node_id}",
        id=node_id,
        module="Drive",
        identity=IDENTITY,
        configuration=(HEARTBEAT, Write(0x2000, 0, VALUE)),
        pdos=(),
        heartbeat=100,
        heartbeat_timeout=300,
    )
    return replace(node, **changes)  # type: ignore[arg-type]


class Bench:
    """A manager, and slaves, on a simulated bus of 1 Mbit/s."""

    def __init__(
        self, *nodes: NodeDescription, sync: int = 0, heartbeat: int = 0
    ) -> None:
        self.system = System()
        assert self.system.clock.network is not None
        self.bus = simulated_bus(self.system.clock.network, "can0", 1_000_000)
        self.frames = Recorder()
        self.bus.attach(self.frames)
        self.slaves: dict[int, Slave] = {}
        self.reports: list[NodeReport] = []
        network = Network("net", 1000, 127, sync, heartbeat, nodes)
        self.manager = ManagerStation(self.bus, network, self.reports.append)

    def slave(self, node_id: int = 5, **changes: object) -> Slave:
        slave = Slave(node_id)
        for name, value in changes.items():
            setattr(slave, name, value)
        self.slaves[node_id] = slave
        self.bus.attach(slave)
        return slave

    def run(self, seconds: float) -> None:
        now = self.system.clock.elapsed()
        self.system.run(now + round(seconds * SECOND))

    def start(self, seconds: float = 1.0) -> None:
        self.manager.start()
        self.run(seconds)

    def node(self, node_id: int = 5) -> ManagedNode:
        return self.manager.nodes[node_id]

    def phases(self, node_id: int = 5) -> list[NodePhase]:
        phases: list[NodePhase] = []
        for report in self.reports:
            if report.id == node_id and report.phase not in phases[-1:]:
                phases.append(report.phase)
        return phases

    def sent(self, can_id: int) -> list[bytes]:
        return [frame.data for frame in self.frames.frames if frame.can_id == can_id]


def booted(*nodes: NodeDescription, **options: int) -> Bench:
    """Return a bench whose slaves are all operational."""
    bench = Bench(*(nodes or (described(),)), **options)
    for node in nodes or (described(),):
        bench.slave(node.id)
    bench.start()
    return bench


def test_a_node_is_reset_identified_configured_read_back_and_started() -> None:
    bench = booted()
    assert bench.phases() == [
        NodePhase.AWAITED,
        NodePhase.IDENTIFYING,
        NodePhase.CONFIGURING,
        NodePhase.STARTING,
        NodePhase.RUNNING,
    ]
    slave = bench.slaves[5]
    assert slave.commands == [RESET_COMMUNICATION, START]
    assert slave.writes == [((0x1017, 0), b"\x64\x00"), ((0x2000, 0), VALUE)]
    assert slave.nmt.state is NmtState.OPERATIONAL
    # Identity and both values are read, in this order; the values are written before.
    requests = " ".join(data[:4].hex() for data in bench.sent(0x605))
    assert requests == (
        "40001000 40181001 40181002 40181003 40181004 2b171000 23002000 40171000 40002000"
    )
    assert bench.sent(0x705)[:2] == [b"\0", b"\x7f"]
    assert bench.node().nmt is NmtState.OPERATIONAL
    assert bench.manager.failure == ""
    assert bench.manager.reports() == [bench.node().report()]


def test_what_is_not_expected_is_not_read() -> None:
    node = described(
        identity=(None, 0x9A, None, None, None),
        configuration=(Write(0x2000, 0, VALUE, verify=False),),
        heartbeat=0,
        heartbeat_timeout=0,
    )
    bench = Bench(node)
    bench.slave()
    bench.start()
    assert [data[:4].hex() for data in bench.sent(0x605)] == ["40181001", "23002000"]
    assert bench.phases()[-1] is NodePhase.RUNNING


def test_what_is_written_several_times_is_read_back_once() -> None:
    writes = tuple(Write(0x2001, 0, bytes((number, 0, 0, 0))) for number in (128, 0, 3))
    bench = booted(described(configuration=(HEARTBEAT, *writes)))
    reads = [data for data in bench.sent(0x605) if data[:4].hex() == "40012000"]
    assert len(reads) == 1
    assert bench.phases()[-1] is NodePhase.RUNNING


def test_long_values_are_written_in_segments() -> None:
    text = bytes(range(1, 200))
    bench = booted(described(configuration=(HEARTBEAT, Write(0x2003, 0, text))))
    assert bench.slaves[5].values[0x2003, 0] == text
    assert bench.phases()[-1] is NodePhase.RUNNING


def test_a_node_that_is_not_to_be_started_is_ready() -> None:
    bench = booted(described(start=False))
    assert bench.phases()[-1] is NodePhase.READY
    assert bench.slaves[5].nmt.state is NmtState.PRE_OPERATIONAL
    bench.manager.request(START, 5)
    bench.run(0.5)
    assert bench.phases()[-1] is NodePhase.RUNNING


def test_nodes_boot_in_parallel() -> None:
    nodes = [described(number) for number in range(1, 9)]
    bench = Bench(*nodes)
    for node in nodes:
        bench.slave(node.id, boot_time=100 * MS)
    bench.start(0.25)
    assert {node.phase for node in bench.manager.nodes.values()} == {NodePhase.RUNNING}


# SYNC and heartbeat of the manager


def test_sync_and_heartbeat_of_the_manager() -> None:
    bench = booted(sync=10_000, heartbeat=50)
    assert len(bench.sent(0x80)) == 100
    beats = bench.sent(0x77F)
    assert beats == [b"\0"] + [b"\x05"] * 19
    bench.manager.halt()
    bench.run(1)
    assert len(bench.sent(0x80)) == 100
    assert bench.sent(0x77F)[20:] == [b"\x7f"] * 20
    assert bench.slaves[5].nmt.state is NmtState.PRE_OPERATIONAL
    assert bench.phases()[-1] is NodePhase.IDLE
    assert bench.bus.master is None


def test_the_sync_counter() -> None:
    bench = Bench()
    network = replace(bench.manager.network, sync=10_000, sync_overflow=3)
    manager = ManagerStation(bench.bus, network)
    manager.start()
    bench.run(0.05)
    assert bench.sent(0x80) == [b"\1", b"\2", b"\3", b"\1", b"\2"]


def test_a_network_is_started_again_from_the_beginning() -> None:
    bench = booted()
    bench.manager.halt()
    bench.run(1)
    bench.reports.clear()
    bench.start()
    assert bench.phases()[0] is NodePhase.AWAITED
    assert bench.phases()[-1] is NodePhase.RUNNING
    bench.manager.close()
    assert bench.bus.master is None


def test_one_master_for_each_bus() -> None:
    bench = booted()
    other = ManagerStation(bench.bus, bench.manager.network)
    with pytest.raises(RuntimeError, match="another NMT master"):
        other.start()


# Nodes that do not boot


def test_a_mandatory_node_that_never_speaks_fails() -> None:
    bench = Bench(described(), described(6))
    bench.slave(6)
    bench.start(1.9)
    assert bench.manager.failure == ""
    bench.run(0.2)
    assert bench.phases() == [NodePhase.AWAITED, NodePhase.FAILED]
    assert bench.manager.failure == "n5 (node 5): no boot-up message within 2000 ms"
    assert bench.phases(6)[-1] is NodePhase.RUNNING


def test_a_node_that_may_be_missing_joins_later() -> None:
    bench = Bench(described(mandatory=False))
    bench.start(3)
    assert bench.phases() == [NodePhase.AWAITED, NodePhase.MISSING]
    assert bench.manager.failure == ""
    slave = bench.slave()
    slave.power_on(bench.bus.now())
    bench.bus.refresh(slave)
    bench.run(1)
    assert bench.phases()[-1] is NodePhase.RUNNING


def test_a_missing_node_that_beats_is_booted() -> None:
    bench = Bench(described(mandatory=False))
    bench.start(3)
    bench.slave()
    bench.bus.send([Frame(0x705, b"\x7f")])
    bench.run(1)
    assert bench.slaves[5].commands == [RESET_COMMUNICATION, START]
    assert bench.phases()[-1] is NodePhase.RUNNING


@pytest.mark.parametrize(
    ("place", "text"),
    [
        (0, "device type (1000:0) is 00000007h, not 00020192h"),
        (1, "vendor (1018:1) is 00000007h, not 0000009Ah"),
        (2, "product (1018:2) is 00000007h, not 00001234h"),
        (3, "revision (1018:3) is 00000007h, not 00010002h"),
        (4, "serial number (1018:4) is 00000007h, not 0000004Dh"),
    ],
)
def test_a_wrong_identity_is_final(place: int, text: str) -> None:
    bench = Bench(described(restarts=3))
    identity = list(IDENTITY)
    identity[place] = 7
    slave = Slave(5, tuple(identity))
    bench.bus.attach(slave)
    bench.start()
    assert bench.node().phase is NodePhase.FAILED
    assert bench.manager.failure == f"n5 (node 5): wrong identity: {text}"
    assert slave.writes == []
    assert slave.commands == [RESET_COMMUNICATION]


@pytest.mark.parametrize("code", sorted(sdo.ABORT_TEXTS))
def test_every_abort_is_reported(code: int) -> None:
    bench = Bench(described())
    bench.slave(refused={(0x2000, 0): code})
    bench.start()
    expected = f"2000:0 cannot be written: {code:08X}h {sdo.ABORT_TEXTS[code]}"
    assert bench.node().reason == expected
    assert bench.node().phase is NodePhase.FAILED


def test_an_identity_that_cannot_be_read() -> None:
    bench = Bench(described())
    slave = bench.slave()
    del slave.values[0x1018, 4]
    bench.start()
    reason = "1018:4 cannot be read: 06020000h object does not exist"
    assert bench.node().reason == reason


def test_a_value_that_is_not_kept() -> None:
    bench = Bench(described())
    bench.slave(forgetful={(0x2000, 0)})
    bench.start()
    reason = "2000:0 was written as 11 22 33 44, but reads 00 00 00 00"
    assert bench.node().reason == reason


def test_padding_behind_a_value_is_no_difference() -> None:
    bench = booted(
        described(configuration=(HEARTBEAT, Write(0x2002, 0, b"\x05\0\0\0")))
    )
    slave = bench.slaves[5]
    assert bench.phases()[-1] is NodePhase.RUNNING
    slave.read = lambda index, subindex: b"\x05\0\0\0\0\0\0\1"  # type: ignore[method-assign]
    bench.manager.request(RESET_NODE, 5)
    bench.run(1)
    assert bench.node().phase is NodePhase.FAILED


def test_an_sdo_server_that_is_silent() -> None:
    bench = Bench(described())
    bench.slave().identifiers = frozenset((0,))
    # Three attempts of 1 s each, and between them late answers are drained for 1 s.
    bench.start(4.9)
    assert bench.node().phase is NodePhase.IDENTIFYING
    bench.run(0.2)
    assert bench.node().reason == "1000:0 cannot be read: 05040000h protocol timed out"
    requests = [data for data in bench.sent(0x605) if data[0] == 0x40]
    assert len(requests) == 3


def losing(can_id: int, *commands: int) -> Bench:
    """Return a bench that loses the first frame of each command; 2003h gets 100 octets."""
    writes = (HEARTBEAT, Write(0x2003, 0, bytes(100)), Write(0x2002, 0, VALUE))
    bench = Bench(described(configuration=writes))
    bench.slave()
    lost = set(commands)

    def lose(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
        if frame.can_id == can_id and frame.data[0] in lost:
            lost.discard(frame.data[0])
            return []
        return [(0, frame)]

    bench.bus.disturbance = lose
    bench.start(20)
    assert not lost
    return bench


@pytest.mark.parametrize(
    ("can_id", "command"),
    [
        pytest.param(0x605, 0x40, id="request to read"),
        pytest.param(0x585, 0x43, id="answer to it"),
        pytest.param(0x605, 0x23, id="request to write"),
        pytest.param(0x585, 0x60, id="answer to it "),
        pytest.param(0x605, 0x10, id="segment"),
        pytest.param(0x585, 0x30, id="answer to it  "),
    ],
)
def test_a_lost_frame_of_the_set_up_is_made_good(can_id: int, command: int) -> None:
    bench = losing(can_id, command)
    node = bench.node()
    assert (node.restarts, node.reason, node.phase) == (0, "", NodePhase.RUNNING)
    slave = bench.slaves[5]
    assert slave.values[0x2003, 0] == bytes(100)
    assert slave.values[0x2002, 0] == VALUE


def test_more_losses_than_attempts() -> None:
    bench = Bench(described())
    bench.slave()
    bench.bus.disturbance = lambda frame, now: (
        [] if frame.can_id == 0x605 and frame.data[0] == 0x23 else [(0, frame)]
    )
    bench.start(10)
    reason = "2000:0 cannot be written: 05040000h protocol timed out"
    assert bench.node().reason == reason
    assert bench.node().phase is NodePhase.FAILED


def test_a_write_that_may_be_a_command_is_not_repeated() -> None:
    command = Write(0x2000, 0, VALUE, verify=False)
    bench = Bench(described(configuration=(HEARTBEAT, command)))
    slave = bench.slave()
    bench.bus.disturbance = lambda frame, now: (
        []
        if frame.can_id == 0x585 and frame.data[0] == 0x60 and slave.writes[1:]
        else [(0, frame)]
    )
    bench.start(10)
    assert slave.writes.count(((0x2000, 0), VALUE)) == 1
    reason = "2000:0 cannot be written: 05040000h protocol timed out"
    assert bench.node().reason == reason


# Supervision


def test_a_lost_heartbeat_is_found_within_its_time_out() -> None:
    bench = booted()
    bench.slaves[5].dead = True
    bench.run(0.301)
    assert bench.node().reason == "its heartbeat is lost: none for 300 ms"
    assert bench.node().phase is NodePhase.FAILED
    assert bench.node().nmt is None


def test_jitter_within_the_time_out_is_no_error() -> None:
    bench = booted()
    delays = iter(range(1000))

    def jitter(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
        late = next(delays) * 67 % 190 if frame.can_id == 0x705 else 0
        return [(late * MS, frame)]

    bench.bus.disturbance = jitter
    bench.run(20)
    assert bench.phases()[-1] is NodePhase.RUNNING
    assert bench.node().reason == ""


def test_heartbeats_that_were_held_up_are_not_those_of_two_nodes() -> None:
    bench = booted()
    held: list[Frame] = []

    def hold(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
        late = 280 - now // MS % 280 if frame.can_id == 0x705 else 0
        held.extend([frame] * (late > 0))
        return [(late * MS, frame)]

    bench.bus.disturbance = hold
    bench.run(30)
    assert len(held) > 200
    assert bench.phases()[-1] is NodePhase.RUNNING


def test_a_node_without_heartbeat_falls_to_a_time_out() -> None:
    bench = Bench(described(configuration=()))
    bench.slave()
    bench.start(2.2)
    assert bench.phases()[-1] is NodePhase.STARTING
    bench.run(0.2)
    reason = "no heartbeat within 2300 ms after its configuration"
    assert bench.node().reason == reason


def test_a_node_that_does_not_start() -> None:
    bench = Bench(described())
    bench.slave(obeys=lambda command: command is not START)
    bench.start(3)
    assert bench.node().reason == "it has not become operational within 2300 ms"


def test_restarts() -> None:
    bench = booted(described(restarts=2))
    slave = bench.slaves[5]
    for number in (1, 2):
        slave.dead = True
        bench.run(0.35)
        assert bench.node().phase is NodePhase.AWAITED
        slave.dead = False
        slave.power_on(bench.bus.now())
        bench.bus.refresh(slave)
        bench.run(1)
        assert bench.node().phase is NodePhase.RUNNING
        assert bench.node().restarts == number
    slave.dead = True
    bench.run(0.35)
    assert bench.node().phase is NodePhase.FAILED
    # A boot-up message makes it restart in any case.
    slave.dead = False
    slave.power_on(bench.bus.now())
    bench.bus.refresh(slave)
    bench.run(1)
    assert bench.node().phase is NodePhase.RUNNING
    assert bench.manager.failure == ""


def test_a_node_is_configured_again_after_every_boot_up() -> None:
    bench = booted()
    slave = bench.slaves[5]
    for _ in range(3):
        slave.writes.clear()
        slave.power_on(bench.bus.now())
        bench.bus.refresh(slave)
        bench.run(1)
        assert len(slave.writes) == 2
        assert bench.node().phase is NodePhase.RUNNING
        # The reason ends when the node runs.
        assert bench.node().reason == ""
        reasons = {r.reason for r in bench.reports if r.phase is NodePhase.CONFIGURING}
        assert "it booted again by itself" in reasons
    assert bench.node().restarts == 0


@pytest.mark.parametrize("manager_first", [True, False])
def test_nodes_that_power_up_with_the_manager_are_set_up_once(
    manager_first: bool,
) -> None:
    """Their boot-up messages wait on the bus, and come before or after the reset."""
    bench = Bench(described(5), described(6), heartbeat=100)
    slaves = [bench.slave(node_id, boot_time=0) for node_id in (5, 6)]
    if manager_first:
        bench.manager.start()
    for slave in slaves:
        slave.power_on(bench.bus.now())
        bench.bus.send(slave.poll(bench.bus.now()), slave)
    if not manager_first:
        bench.manager.start()
    bench.run(1)
    order = [f.can_id for f in bench.frames.frames if f.can_id in (0, 0x605, 0x606)]
    assert order[0] == 0
    assert bench.sent(0)[0] == bytes((RESET_COMMUNICATION, 0))
    for slave in slaves:
        requests = bench.sent(0x600 + slave.node_id)
        assert sum(data.startswith(b"\x40\x00\x10") for data in requests) == 1
        assert len(slave.writes) == 2
        assert bench.node(slave.node_id).phase is NodePhase.RUNNING
    assert not any(report.reason for report in bench.reports)


def test_a_transfer_with_a_node_that_boots_again_ends_at_once() -> None:
    bench = booted()
    slave = bench.slaves[5]
    done: list[object] = []
    slave.dead = True
    bench.bus.sdo(5).submit_upload(0x2000, 0, done.append)
    bench.run(0.05)
    slave.dead = False
    slave.power_on(bench.bus.now())
    bench.bus.refresh(slave)
    bench.run(0.1)
    assert [str(outcome) for outcome in done] == [
        str(sdo.SdoAbort(sdo.DEVICE_STATE)),
    ]
    assert bench.node().phase is NodePhase.STARTING


@pytest.mark.parametrize(
    ("command", "phase", "reason"),
    [
        (RESET_COMMUNICATION, NodePhase.RUNNING, "it booted again"),
        (RESET_NODE, NodePhase.RUNNING, "it booted again"),
        (PRE, NodePhase.HALTED, "it has left operational"),
        (STOP, NodePhase.FAILED, "it has stopped"),
    ],
)
def test_what_another_station_commands_is_not_by_itself(
    command: NmtCommand, phase: NodePhase, reason: str
) -> None:
    bench = booted()
    for data in (bytes((command, 6)), bytes((command, 5))):
        bench.bus.send([Frame(0, data)])
    bench.run(1)
    assert bench.node().phase is phase
    reasons = {report.reason for report in bench.reports if report.reason}
    assert reasons == {f"{reason} by a command of another station"}
    # The next time it does so by itself.
    bench.manager.request(RESET_NODE, 5)
    bench.run(1)
    bench.reports.clear()
    slave = bench.slaves[5]
    slave.power_on(bench.bus.now())
    bench.bus.refresh(slave)
    bench.run(1)
    assert {r.reason for r in bench.reports if r.reason} == {
        "it booted again by itself"
    }


def test_a_node_that_leaves_operational_by_itself() -> None:
    bench = booted()
    slave = bench.slaves[5]
    bench.bus.send([Emergency(0x8130, ErrorRegister.COMMUNICATION).frame(5)])
    slave.nmt.state = NmtState.PRE_OPERATIONAL
    bench.run(0.2)
    assert bench.node().phase is NodePhase.HALTED
    assert bench.node().reason == (
        "it has left operational by itself, "
        "after EMCY 8130h heartbeat or guarding lost (communication)"
    )
    slave.nmt.state = NmtState.OPERATIONAL
    bench.run(0.2)
    assert bench.node().phase is NodePhase.RUNNING
    slave.nmt.fail()
    bench.bus.send([Emergency(0, ErrorRegister(0)).frame(5)])
    bench.run(0.2)
    assert bench.node().phase is NodePhase.FAILED
    assert bench.node().reason == "it has stopped by itself"


# Requests of other stations


@pytest.mark.parametrize(
    ("command", "state"),
    [(STOP, NmtState.STOPPED), (PRE, NmtState.PRE_OPERATIONAL)],
)
@pytest.mark.parametrize("node_id", [0, 5])
def test_halting_and_starting(
    command: NmtCommand, state: NmtState, node_id: int
) -> None:
    bench = booted()
    slave = bench.slaves[5]
    assert bench.bus.master is bench.manager
    bench.bus.master.request(command, node_id)
    bench.run(0.2)
    assert slave.nmt.state is state
    assert bench.node().phase is NodePhase.HALTED
    assert bench.node().reason == ""
    bench.bus.master.request(START, node_id)
    bench.run(0.2)
    assert bench.node().phase is NodePhase.RUNNING
    assert slave.commands[2:] == [command, START]


@pytest.mark.parametrize("command", [RESET_NODE, RESET_COMMUNICATION])
@pytest.mark.parametrize("node_id", [0, 5])
def test_resets(command: NmtCommand, node_id: int) -> None:
    bench = booted()
    slave = bench.slaves[5]
    slave.writes.clear()
    bench.manager.request(command, node_id)
    bench.run(1)
    assert slave.commands == [RESET_COMMUNICATION, START, command, START]
    assert len(slave.writes) == 2
    assert bench.node().phase is NodePhase.RUNNING
    assert bench.node().reason == ""


def test_a_reset_brings_a_failed_node_back() -> None:
    bench = booted()
    slave = bench.slaves[5]
    slave.dead = True
    bench.run(1)
    assert bench.node().phase is NodePhase.FAILED
    slave.dead = False
    bench.manager.request(RESET_NODE, 5)
    bench.run(1)
    assert bench.node().phase is NodePhase.RUNNING
    assert bench.manager.failure == ""


def test_start_of_a_failed_node_boots_it() -> None:
    bench = booted(described(start=False))
    slave = bench.slaves[5]
    slave.dead = True
    bench.run(1)
    slave.dead = False
    bench.manager.request(START, 5)
    bench.run(1)
    assert bench.node().phase is NodePhase.RUNNING


def test_what_is_asked_while_a_node_boots_waits() -> None:
    bench = Bench(described(start=False))
    slave = bench.slave(boot_time=100 * MS)
    bench.start(0.05)
    bench.manager.request(START, 5)
    bench.run(0.5)
    assert bench.phases()[-1] is NodePhase.RUNNING
    slave.boot_time = 100 * MS
    bench.manager.request(RESET_NODE, 5)
    bench.run(0.05)
    # STOPPED, it would send nothing, and could not be configured.
    bench.manager.request(STOP, 5)
    bench.run(0.5)
    assert bench.node().phase is NodePhase.READY
    assert STOP not in slave.commands


def test_nodes_that_are_not_in_the_network_get_commands_too() -> None:
    bench = booted()
    foreign = bench.slave(9)
    bench.manager.request(RESET_NODE, 9)
    bench.run(0.1)
    assert foreign.commands == [RESET_NODE]


# Two nodes with one id


def test_two_nodes_with_one_id() -> None:
    bench = Bench(described(restarts=1))
    slaves = [bench.slave(boot_time=late * MS) for late in (1, 2)]
    bench.start(5)
    assert bench.node().phase is NodePhase.FAILED
    assert bench.node().restarts == 1
    assert "two nodes have the id 5" in bench.manager.failure
    assert {slave.nmt.state for slave in slaves} == {NmtState.PRE_OPERATIONAL}


def test_a_second_node_with_the_id_comes_later() -> None:
    bench = booted()
    second = Slave(5)
    bench.bus.attach(second)
    second.power_on(bench.bus.now())
    bench.bus.refresh(second)
    bench.run(2)
    assert bench.node().phase is NodePhase.FAILED
    assert "two nodes have the id 5" in bench.node().reason


def test_heartbeats_of_two_nodes() -> None:
    bench = booted()
    for number in range(40):
        instant = bench.system.clock.elapsed() + number * 100 * MS
        bench.system.at(instant, lambda: bench.bus.send([Frame(0x705, b"\x7f")]))
    bench.run(3)
    assert bench.node().phase is NodePhase.FAILED
    assert bench.node().reason == (
        "its heartbeat comes twice as often as it should: two nodes have the id 5"
    )


def test_another_node_has_the_id_of_the_manager() -> None:
    bench = booted()
    bench.bus.send([Frame(0x77F, b"\x05")])
    bench.run(0.1)
    assert bench.manager.failure == "another node has the manager's node-id 127"


# Bus off and recovery


def test_bus_off_and_return() -> None:
    bench = booted(sync=10_000, heartbeat=50)
    bench.bus.cut()
    bench.run(1)
    assert bench.node().phase is NodePhase.AWAITED
    assert bench.node().reason == "the bus is gone"
    bench.manager.request(START, 5)
    syncs = len(bench.sent(0x80))
    bench.bus.mend()
    bench.run(1)
    assert bench.node().phase is NodePhase.RUNNING
    assert bench.node().reason == ""
    assert len(bench.sent(0x80)) == syncs + 100


def test_a_bus_that_does_not_come_back() -> None:
    bench = booted()
    bench.bus.cut()
    bench.run(2.5)
    assert bench.node().phase is NodePhase.FAILED
    assert bench.manager.failure == "n5 (node 5): the bus is gone"


def test_a_manager_that_starts_without_bus() -> None:
    bench = Bench(described())
    bench.slave()
    bench.bus.cut()
    bench.start(0.5)
    bench.bus.mend()
    bench.run(1)
    assert bench.node().phase is NodePhase.RUNNING


def test_126_nodes_are_looked_at_only_when_they_are_due() -> None:
    nodes = [described(number) for number in range(1, 127)]
    bench = booted(*nodes)
    polls = 0
    poll = bench.manager.poll

    def counted(now: int) -> Iterable[Frame]:
        nonlocal polls
        polls += 1
        return poll(now)

    bench.manager.poll = counted  # type: ignore[method-assign]
    bench.run(3)
    assert {node.phase for node in bench.manager.nodes.values()} == {NodePhase.RUNNING}
    # 126 heartbeats each 0.1 s, and a time-out of 0.3 s: one check for each node and time-out,
    # which may begin before the window.
    assert polls <= 126 * (3 / 0.3 * 1.5 + 1)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", range(8))
def test_whatever_happens_a_reset_brings_the_network_back(seed: int) -> None:
    random = Random(seed)
    nodes = [described(number, restarts=number % 3) for number in (5, 6, 7)]
    bench = booted(*nodes, sync=20_000, heartbeat=50)
    identifiers = (0x77F, 0x7E4, 0x80, *(0x80 + n for n in range(5, 8)))
    identifiers += tuple(base + n for base in (0x580, 0x700) for n in range(5, 8))

    def frame() -> None:
        data = random.choice((random.randbytes(random.randrange(9)), b"\0", b"\x7f"))
        bench.bus.send([Frame(random.choice(identifiers), data)])

    def switch_off() -> None:
        random.choice(list(bench.slaves.values())).dead = True

    def switch_on(slave: Slave) -> None:
        slave.dead = False
        slave.power_on(bench.bus.now())
        bench.bus.refresh(slave)

    def request() -> None:
        command = random.choice(list(NmtCommand))
        bench.manager.request(command, random.choice((0, 5, 6, 7, 8)))

    for _ in range(150):
        event = random.randrange(10)
        if event < 5 and bench.bus.up:
            frame()
        elif event == 5:
            switch_off()
        elif event == 6:
            switch_on(random.choice(list(bench.slaves.values())))
        elif event == 7:
            bench.bus.cut() if bench.bus.up else bench.bus.mend()
        else:
            request()
        bench.run(random.choice((0.001, 0.02, 0.3, 2.5)))
    bench.bus.mend()
    for slave in bench.slaves.values():
        switch_on(slave)
    bench.manager.request(RESET_NODE, 0)
    bench.run(30)
    assert {node.phase for node in bench.manager.nodes.values()} == {NodePhase.RUNNING}
    states = {slave.nmt.state for slave in bench.slaves.values()}
    assert states == {NmtState.OPERATIONAL}


@pytest.mark.parametrize("deaf", [0x1000, 0x1018])
def test_two_nodes_from_the_start_that_do_not_answer_everything(deaf: int) -> None:
    """Requests collide with responses of the other node and are lost, beyond a plain time-out."""
    bench = Bench(described())
    bench.slave()
    second = Slave(5)
    bench.bus.attach(second)
    second.boot_time = 3 * MS
    bench.bus.disturbance = lambda frame, now: (
        []
        if frame.can_id == 0x605 and frame.data[1:3] == deaf.to_bytes(2, "little")
        else [(0, frame)]
    )
    bench.start(20)
    assert bench.node().phase is NodePhase.FAILED
    assert "05040000h protocol timed out, and " in bench.node().reason
    assert bench.node().reason.endswith(": two nodes have the id 5")
