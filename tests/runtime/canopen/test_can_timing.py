"""Response times on a CAN bus: the paper's example, and a simulated bus."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtgen.compiler.layouts.can_timing import (
    Message,
    bit_time,
    frame_bits,
    load,
    response_times,
)

BIT_RATE = 125
BIT = bit_time(BIT_RATE)
MS = 1_000_000


@pytest.mark.parametrize(
    ("octets", "standard", "extended"),
    [(0, 55, 80), (1, 65, 90), (7, 125, 150), (8, 135, 160)],
)
def test_frames(octets: int, standard: int, extended: int) -> None:
    """s octets have 55 + 10 s and 80 + 10 s bits."""
    assert frame_bits(octets) == standard
    assert frame_bits(octets, extended=True) == extended


def test_bit_times() -> None:
    assert [bit_time(r) for r in (1000, 800, 500, 125, 10)] == [
        1000,
        1250,
        2000,
        8000,
        100_000,
    ]


def test_the_example_of_the_paper() -> None:
    """Three messages of 1 ms: the third one's second instance is the late one."""
    messages = [
        Message("A", 1, 7, 2_500_000),
        Message("B", 2, 7, 3_500_000),
        Message("C", 3, 7, 3_500_000),
    ]
    found = {t.message.name: t.response for t in response_times(messages, BIT_RATE)}
    assert found == {"A": 2 * MS, "B": 3 * MS, "C": 3_500_000}
    assert load(messages, BIT_RATE) == pytest.approx(1 / 2.5 + 2 / 3.5)


def test_no_bound() -> None:
    messages = [
        Message("A", 1, 8, 1_200_000),
        Message("B", 2, 8, 5 * MS),
        Message("C", 3, 0, MS),
    ]
    found = [t.response for t in response_times(messages, BIT_RATE)]
    assert found[0] is not None
    assert found[1:] == [None, None]


def test_arbitration() -> None:
    messages = [
        Message("extended", 0x100 << 18 | 5, 8, MS, extended=True),
        Message("later", 0x101, 8, MS),
        Message("standard", 0x100, 8, MS),
        Message("urgent", 0x0FF << 18, 8, MS, extended=True),
    ]
    found = [t.message.name for t in response_times(messages, 1000)]
    assert found == ["urgent", "standard", "extended", "later"]


def simulated(messages: list[Message], which: int) -> int:
    """Return the longest response of a message if all are queued as a longer frame begins."""
    costs = [frame_bits(m.octets) * BIT for m in messages]
    now = max(costs[which + 1 :], default=0)
    sent = [0] * (which + 1)
    worst = 0
    while True:
        waiting = [k for k in range(which + 1) if sent[k] * messages[k].period <= now]
        if not any(sent[k] * messages[k].period < now or now == 0 for k in waiting):
            return worst
        chosen = min(waiting)
        queued = sent[chosen] * messages[chosen].period
        now += costs[chosen]
        sent[chosen] += 1
        if chosen == which:
            worst = max(worst, now - queued)


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 8), st.integers(60, 900)), min_size=1, max_size=6)
)
def test_against_a_simulated_bus(drawn: list[tuple[int, int]]) -> None:
    """The critical instant of the analysis, simulated frame by frame."""
    messages = [
        Message(f"m{n}", n, octets, 4 * period * BIT)
        for n, (octets, period) in enumerate(drawn)
    ]
    for n, timing in enumerate(response_times(messages, BIT_RATE)):
        if timing.response is not None:
            assert simulated(messages, n) == timing.response


def test_a_bus_that_is_full_to_the_last_bit_has_no_bound() -> None:
    octets = frame_bits(8) * BIT
    messages = [
        Message("half", 1, 8, 2 * octets),
        Message("nearly half", 2, 8, 2 * octets + 1),
        Message("lower", 3, 8, 10**12),
    ]
    last = list(response_times(messages[:2], BIT_RATE))[1]
    assert last.response is not None
    blocked = list(response_times(messages, BIT_RATE))
    assert blocked[1].response is None


def test_jitter_comes_on_top() -> None:
    def third(jitter: int) -> int:
        messages = [
            Message("A", 1, 8, 10 * MS, jitter=jitter),
            Message("B", 2, 8, 10 * MS),
        ]
        response = [t.response for t in response_times(messages, 1000)]
        assert response[0] is not None
        assert response[1] is not None
        return response[0] - jitter

    assert third(0) == third(MS)


def test_an_sdo_frame_blocks_what_is_more_urgent() -> None:
    """Two small PDOs take 260 us at 500 kbit/s; after an SDO frame it is 530."""
    pdos = [Message("one", 0x181, 1, 10 * MS), Message("two", 0x182, 1, 10 * MS)]
    sdo = Message("SDO", 0x581, 8, 1000 * MS)

    def worst(*messages: Message) -> list[int | None]:
        return [t.response for t in response_times(messages, 500)][:2]

    assert worst(*pdos) == [260_000, 260_000]
    assert worst(*pdos, sdo) == [400_000, 530_000]


def test_a_queue_lets_an_urgent_message_wait_for_its_last_one() -> None:
    sync = Message("SYNC", 0x80, 0, 10 * MS, queue="host")
    beat = Message("beat", 0x77F, 1, 100 * MS, queue="host")
    pdo = Message("pdo", 0x181, 8, 10 * MS)
    alone = {t.message.name: t.response for t in response_times([sync, pdo], 1000)}
    assert alone == {"SYNC": 190_000, "pdo": 190_000}
    both = [sync, beat, pdo]
    queued = {t.message.name: t.response for t in response_times(both, 1000)}
    # A heartbeat that has just begun, then SYNC, and the previous PDO.
    assert queued["SYNC"] == queued["beat"] == 65_000 + 135_000 + 65_000 + 55_000


def test_what_comes_with_sync_is_as_late_as_sync() -> None:
    sync = Message("SYNC", 0x80, 0, 10 * MS)
    pdo = Message("pdo", 0x181, 8, 10 * MS, trigger="SYNC")
    other = Message("other", 0x281, 8, 10 * MS)
    found = {
        t.message.name: t.response for t in response_times([sync, pdo, other], 1000)
    }
    assert found["SYNC"] == 55_000 + 135_000
    assert found["pdo"] == found["SYNC"] + 135_000 + 55_000 + 135_000


def test_a_queue_that_is_longer_than_a_period_has_no_bound() -> None:
    messages = [
        Message("short", 1, 0, 200_000, queue="host"),
        *(Message(f"m{n}", n, 8, 100 * MS, queue="host") for n in range(2, 5)),
    ]
    assert [t.response for t in response_times(messages, 1000)] == [None] * 4
