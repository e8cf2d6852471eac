"""Table 3 and figure 110 from both sides: the transitions of a proxy with their frames."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from msgspec.structs import replace
from proxy_bench import DESCRIPTION, MS, NODE, SECOND, Bench, DriveProxy, Objects

from rtgen.runtime import PRECONDITION_NOT_MET, SimulatedClock
from rtgen.runtime.canopen.description import ObjectDescription
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.emergency import Emergency, ErrorRegister
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState, command_frame

START, STOP, PREOP, RESET = (
    (command, NODE)
    for command in (
        NmtCommand.START,
        NmtCommand.STOP,
        NmtCommand.ENTER_PRE_OPERATIONAL,
        NmtCommand.RESET_NODE,
    )
)
BOOT, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F


def ready(**settings: object) -> Bench:
    """Return a proxy, INACTIVE, whose node has booted."""
    bench = Bench(settings=settings)
    bench.with_node()
    bench.run(0.05)
    return bench


def active(**settings: object) -> Bench:
    bench = ready(**settings)
    bench.activate()
    return bench


def in_error(**settings: object) -> Bench:
    bench = active(**settings)
    bench.node.go(NmtState.STOPPED)
    bench.until("ERROR")
    return bench


# From the component's side.


def test_1_and_2_a_proxy_is_inactive_before_its_node_is_there() -> None:
    with Bench() as bench:
        assert bench.state == "INACTIVE"
        bench.with_node()
        bench.run(0.1)
        assert bench.state == "INACTIVE"
        assert (bench.commands(), bench.error_control()) == ([], [BOOT])


def test_3_activate_starts_the_node() -> None:
    with ready() as bench:
        bench.activate()
        assert bench.commands() == [START]
        assert bench.error_control() == [BOOT, PRE_OPERATIONAL, OPERATIONAL]
        assert bench.proxy.calls == ["on_activated"]
        assert bench.node.state is NmtState.OPERATIONAL


def test_4_deactivate_brings_the_node_to_pre_operational() -> None:
    with active() as bench:
        bench.system.deactivate("Drive0")
        bench.until("INACTIVE")
        assert bench.commands() == [START, PREOP]
        assert bench.error_control()[-2:] == [OPERATIONAL, PRE_OPERATIONAL]
        assert bench.proxy.calls == ["on_activated", "on_deactivated"]


def test_5_a_callback_that_fails_stops_the_node() -> None:
    with active() as bench:
        bench.proxy.on_execute = lambda ec_id: bench.proxy.fail("on purpose")  # type: ignore[method-assign]
        bench.until("ERROR")
        bench.run(0.2)
        assert bench.commands() == [START, STOP]
        assert bench.error_control()[-2:] == [OPERATIONAL, STOPPED]
        assert bench.proxy.calls == ["on_activated", "on_aborting"]
        assert bench.reason == "on purpose"


def test_6_a_failure_while_inactive_stops_the_node() -> None:
    with ready() as bench:
        bench.system.context("Drive0").fail_component(bench.proxy, "check failed")
        bench.until("ERROR")
        bench.run(0.2)
        assert bench.commands() == [STOP]
        assert bench.node.state is NmtState.STOPPED
        assert bench.reason == "check failed"


def test_7_and_8_reset_waits_for_the_boot_up_message() -> None:
    with in_error() as bench:
        bench.node.delay = 300 * MS
        begun = bench.system.time
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        assert bench.system.time - begun >= 300 * MS
        assert bench.commands() == [START, RESET]
        bench.run(0.2)
        assert bench.error_control()[-3:] == [STOPPED, BOOT, PRE_OPERATIONAL]
        assert bench.proxy.calls[-2:] == ["on_aborting", "on_reset"]
        assert bench.reason == ""
        bench.activate()
        assert bench.node.state is NmtState.OPERATIONAL


def test_8_the_device_says_how_long_it_takes_to_boot(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    slow = ObjectDescription(0x1F89, 0, "Boot_time", "u32", "rw", 4000)
    objects = (*DESCRIPTION.objects, slow)
    monkeypatch.setattr(
        DriveProxy, "description", replace(DESCRIPTION, objects=objects)
    )
    with in_error() as bench:
        bench.node.delay = 3900 * MS
        bench.system.reset("Drive0")
        bench.until("INACTIVE")


def test_9_a_reset_without_boot_up_message_stays_in_error() -> None:
    with in_error(boot_timeout=700) as bench:
        bench.node.obeys = False
        begun = bench.system.time
        bench.system.reset("Drive0")
        bench.run(0.05)
        assert (
            bench.system.statistics("Drive0").awaited == "the boot-up message of node 5"
        )
        bench.run(1.0)
        assert bench.state == "ERROR"
        assert bench.reason == "node 5: no boot-up message within 0.7 s"
        assert bench.proxy.calls[-1] == "on_aborting"
        assert bench.system.time - begun < SECOND * 2
        bench.node.obeys = True
        bench.system.reset("Drive0")
        bench.until("INACTIVE")


def test_10_exit_brings_the_node_to_pre_operational() -> None:
    with active() as bench:
        bench.system.remove("Drive0")
        bench.run(0.2)
        assert bench.commands() == [START, PREOP]
        assert bench.node.state is NmtState.PRE_OPERATIONAL


def test_error_is_left_by_reset_alone() -> None:
    with in_error() as bench:
        bench.node.go(NmtState.PRE_OPERATIONAL)
        bench.run(0.3)
        bench.node.go(NmtState.OPERATIONAL)
        bench.run(0.3)
        assert bench.state == "ERROR"
        assert bench.system.activate("Drive0") is PRECONDITION_NOT_MET


# From the node's side: unrequested changes.


def test_3_an_operational_node_activates() -> None:
    with ready() as bench:
        bench.node.go(NmtState.OPERATIONAL)
        bench.until("ACTIVE")
        assert bench.commands() == []
        assert bench.proxy.calls == ["on_activated"]


def test_4_a_pre_operational_node_deactivates() -> None:
    with active() as bench:
        bench.node.go(NmtState.PRE_OPERATIONAL)
        bench.until("INACTIVE")
        assert bench.commands() == [START]
        assert bench.proxy.calls == ["on_activated", "on_deactivated"]


@pytest.mark.parametrize("before", [ready, active])
def test_5_and_6_a_stopped_node_is_an_error(before: object) -> None:
    with before() as bench:  # type: ignore[operator]
        asked = bench.commands()
        bench.node.go(NmtState.STOPPED)
        bench.until("ERROR")
        assert bench.reason == "node 5 was stopped"
        assert bench.commands() == asked, "it is stopped already"
        assert bench.proxy.calls[-1] == "on_aborting"


def test_a_boot_up_message_while_active_is_an_error() -> None:
    with active() as bench:
        bench.node.beat(NmtState.INITIALISING)
        bench.until("ERROR")
        bench.run(0.1)
        assert bench.reason == "node 5 booted while it was operational"
        assert bench.commands() == [START, STOP]


def test_a_boot_up_message_while_inactive_is_none() -> None:
    with ready() as bench:
        bench.node.beat(NmtState.INITIALISING)
        bench.run(0.3)
        assert bench.state == "INACTIVE"


@pytest.mark.parametrize("before", [ready, active])
@pytest.mark.parametrize("timeout", [0, 400])
def test_a_lost_heartbeat_is_an_error_within_the_time_out(
    before: object, timeout: int
) -> None:
    with before(heartbeat_timeout=timeout) as bench:  # type: ignore[operator]
        if bench.state == "INACTIVE":
            bench.activate()
            bench.system.deactivate("Drive0")
            bench.until("INACTIVE")
        bench.run(0.5)
        bench.node.mute()
        last = bench.recorder.times[-1]
        bench.until("ERROR")
        late = timeout or 300
        assert late * MS <= bench.system.time - last <= (late + 10) * MS
        assert bench.reason == f"node 5 is lost: no heartbeat for {late} ms"
        bench.run(0.1)
        assert bench.node.state is NmtState.STOPPED


@pytest.mark.parametrize("where", ["by its parameter", "by the EDS"])
def test_a_node_that_was_never_activated_is_watched_too(
    where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    objects = [
        replace(o, default=100) if o.index == 0x1017 else o for o in DESCRIPTION.objects
    ]
    described = replace(DESCRIPTION, objects=tuple(objects))
    if where == "by the EDS":
        monkeypatch.setattr(DriveProxy, "description", described)
    with Bench(settings={"heartbeat_timeout": 0 if "EDS" in where else 300}) as bench:
        bench.with_node()
        bench.node.beat(NmtState.PRE_OPERATIONAL)
        bench.run(0.25)
        assert bench.state == "INACTIVE"
        bench.until("ERROR")
        assert bench.reason == "node 5 is lost: no heartbeat for 300 ms"


def test_heartbeats_may_jitter_within_the_time_out() -> None:
    with active(heartbeat_timeout=250) as bench:
        bench.node.mute()
        for wait in (0.01, 0.24, 0.0, 0.2, 0.249, 0.1, 0.24):
            bench.run(wait)
            bench.node.beat(NmtState.OPERATIONAL)
        assert bench.state == "ACTIVE"
        bench.run(0.3)
        assert bench.state == "ERROR"


# Emergencies.


def test_an_emergency_is_an_error_in_words() -> None:
    with active() as bench:
        message = Emergency(0x2310, ErrorRegister.CURRENT | ErrorRegister.GENERIC)
        bench.node.send(message.frame(NODE))
        bench.until("ERROR")
        assert bench.reason == (
            "node 5 reports EMCY 2310h current, output side (generic, current)"
        )
        bench.run(0.01)
        assert bench.commands() == [START, STOP]


def test_an_emergency_while_inactive_is_an_error() -> None:
    with ready() as bench:
        bench.node.send(Emergency(0x3210, ErrorRegister.VOLTAGE).frame(NODE))
        bench.until("ERROR")
        assert bench.reason.startswith(
            "node 5 reports EMCY 3210h voltage inside the device"
        )


def test_errors_that_are_gone_are_no_error() -> None:
    with active() as bench:
        bench.node.send(Emergency(0, ErrorRegister(0)).frame(NODE))
        bench.run(0.1)
        assert bench.state == "ACTIVE"
        assert bench.proxy._connection is not None
        node = bench.proxy._connection.node
        assert (node.emergencies, node.emergency) == (1, None)
        bench.node.send(Emergency(0x4210, ErrorRegister.TEMPERATURE).frame(NODE))
        bench.until("ERROR")
        assert node.emergency is not None
        bench.node.send(Emergency(0, ErrorRegister(0)).frame(NODE))
        bench.run(0.1)
        assert node.emergency is None
        assert bench.state == "ERROR"


def test_a_storm_of_emergencies_is_one_error(caplog: pytest.LogCaptureFixture) -> None:
    with active() as bench:
        for code in range(0x2000, 0x2000 + 5000):
            bench.node.send(Emergency(code, ErrorRegister.CURRENT).frame(NODE))
        bench.run(0.5)
        assert bench.state == "ERROR"
        assert bench.reason.startswith("node 5 reports EMCY 2000h")
        assert len([s for s in bench.states if s.after.name == "ERROR_STATE"]) == 1
        assert len(caplog.records) < 5
        assert bench.proxy._connection is not None
        assert bench.proxy._connection.node.emergencies == 5000
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        bench.activate()


# Failures on the way.


def test_a_node_that_is_missing_at_start() -> None:
    with Bench() as bench:
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == "node 5 is missing: no answer within 2 s"
        assert 2 * SECOND <= bench.system.time < 4 * SECOND
        bench.with_node()
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        bench.activate()


def test_a_node_that_comes_late() -> None:
    with Bench() as bench:
        bench.system.activate("Drive0")
        bench.run(1.5)
        bench.with_node()
        bench.until("ACTIVE")


def test_a_node_that_reboots_while_it_is_activated_is_set_up_again() -> None:
    with ready() as bench:
        bench.node.objects.values[0x1008, 0] = b"x"
        bench.system.activate("Drive0")
        bench.run(0.03)
        assert bench.state == "INACTIVE"
        writes = bench.node.objects.writes
        writes.clear()
        bench.node.beat(NmtState.INITIALISING)
        bench.until("ACTIVE")
        assert (0x6083, 0) in [number for number, _ in writes]


def test_a_node_that_boots_again_and_again() -> None:
    with ready() as bench:
        bench.system.every(15 * MS, lambda: bench.node.beat(NmtState.INITIALISING))
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == "node 5 boots again and again"


def test_a_node_that_does_not_obey() -> None:
    with ready() as bench:
        bench.node.obeys = False
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == (
            "node 5 is not operational within 1 s: its state is pre-operational"
        )
        assert bench.commands() == [START, STOP]


def test_a_node_that_does_not_stop_working_is_an_error() -> None:
    with active() as bench:
        bench.node.obeys = False
        bench.system.deactivate("Drive0")
        bench.run(0.5)
        assert bench.state == "ACTIVE"
        bench.until("ERROR")
        assert bench.reason == (
            "node 5 is not pre-operational within 1 s: its state is operational"
        )


def test_without_a_master_transitions_fail() -> None:
    with Bench(settings={"master": False}) as bench:
        bench.with_node()
        bench.system.activate("Drive0")
        bench.run(0.1)
        assert bench.system.statistics("Drive0").awaited == "an NMT master for node 5"
        bench.until("ERROR")
        assert "this process has no NMT master" in bench.reason
        assert bench.commands() == []


def test_without_a_master_here_another_one_may_start_the_node() -> None:
    with Bench(settings={"master": False}) as bench:
        bench.with_node()
        bench.system.activate("Drive0")
        bench.run(0.5)
        bench.node.go(NmtState.OPERATIONAL)
        bench.until("ACTIVE")


@pytest.mark.parametrize(
    ("way", "code"), [("write", sdo.READ_ONLY), ("read", sdo.NO_OBJECT)]
)
def test_a_node_that_has_no_heartbeat_is_started_all_the_same(
    way: str, code: int
) -> None:
    with Bench() as bench:
        objects = Objects()
        objects.aborts[way, (0x1017, 0)] = code
        bench.with_node(objects=objects)
        bench.run(0.05)
        bench.activate()
        bench.run(1.0)
        assert bench.state == "ACTIVE"
        assert bench.commands() == [START]
        bench.system.deactivate("Drive0")
        bench.until("INACTIVE")
        assert bench.commands() == [START, PREOP]


def test_the_bus_goes_and_comes_back() -> None:
    with active() as bench:
        bench.bus.cut()
        bench.until("ERROR")
        assert bench.reason == "node 5 cannot be reached: the bus is gone"
        bench.system.reset("Drive0")
        bench.run(0.1)
        assert bench.state == "ERROR"
        assert bench.reason == "the bus is gone"
        bench.bus.mend()
        bench.run(0.2)
        assert bench.state == "ERROR"
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        bench.activate()
        bench.node.send_position(7)
        bench.run(0.02)
        assert bench.values() == [7]


def test_a_second_node_of_the_same_id_that_boots() -> None:
    with active() as bench:
        bench.with_node()
        bench.until("ERROR")
        assert bench.reason == "node 5 booted while it was operational"


def test_two_nodes_of_the_same_id_that_beat() -> None:
    with active() as bench:
        for _ in range(4):
            bench.node.beat(NmtState.PRE_OPERATIONAL)
            bench.node.beat(NmtState.OPERATIONAL)
        bench.until("ERROR")
        assert bench.reason == (
            "node 5 reports states that contradict each other: are there two of them?"
        )


def test_states_that_another_master_commands_are_no_contradiction() -> None:
    commands = (
        (NmtCommand.ENTER_PRE_OPERATIONAL, NmtState.PRE_OPERATIONAL),
        (NmtCommand.START, NmtState.OPERATIONAL),
    )
    with active() as bench:
        for command, state in commands * 4:
            bench.link.send([command_frame(command, NODE)])
            bench.run(0.001)
            bench.node.beat(state)
        bench.run(0.1)
        assert (bench.state, bench.reason) == ("INACTIVE", "")


def test_two_nodes_of_the_same_id_that_answer() -> None:
    with Bench() as bench:
        bench.with_node()
        bench.with_node()
        bench.run(0.05)
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == (
            "node 5 answers twice: there are two of them, or another SDO client"
        )


def test_a_bus_that_cannot_be_opened() -> None:
    from rtgen.runtime.canopen.bus.links import open_link

    clock = SimulatedClock()
    bench = Bench(clock, settings={"bitrate": 500_000, "channel": "can1"})
    with bench:
        assert bench.state == "INACTIVE"
        open_link(clock, channel="can2", bitrate=125_000)
        bench.system.configure("Drive0", "channel", "can2")
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == (
            "the simulated bus can2 runs at 125000 bit/s, and not at 500000 bit/s"
        )


@pytest.mark.parametrize("lost", range(8))
def test_one_lost_sdo_frame_does_not_fail_an_activation(lost: int) -> None:
    """Requests and answers: 1000h, 1017h read and written, 6083h written."""
    with Bench() as bench:
        bench.with_node()
        bench.run(0.05)
        seen = 0

        def lose(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
            nonlocal seen
            if frame.can_id in (0x580 + NODE, 0x600 + NODE):
                seen += 1
                if seen == lost + 1:
                    return ()
            return ((0, frame),)

        bench.bus.disturbance = lose
        bench.activate()
        assert seen > lost
        assert bench.node.objects.writes[-1] == ((0x6083, 0), b"\xe8\3\0\0")
        assert bench.reason == ""


def test_an_answer_that_is_missing_with_two_nodes_names_them() -> None:
    with Bench() as bench:
        bench.with_node()
        bench.with_node()
        bench.run(0.05)
        bench.bus.disturbance = lambda frame, now: (
            () if frame.data[:1] == b"\x2b" else ((0, frame),)
        )
        bench.system.activate("Drive0")
        bench.until("ERROR", 30)
        assert bench.reason == (
            "node 5: 1017h:0 cannot be written: node 5 answers twice: there are two of them, "
            "or another SDO client: 05040000h protocol timed out"
        )
