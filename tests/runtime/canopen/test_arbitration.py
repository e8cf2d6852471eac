"""Arbitration on a CAN bus, and the length of frames."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.compiler.layouts.can_timing import Message
from rtgen.compiler.layouts.can_timing import frame_bits as worst_case
from rtgen.runtime.canopen.bus.arbitration import (
    Arbiter,
    frame_bits,
    priority,
    transmission_time,
)
from rtgen.runtime.canopen.wire.frames import Frame

FRAMES = st.builds(
    lambda extended, id_, data, remote: Frame(
        id_ % (1 << (29 if extended else 11)), data, remote, extended
    ),
    st.booleans(),
    st.integers(0, (1 << 29) - 1),
    st.binary(max_size=8),
    st.booleans(),
)


def bits_one_by_one(frame: Frame) -> int:
    """Compute the length literally: a list of bits, the CRC shifted, stuffing counted."""

    def of(value: int, width: int) -> list[int]:
        return [value >> place & 1 for place in reversed(range(width))]

    data = b"" if frame.remote else frame.data
    if frame.extended:
        field = [*of(frame.can_id >> 18, 11), 1, 1, *of(frame.can_id & 0x3FFFF, 18)]
        field += [int(frame.remote), 0, 0]
    else:
        field = [*of(frame.can_id, 11), int(frame.remote), 0, 0]
    stream = [0, *field, *of(len(data), 4)]
    for octet in data:
        stream += of(octet, 8)
    register = 0
    for bit in stream:
        flip = bit ^ register >> 14 & 1
        register = register << 1 & 0x7FFF
        if flip:
            register ^= 0x4599
    stream += of(register, 15)
    sent: list[int] = []
    run = 0
    for bit in stream:
        run = run + 1 if sent and sent[-1] == bit else 1
        sent.append(bit)
        if run == 5:
            sent.append(1 - bit)
            run = 1
    return len(sent) + 13


@given(FRAMES)
def test_the_length_of_a_frame_is_exact(frame: Frame) -> None:
    assert frame_bits(frame) == bits_one_by_one(frame)
    data = b"" if frame.remote else frame.data
    least = (54 if frame.extended else 34) + 8 * len(data) + 13
    assert least <= frame_bits(frame) <= worst_case(len(data), frame.extended)


def test_a_frame_of_zeros_has_a_stuff_bit_after_every_fifth_bit() -> None:
    # Its CRC is zero, too. A stuff bit is a 1, so that five more zeros follow.
    assert frame_bits(Frame(0)) == 34 + 34 // 5 + 13


def test_time_by_bit_rate() -> None:
    frame = Frame(0x701, b"\5")
    assert transmission_time(frame, 1_000_000) == frame_bits(frame) * 1000
    assert transmission_time(frame, 10_000) == frame_bits(frame) * 100_000


def test_data_before_remote_and_11_bits_before_29() -> None:
    frames = [
        Frame(0x122),
        Frame(0x123),
        Frame(0x123, remote=True),
        Frame(0x123 << 18, extended=True),
        Frame(0x123 << 18, extended=True, remote=True),
        Frame(0x123 << 18 | 1, extended=True),
        Frame(0x124),
    ]
    assert sorted(frames, key=priority) == frames


@given(FRAMES, FRAMES)
def test_priorities_as_those_of_the_analysis(one: Frame, other: Frame) -> None:
    def of(frame: Frame) -> Message:
        return Message("", frame.can_id, 0, 1, extended=frame.extended)

    if not one.remote and not other.remote:
        assert (priority(one) < priority(other)) == (
            of(one).priority < of(other).priority
        )


def test_each_sender_keeps_its_order() -> None:
    arbiter: Arbiter[str] = Arbiter()
    for sender, can_id in (("a", 5), ("a", 1), ("b", 3), ("b", 9), ("c", 3)):
        arbiter.put(sender, Frame(can_id))
    assert len(arbiter) == 5
    assert arbiter.waiting("a") == 2
    order = [arbiter.take() for _ in range(len(arbiter))]
    assert [(sender, frame.can_id) for sender, frame in order] == [
        ("b", 3),
        ("c", 3),
        ("a", 5),
        ("a", 1),
        ("b", 9),
    ]
    with pytest.raises(IndexError):
        arbiter.take()


def test_what_waits_is_dropped() -> None:
    arbiter: Arbiter[str] = Arbiter()
    for sender, can_id in (("a", 5), ("a", 1), ("b", 3)):
        arbiter.put(sender, Frame(can_id))
    assert arbiter.drop("a") == 2
    assert arbiter.drop("a") == 0
    assert arbiter.take() == ("b", Frame(3))
    arbiter.put("b", Frame(1))
    assert arbiter.clear() == 1
    assert not len(arbiter)
