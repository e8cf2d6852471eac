"""The slave's state machine, plain and merged, and the heartbeat."""

from __future__ import annotations

import pytest

from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.heartbeat import (
    HeartbeatConsumer,
    HeartbeatEvent,
    HeartbeatNews,
    HeartbeatProducer,
)
from rtgen.runtime.canopen.wire.nmt import (
    NmtCommand,
    NmtSlave,
    NmtState,
    Service,
    Transition,
    command_frame,
    heartbeat_frame,
)

INITIALISING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = NmtState
START, STOP, PRE, RESET_NODE, RESET_COMMUNICATION = NmtCommand


def slave_in(
    state: NmtState, *, merged_stop: bool = False, ok: bool = True
) -> NmtSlave:
    slave = NmtSlave(5, merged_stop=merged_stop, stopping=lambda: ok)
    slave.boot()
    if state is OPERATIONAL:
        slave.receive(command_frame(START, 5))
    elif state is STOPPED:
        slave.fail()
    assert slave.state is state
    return slave


PLAIN = {START: OPERATIONAL, STOP: STOPPED, PRE: PRE_OPERATIONAL}


@pytest.mark.parametrize("before", [PRE_OPERATIONAL, OPERATIONAL, STOPPED])
@pytest.mark.parametrize("command", list(NmtCommand))
@pytest.mark.parametrize("node_id", [0, 5])
def test_commands(before: NmtState, command: NmtCommand, node_id: int) -> None:
    slave = slave_in(before)
    after = PLAIN.get(command, INITIALISING)
    change = slave.receive(command_frame(command, node_id))
    assert slave.state is after
    assert change == (None if before is after else Transition(before, after, command))
    if after is INITIALISING:
        assert slave.reset is command


@pytest.mark.parametrize(
    ("before", "command", "ok", "after"),
    [
        (OPERATIONAL, STOP, True, PRE_OPERATIONAL),
        (OPERATIONAL, STOP, False, STOPPED),
        (PRE_OPERATIONAL, STOP, True, PRE_OPERATIONAL),
        (PRE_OPERATIONAL, STOP, False, STOPPED),
        (STOPPED, START, True, STOPPED),
        (STOPPED, PRE, True, STOPPED),
        (STOPPED, STOP, True, STOPPED),
        (STOPPED, RESET_NODE, True, INITIALISING),
        (STOPPED, RESET_COMMUNICATION, True, INITIALISING),
        (PRE_OPERATIONAL, START, True, OPERATIONAL),
        (OPERATIONAL, PRE, True, PRE_OPERATIONAL),
    ],
)
def test_merged_stop(
    before: NmtState, command: NmtCommand, ok: bool, after: NmtState
) -> None:
    """Figure 111: the return code decides the effect of a stop; Error is left by a reset only."""
    slave = slave_in(before, merged_stop=True, ok=ok)
    slave.receive(command_frame(command, 5))
    assert slave.state is after


def test_boot_up() -> None:
    slave = NmtSlave(5)
    assert slave.receive(command_frame(START)) is None
    assert slave.boot() == Frame(0x705, b"\0")
    assert slave.state is PRE_OPERATIONAL
    with pytest.raises(RuntimeError, match="PRE_OPERATIONAL"):
        slave.boot()
    slave = NmtSlave(5, self_start=True)
    slave.boot()
    assert slave.state is OPERATIONAL


def test_a_failed_reset_is_an_error() -> None:
    slave = slave_in(OPERATIONAL)
    slave.receive(command_frame(RESET_NODE, 5))
    assert slave.fail() == Transition(INITIALISING, STOPPED, None)
    assert slave.fail() is None


@pytest.mark.parametrize(
    "frame",
    [
        command_frame(START, 6),
        Frame(0, b"\x01"),
        Frame(0, b"\x01\x05\x00"),
        Frame(0, b"\x03\x05"),
        Frame(0, b"\x01\x05", extended=True),
        Frame(1, b"\x01\x05"),
        Frame(0, remote=True),
    ],
)
def test_not_for_this_node(frame: Frame) -> None:
    slave = slave_in(PRE_OPERATIONAL)
    assert slave.receive(frame) is None
    assert slave.state is PRE_OPERATIONAL


def test_services() -> None:
    assert slave_in(OPERATIONAL).allows(Service.PDO)
    prepared = slave_in(PRE_OPERATIONAL)
    assert prepared.allows(Service.SDO)
    assert prepared.allows(Service.EMERGENCY)
    assert not prepared.allows(Service.PDO)
    stopped = slave_in(STOPPED)
    assert [s for s in Service if stopped.allows(s)] == [Service.NMT]
    assert not any(NmtSlave(1).allows(s) for s in Service)


def test_producer() -> None:
    producer = HeartbeatProducer(5, period=100)
    assert producer.poll(1000, PRE_OPERATIONAL) is None
    producer.booted(1000)
    assert producer.poll(1099, PRE_OPERATIONAL) is None
    assert producer.poll(1105, PRE_OPERATIONAL) == Frame(0x705, b"\x7f")
    assert producer.deadline == 1200
    assert producer.poll(1450, OPERATIONAL) == Frame(0x705, b"\x05")
    assert producer.deadline == 1500
    producer.configure(50, 1460)
    assert producer.poll(1460, STOPPED) == Frame(0x705, b"\x04")
    producer.configure(0, 1461)
    assert producer.deadline is None
    producer.booted(1500)
    assert producer.deadline is None


def beat(
    consumer: HeartbeatConsumer, state: NmtState, now: int
) -> HeartbeatEvent | None:
    return consumer.receive(heartbeat_frame(5, state), now)


def test_supervision_starts_with_the_first_heartbeat() -> None:
    consumer = HeartbeatConsumer(5, timeout=100)
    assert consumer.poll(10_000) is None
    consumer.ask(OPERATIONAL)
    found = beat(consumer, OPERATIONAL, 10_000)
    assert found == HeartbeatEvent(HeartbeatNews.FOUND, OPERATIONAL, asked=True)
    assert beat(consumer, OPERATIONAL, 10_099) is None
    assert consumer.poll(10_198) is None
    lost = HeartbeatEvent(HeartbeatNews.LOST, OPERATIONAL, asked=False)
    assert consumer.poll(10_199) == lost
    assert consumer.poll(20_000) is None
    back = beat(consumer, OPERATIONAL, 20_000)
    assert back == HeartbeatEvent(HeartbeatNews.FOUND, OPERATIONAL, asked=False)


def test_boot_up_suspends_supervision() -> None:
    consumer = HeartbeatConsumer(5, timeout=100)
    beat(consumer, OPERATIONAL, 0)
    boot = beat(consumer, INITIALISING, 50)
    assert boot == HeartbeatEvent(HeartbeatNews.BOOT_UP, INITIALISING, asked=False)
    assert consumer.poll(10_000) is None
    consumer.ask(INITIALISING)
    asked = beat(consumer, INITIALISING, 10_000)
    assert asked == HeartbeatEvent(HeartbeatNews.BOOT_UP, INITIALISING, asked=True)


def test_states_nobody_asked_for() -> None:
    consumer = HeartbeatConsumer(5, timeout=100)
    beat(consumer, PRE_OPERATIONAL, 0)
    consumer.ask(OPERATIONAL)
    assert beat(consumer, PRE_OPERATIONAL, 10) is None
    changed = HeartbeatNews.CHANGED
    assert beat(consumer, STOPPED, 20) == HeartbeatEvent(changed, STOPPED, asked=False)
    assert beat(consumer, OPERATIONAL, 30) == HeartbeatEvent(
        changed, OPERATIONAL, asked=True
    )
    beat(consumer, PRE_OPERATIONAL, 40)
    again = beat(consumer, OPERATIONAL, 50)
    assert again == HeartbeatEvent(changed, OPERATIONAL, asked=False)


@pytest.mark.parametrize(
    "frame",
    [
        heartbeat_frame(6, OPERATIONAL),
        Frame(0x705, b""),
        Frame(0x705, b"\x05\x00"),
        Frame(0x705, b"\x86"),
        Frame(0x705, b"\x80"),
        Frame(0x705, remote=True),
        Frame(0x705, b"\x05", extended=True),
    ],
)
def test_no_heartbeats(frame: Frame) -> None:
    consumer = HeartbeatConsumer(5, timeout=100)
    assert consumer.receive(frame, 0) is None
    assert consumer.deadline is None


def test_an_answer_to_node_guarding_tells_the_state_too() -> None:
    consumer = HeartbeatConsumer(5, timeout=100)
    found = consumer.receive(Frame(0x705, b"\x85"), 0)
    assert found == HeartbeatEvent(HeartbeatNews.FOUND, OPERATIONAL, asked=False)


def test_without_supervision() -> None:
    consumer = HeartbeatConsumer(5, timeout=0)
    assert beat(consumer, OPERATIONAL, 0) is not None
    assert consumer.poll(1 << 60) is None


def test_a_command_to_where_the_node_is() -> None:
    """It is answered by the next heartbeat; a later state of that kind is not an answer."""
    consumer = HeartbeatConsumer(5, timeout=100)
    beat(consumer, OPERATIONAL, 0)
    consumer.ask(OPERATIONAL)
    assert beat(consumer, OPERATIONAL, 10) is None
    beat(consumer, PRE_OPERATIONAL, 20)
    back = beat(consumer, OPERATIONAL, 30)
    assert back == HeartbeatEvent(HeartbeatNews.CHANGED, OPERATIONAL, asked=False)
