"""Transmission types, inhibit time, event timer; lengths and deadlines of received PDOs."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.pdo_transmission import (
    PdoParameters,
    Received,
    RpdoReceiver,
    TpdoTransmitter,
)

MS = 1_000_000


def tpdo(
    kind: int,
    *,
    inhibit: int = 0,
    timer: int = 0,
    start: int = 0,
    cob_id: int = 0x185,
) -> TpdoTransmitter:
    transmitter = TpdoTransmitter(
        PdoParameters(
            cob_id=cob_id,
            transmission_type=kind,
            inhibit_time=inhibit,
            event_timer=timer,
            sync_start=start,
        )
    )
    transmitter.start(0)
    return transmitter


def rpdo(kind: int, size: int = 2, timer: int = 0) -> RpdoReceiver:
    parameters = PdoParameters(cob_id=0x205, transmission_type=kind, event_timer=timer)
    receiver = RpdoReceiver(parameters, size)
    receiver.start()
    return receiver


def sent(data: bytes) -> Frame:
    return Frame(0x185, data)


@pytest.mark.parametrize("kind", [254, 255])
def test_events(kind: int) -> None:
    transmitter = tpdo(kind)
    assert transmitter.update(b"a", 0) == sent(b"a")
    assert transmitter.update(b"b", 0, event=False) is None
    assert transmitter.sync(0, 1) is None
    assert transmitter.update(b"c", 1) == sent(b"c")
    assert transmitter.deadline is None
    assert transmitter.overwritten == 0


def test_in_the_inhibit_time_the_newest_value_wins() -> None:
    transmitter = tpdo(255, inhibit=100)
    assert transmitter.update(b"a", 0) == sent(b"a")
    assert transmitter.deadline is None
    for data in (b"b", b"c", b"d"):
        assert transmitter.update(data, MS) is None
    assert transmitter.deadline == 10 * MS
    assert transmitter.poll(10 * MS - 1) is None
    assert transmitter.poll(10 * MS) == sent(b"d")
    assert transmitter.overwritten == 2
    assert transmitter.poll(30 * MS) is None
    assert transmitter.update(b"e", 30 * MS) == sent(b"e")


def test_event_timer_counts_from_the_last_transmission() -> None:
    transmitter = tpdo(254, timer=10)
    assert transmitter.deadline is None
    transmitter.update(b"a", 0, event=False)
    assert transmitter.deadline == 10 * MS
    assert transmitter.poll(10 * MS) == sent(b"a")
    assert transmitter.update(b"b", 14 * MS) == sent(b"b")
    assert transmitter.poll(20 * MS) is None
    assert transmitter.poll(24 * MS) == sent(b"b")


def test_event_timer_waits_for_the_inhibit_time() -> None:
    transmitter = tpdo(254, timer=10, inhibit=150)
    assert transmitter.update(b"a", 0) == sent(b"a")
    assert transmitter.deadline == 15 * MS
    assert transmitter.poll(10 * MS) is None
    assert transmitter.poll(15 * MS) == sent(b"a")


def test_synchronous_acyclic() -> None:
    transmitter = tpdo(0, timer=1)
    assert transmitter.update(b"a", 0, event=False) is None
    assert transmitter.sync(0, 1) is None
    assert transmitter.update(b"b", 2) is None
    assert transmitter.update(b"c", 3) is None
    assert transmitter.poll(100 * MS) is None
    assert transmitter.sync(0, 4) == sent(b"c")
    assert transmitter.sync(0, 5) is None
    assert transmitter.overwritten == 1


@pytest.mark.parametrize("kind", [1, 2, 3, 240])
def test_synchronous_cyclic(kind: int) -> None:
    """On every n-th SYNC, with an event or without."""
    transmitter = tpdo(kind)
    assert transmitter.update(b"a", 0) is None
    due = [n for n in range(1, 3 * kind + 1) if transmitter.sync(0, n)]
    assert due == [kind, 2 * kind, 3 * kind]


def test_sync_start() -> None:
    transmitter = tpdo(2, start=3)
    transmitter.update(b"a", 0)
    counters = [*range(2, 9), 1, 2]
    assert [c for c in counters if transmitter.sync(c, 0)] == [3, 5, 7, 1]
    uncounted = tpdo(2, start=3)
    uncounted.update(b"a", 0)
    assert [n for n in range(1, 7) if uncounted.sync(0, 0)] == [2, 4, 6]


def test_cycle_begins_anew_with_operational() -> None:
    transmitter = tpdo(2)
    transmitter.update(b"a", 0)
    transmitter.sync(0, 0)
    transmitter.stop()
    assert transmitter.sync(0, 1) is None
    transmitter.start(2)
    assert [bool(transmitter.sync(0, 3)) for _ in range(4)] == [False, True] * 2


def test_remote_frames() -> None:
    transmitter = tpdo(253)
    assert transmitter.remote(0) is None
    assert transmitter.update(b"a", 0) is None
    assert transmitter.remote(1) == sent(b"a")
    sampled = tpdo(252)
    sampled.update(b"a", 0)
    assert sampled.remote(0) is None
    assert sampled.sync(0, 0) is None
    sampled.update(b"b", 0)
    assert sampled.remote(0) == sent(b"a")
    refusing = tpdo(253, cob_id=0x40000185)
    refusing.update(b"a", 0)
    assert refusing.remote(0) is None
    inhibited = tpdo(255, inhibit=10)
    inhibited.update(b"a", 0)
    assert inhibited.remote(0) is None
    assert inhibited.poll(MS) == sent(b"a")


@pytest.mark.parametrize("kind", [0, 1, 252, 253, 254, 255])
def test_only_while_operational(kind: int) -> None:
    transmitter = tpdo(kind, timer=1, inhibit=1)
    transmitter.update(b"a", 0)
    transmitter.update(b"b", 0)
    transmitter.stop()
    assert transmitter.deadline is None
    assert transmitter.update(b"c", 9 * MS) is None
    assert transmitter.sync(0, 9 * MS) is None
    assert transmitter.remote(9 * MS) is None
    assert transmitter.poll(9 * MS) is None
    absent = tpdo(kind, cob_id=0x80000185)
    assert absent.update(b"a", 0) is None
    assert absent.sync(0, 0) is None


@pytest.mark.parametrize("kind", [-1, 241, 251, 256])
def test_reserved_types(kind: int) -> None:
    with pytest.raises(ValueError, match="reserved"):
        PdoParameters(cob_id=0x185, transmission_type=kind)


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.integers(0, 30 * MS), min_size=1, max_size=40),
    st.integers(0, 100),
    st.sampled_from([0, 0, 5, 20]),
)
def test_nothing_is_lost_uncounted(pauses: list[int], inhibit: int, timer: int) -> None:
    """Frames keep their distance and order; each event is sent or counted; the last is sent."""
    transmitter = tpdo(255, inhibit=inhibit, timer=timer)
    frames: list[tuple[int, int]] = []

    def note(frame: Frame | None, at: int) -> None:
        if frame is not None:
            frames.append((at, frame.data[0]))

    now = 0
    for number, pause in enumerate([*pauses, 100 * MS]):
        arrives = now + pause
        while (due := transmitter.deadline) is not None and due < arrives:
            now = max(now, due)
            note(transmitter.poll(now), now)
        now = arrives
        if number < len(pauses):
            note(transmitter.update(bytes((number,)), now), now)
    values = [value for _, value in frames]
    assert values == sorted(values)
    assert len(set(values)) + transmitter.overwritten == len(pauses)
    assert values[-1] == len(pauses) - 1
    gaps = [b[0] - a[0] for a, b in pairwise(frames)]
    assert all(gap >= inhibit * 100_000 for gap in gaps)
    assert not timer or all(gap <= max(timer * MS, inhibit * 100_000) for gap in gaps)


def test_received_at_once() -> None:
    receiver = rpdo(255)
    assert receiver.receive(Frame(0x205, b"ab"), 0) == Received(b"ab")
    assert receiver.receive(Frame(0x206, b"ab"), 0) == Received()
    assert receiver.receive(Frame(0x205, remote=True), 0) == Received()
    assert receiver.receive(Frame(0x205, b"ab", extended=True), 0) == Received()
    receiver.stop()
    assert receiver.receive(Frame(0x205, b"ab"), 0) == Received()


def test_lengths() -> None:
    receiver = rpdo(255)
    assert receiver.receive(Frame(0x205, b"a"), 0) == Received(None, 0x8210)
    assert receiver.receive(Frame(0x205, b"abc"), 0) == Received(b"ab", 0x8220)
    assert (receiver.too_short, receiver.too_long) == (1, 1)


@pytest.mark.parametrize("kind", [0, 1, 240])
def test_received_at_sync(kind: int) -> None:
    receiver = rpdo(kind)
    assert receiver.sync() is None
    assert receiver.receive(Frame(0x205, b"ab"), 0) == Received()
    assert receiver.receive(Frame(0x205, b"c"), 0) == Received(None, 0x8210)
    assert receiver.receive(Frame(0x205, b"de"), 0) == Received()
    assert receiver.overwritten == 1
    assert receiver.sync() == b"de"
    assert receiver.sync() is None
    receiver.receive(Frame(0x205, b"fg"), 0)
    receiver.stop()
    receiver.start()
    assert receiver.sync() is None


def test_deadline() -> None:
    receiver = rpdo(255, timer=10)
    assert receiver.poll(100 * MS) == 0
    receiver.receive(Frame(0x205, b"ab"), 100 * MS)
    receiver.receive(Frame(0x205, b"a"), 105 * MS)
    assert receiver.poll(110 * MS - 1) == 0
    assert receiver.poll(110 * MS) == 0x8250
    assert receiver.poll(200 * MS) == 0
    receiver.receive(Frame(0x205, b"ab"), 200 * MS)
    assert receiver.deadline == 210 * MS


def test_lengths_that_cannot_be() -> None:
    with pytest.raises(ValueError, match="9 octets"):
        tpdo(255).update(bytes(9), 0)
    with pytest.raises(ValueError, match="9 octets"):
        rpdo(255, size=9)
