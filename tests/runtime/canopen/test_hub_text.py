"""The texts of a hub: socketcand and slcan, well-formed, sloppy and hostile."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from random import Random

import can
import pytest
from can.interfaces.socketcand.socketcand import (
    convert_ascii_message_to_can_message,
    convert_can_message_to_ascii_message,
)
from hypothesis import given
from hypothesis import strategies as st

from rtgen.runtime.canopen.bus.hub_faults import Fault, Faults, fault_of, times_off
from rtgen.runtime.canopen.bus.hub_text import (
    Elements,
    Lines,
    Malformed,
    error_text,
    frame_text,
    received_error,
    received_frame,
    send_text,
    sent_frame,
    slcan_frame,
    slcan_text,
)
from rtgen.runtime.canopen.wire.frames import Frame

FRAMES = st.builds(
    lambda extended, id_, data: Frame(
        id_ % (1 << (29 if extended else 11)), data, extended=extended
    ),
    st.booleans(),
    st.integers(0, (1 << 29) - 1),
    st.binary(max_size=8),
)
# Octets that resemble those of the protocols.
NEARLY = st.lists(
    st.one_of(
        st.sampled_from(
            [b"<", b">", b" ", b"send", b"open", b"123", b"8", b"ff", b"\r", b"t1232"]
        ),
        st.binary(max_size=9),
    ),
    max_size=60,
).map(b"".join)


def taken(stream: Elements | Lines) -> Iterable[str | None]:
    """Yield all complete texts; None for a refused one."""
    while True:
        before = stream.waiting
        try:
            text = stream.take()
        except Malformed:
            assert stream.waiting < before
            yield None
            continue
        if text is None:
            return
        yield text


@given(FRAMES)
def test_what_python_can_sends_is_read_and_what_it_reads_is_written(
    frame: Frame,
) -> None:
    message = can.Message(
        arbitration_id=frame.can_id, data=frame.data, is_extended_id=frame.extended
    )
    elements = Elements()
    elements.feed(convert_can_message_to_ascii_message(message).encode())
    words = elements.take()
    assert words is not None
    assert sent_frame(words) == frame
    back = convert_ascii_message_to_can_message(
        frame_text(frame, 1_234_567_890_123_456_789).decode()
    )
    assert (back.arbitration_id, bytes(back.data)) == (frame.can_id, frame.data)
    assert back.is_extended_id == frame.extended
    assert back.timestamp == 1234567890.123456


@given(FRAMES, st.integers(0, 10**11))
def test_a_client_reads_what_the_hub_writes_and_the_hub_what_it_sends(
    frame: Frame, micros: int
) -> None:
    elements = Elements()
    elements.feed(send_text(frame) + frame_text(frame, 1000 * micros))
    sent, received = elements.take(), elements.take()
    assert sent is not None
    assert received is not None
    assert sent_frame(sent) == frame
    assert received_frame(received) == (frame, micros / 1e6)


def test_error_frames() -> None:
    assert received_error("error 00000040 2.000000") == (0x40, 2.0)


@pytest.mark.parametrize(
    "words",
    [
        "",
        "frame",
        "frame 123",
        "frame 123 x 01",
        "frame 123 nan 01",
        "frame 123 -1.0 01",
        "frame 123 1e300 01",
        "frame 123 1.0 0",
        "frame 123 1.0 xx",
        "frame 123 1.0 010203040506070809",
        "frame 800 1.0 01",
        "frame 1234 1.0 01",
        "fame 123 1.0 01",
        "error 40",
        "error 40 x",
        "error x 1.0",
        "eror 40 1.0",
    ],
)
def test_what_a_client_refuses(words: str) -> None:
    for parse in (received_frame, received_error):
        with pytest.raises(Malformed):
            parse(words)


def test_texts_of_frames() -> None:
    assert frame_text(Frame(0x80), 5_000_001_999) == b"< frame 080 5.000001  >"
    assert frame_text(Frame(0x181, b"\1\xfa"), 0) == b"< frame 181 0.000000 01FA >"
    long = Frame(0x123, b"\0", extended=True)
    assert frame_text(long, 0) == b"< frame 00000123 0.000000 00 >"
    assert error_text(0x40, 2_000_000_000) == b"< error 00000040 2.000000 >"


@pytest.mark.parametrize(
    "words",
    [
        "send",
        "send 123",
        "send 123 2 01",
        "send 123 1 01 02",
        "send 123 4",
        "send 123 9 1 2 3 4 5 6 7 8 9",
        "send 123 1 100",
        "send 123 1 xy",
        "send 1234 0",
        "send 0000123 0",
        "send 800 0",
        "send 20000000 0",
        "send -12 0",
        "sent 123 0",
    ],
)
def test_what_is_no_frame_is_refused(words: str) -> None:
    with pytest.raises(Malformed):
        sent_frame(words)


def test_elements_arrive_in_pieces() -> None:
    elements = Elements()
    found: list[str | None] = []
    for octet in b"< send 123 1 a >\n<open can0><  rawmode\t>":
        elements.feed(bytes((octet,)))
        found += taken(elements)
    assert found == ["send 123 1 a", "open can0", "rawmode"]


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (b"rubbish < echo >", [None, "echo"]),
        (b"< broken < echo >", [None, "echo"]),
        (b"<" + b"x" * 300 + b">< echo >", [None, None, "echo"]),
        (b"< \xff >< echo >", [None, "echo"]),
        (b"> < echo > >", [None, "echo", None]),
        (b"< a" + b" " * 250, []),
        (b"GET / HTTP/1.1\r\n\r\n", [None]),
    ],
)
def test_what_is_no_element_is_refused(data: bytes, found: list[str | None]) -> None:
    elements = Elements()
    elements.feed(data)
    assert list(taken(elements)) == found


@given(st.lists(NEARLY, max_size=5))
def test_any_octets_end_and_little_is_kept(pieces: list[bytes]) -> None:
    for stream in (Elements(), Lines()):
        for piece in pieces:
            stream.feed(piece)
            for text in taken(stream):
                if text is not None:
                    for parse in (sent_frame, slcan_frame):
                        with suppress(Malformed):
                            assert isinstance(parse(text), Frame)
            assert stream.waiting < 256


@given(NEARLY, FRAMES)
def test_an_element_is_found_behind_anything(rubbish: bytes, frame: Frame) -> None:
    elements = Elements()
    text = frame_text(frame, 0)
    elements.feed(rubbish + b"< >" + text)
    assert list(taken(elements))[-1] == " ".join(text.decode()[1:-1].split())


@given(FRAMES, st.booleans())
def test_slcan_both_ways(frame: Frame, remote: bool) -> None:
    if remote:
        frame = Frame(frame.can_id, b"", True, frame.extended)
    lines = Lines()
    lines.feed(slcan_text(frame))
    line = lines.take()
    assert line is not None
    assert slcan_frame(line) == frame


@pytest.mark.parametrize(
    "line",
    [
        "t",
        "t123",
        "t1232aa",
        "t1231aabb",
        "t8000",
        "T200000000",
        "r1231aa",
        "t123x",
        "é",
    ],
)
def test_what_is_no_line_of_a_frame(line: str) -> None:
    with pytest.raises(Malformed):
        slcan_frame(line)


def test_lines() -> None:
    lines = Lines()
    lines.feed(b"O\r\nV\r" + b"x" * 256 + b"\rC")
    assert list(taken(lines)) == ["O", "V", None, ""]
    lines.feed(b"\r")
    assert list(taken(lines)) == ["C"]


def test_faults() -> None:
    assert fault_of("loss=0.25@1ff") == Fault("loss", 0.25, 0x1FF)
    assert fault_of("delay=2.5") == Fault("delay", 0.0025)
    assert fault_of("bus-off=1:.5") == Fault("bus-off", 1.0, duration=0.5)
    assert times_off([fault_of("loss=1"), fault_of("bus-off=1:2")]) == [(1.0, 3.0)]
    faults = Faults([fault_of("loss=0.5"), fault_of("delay=4@80")], seed=1)
    what = [faults.delay(Frame(0x80)) for _ in range(200)]
    assert {None, 0.004} == set(what)
    assert 60 < what.count(None) < 140
    again = Faults([fault_of("loss=0.5"), fault_of("delay=4@80")], seed=1)
    assert [again.delay(Frame(0x80)) for _ in range(200)] == what
    assert Faults([fault_of("loss=1@80")]).delay(Frame(0x81)) == 0.0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "loss",
        "loss=2",
        "loss=-1",
        "delay=1@xyz",
        "bus-off=1",
        "delay=1e9",
        "loss=1@",
    ],
)
def test_what_is_no_fault(text: str) -> None:
    with pytest.raises(ValueError, match=r"fault|probability|day"):
        fault_of(text)


def spellings(text: bytes, chance: Random) -> bytes:
    """Return a text with some octets changed, doubled or left out."""
    octets = bytearray(text)
    for _ in range(chance.choice((0, 0, 1, 1, 2, 3))):
        at = chance.randrange(len(octets))
        octets[at : at + chance.choice((0, 1, 1))] = bytes(
            chance.choices(b"  <>0179aAfF.sx\n", k=chance.choice((0, 1, 1, 2)))
        )
    return bytes(octets)


@given(FRAMES, st.integers(0, 10**15), st.randoms(use_true_random=False))
def test_usual_spellings_are_read_as_any_others(
    frame: Frame, micros: int, chance: Random
) -> None:
    digits = chance.choice(("%02X", "%X", "%x"))
    octets = " ".join(digits % octet for octet in frame.data)
    sent = f"< send {frame.can_id:X} {len(frame.data)} {octets} >".encode()
    by_hand = spellings(chance.choice((sent, send_text(frame))), chance)
    elements = Elements()
    elements.feed(by_hand)
    found = elements.take_sent()
    if found is not None:
        slowly = Elements()
        slowly.feed(by_hand)
        words = slowly.take()
        assert words is not None
        assert sent_frame(words) == found
        assert slowly.waiting == elements.waiting
    arrived = spellings(frame_text(frame, 1000 * micros), chance)
    elements = Elements()
    elements.feed(arrived)
    received = elements.take_received()
    if received is not None:
        slowly = Elements()
        slowly.feed(arrived)
        words = slowly.take()
        assert words is not None
        assert received_frame(words) == received
        assert slowly.waiting == elements.waiting


@given(FRAMES)
def test_the_usual_spelling_is_taken_at_once(frame: Frame) -> None:
    elements = Elements()
    elements.feed(send_text(frame) + frame_text(frame, 1_700_000_000_123_456_789))
    assert elements.take_sent() == frame
    assert elements.take_received() == (frame, 1700000000.123456)
    assert elements.waiting == 0
