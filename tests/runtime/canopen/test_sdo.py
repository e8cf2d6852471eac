"""SDO client and server: with each other, on a bad line, and message by message."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sdo_line import LOST, ONCE, TWICE, Values, line

from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

SIZES = [0, 1, 2, 3, 4, 5, 7, 8, 14, 127 * 7, 127 * 7 + 1, 2000]


def value_of(size: int) -> bytes:
    return bytes(i * 31 % 251 for i in range(size))


def request(text: str) -> Frame:
    return Frame(0x605, bytes.fromhex(text))


def answer(text: str) -> Frame:
    return Frame(0x585, bytes.fromhex(text))


def texts(frames: list[Frame]) -> list[str]:
    return [frame.data.hex() for frame in frames]


@pytest.mark.parametrize("block", [False, True])
@pytest.mark.parametrize("size", SIZES)
def test_every_size(size: int, block: bool) -> None:
    values, value = Values(), value_of(size)
    wire = line(values)
    assert wire.run(wire.client.download(0x2000, 0, value, 0, block=block)) == b""
    assert values.writes == [value]
    assert wire.run(wire.client.upload(0x2000, 0, wire.now, block=block)) == value
    assert wire.now < 1_000_000_000


def test_expedited_octets() -> None:
    wire = line(Values())
    wire.run(wire.client.download(0x2000, 0, b"\x12\x34\x56", 0))
    wire.run(wire.client.upload(0x2000, 0, 0))
    assert texts(wire.frames) == [
        "2700200012345600",
        "6000200000000000",
        "4000200000000000",
        "4700200012345600",
    ]


def test_segmented_octets() -> None:
    wire = line(Values())
    wire.run(wire.client.download(0x2000, 0, b"abcdefghi", 0))
    wire.run(wire.client.upload(0x2000, 0, 0))
    assert texts(wire.frames) == [
        "2100200009000000",
        "6000200000000000",
        "0061626364656667",
        "2000000000000000",
        "1b68690000000000",
        "3000000000000000",
        "4000200000000000",
        "4100200009000000",
        "6000000000000000",
        "0061626364656667",
        "7000000000000000",
        "1b68690000000000",
    ]


def test_block_octets() -> None:
    """The CRC of `123456789` is 31C3h."""
    wire = line(Values(), block_size=2)
    wire.run(wire.client.download(0x2000, 0, b"123456789", 0, block=True))
    wire.run(wire.client.upload(0x2000, 0, 0, block=True))
    assert texts(wire.frames) == [
        "c600200009000000",
        "a400200002000000",
        "0131323334353637",
        "8238390000000000",
        "a202020000000000",
        "d5c3310000000000",
        "a100000000000000",
        "a400200002000000",
        "c600200009000000",
        "a300000000000000",
        "0131323334353637",
        "8238390000000000",
        "a202020000000000",
        "d5c3310000000000",
        "a100000000000000",
    ]


@pytest.mark.parametrize("block", [False, True])
@pytest.mark.parametrize(
    ("index", "subindex", "code"),
    [
        (0x2001, 0, sdo.READ_ONLY),
        (0x3000, 0, sdo.NO_OBJECT),
        (0x2000, 1, sdo.NO_SUBINDEX),
        (0x2003, 0, sdo.LENGTH_TOO_HIGH),
    ],
)
def test_refused_before_data_flow(
    index: int, subindex: int, code: int, block: bool
) -> None:
    values = Values()
    wire = line(values)
    with pytest.raises(SdoAbort) as refused:
        wire.run(wire.client.download(index, subindex, value_of(50), 0, block=block))
    assert refused.value.code == code
    assert len(wire.frames) == 2
    assert values.writes == []


def test_refused_values() -> None:
    wire = line(Values())
    for block in (False, True):
        with pytest.raises(SdoAbort, match="06090030h value invalid"):
            wire.run(wire.client.download(0x2000, 0, b"BAD!", wire.now, block=block))
    with pytest.raises(SdoAbort, match="06010001h read of a write-only object"):
        wire.run(wire.client.upload(0x2002, 0, wire.now))


def test_a_transfer_after_an_abort_that_was_lost() -> None:
    """The server, still in the block, treats a message that cannot be a segment as a request."""
    values = Values()
    first = line(values, [ONCE, TWICE, ONCE, LOST, LOST], block_size=1)
    with pytest.raises(SdoAbort):
        first.run(first.client.download(0x2000, 0, value_of(8), 0, block=True))
    clean = line(values)
    clean.client, clean.server, clean.now = first.client, first.server, first.now
    clean.run(clean.client.download(0x2000, 0, value_of(30), clean.now))
    assert values.writes == [value_of(30)]


FATES = st.lists(st.sampled_from([LOST, ONCE, ONCE, ONCE, ONCE, TWICE]), max_size=40)


@pytest.mark.sampled(0)
@settings(max_examples=300, deadline=None)
@given(
    fates=FATES,
    size=st.integers(0, 120),
    block=st.booleans(),
    block_size=st.integers(1, 9),
)
def test_downloads_on_a_bad_line(
    fates: list[int], size: int, block: bool, block_size: int
) -> None:
    """The value is written completely or not at all; the client is right about the written part."""
    values, value = Values(), value_of(size)
    wire = line(values, fates, block_size)
    try:
        wire.run(wire.client.download(0x2000, 0, value, 0, block=block))
    except SdoAbort:
        assert set(values.writes) <= {value}
    else:
        assert values.value == value
    fresh = value_of(30)[::-1]
    clean = line(values)
    clean.client, clean.server, clean.now = wire.client, wire.server, wire.now
    clean.run(clean.client.download(0x2000, 0, fresh, clean.now))
    assert values.value == fresh


@settings(max_examples=300, deadline=None)
@given(
    fates=FATES,
    size=st.integers(0, 120),
    block=st.booleans(),
    block_size=st.integers(1, 9),
)
def test_uploads_on_a_bad_line(
    fates: list[int], size: int, block: bool, block_size: int
) -> None:
    """The result is the value or an abort; afterwards the next transfer works."""
    value = value_of(size)
    wire = line(Values(value), fates, block_size)
    try:
        assert wire.run(wire.client.upload(0x2000, 0, 0, block=block)) == value
    except SdoAbort:
        assert fates
    clean = line(Values(value))
    clean.client, clean.server, clean.now = wire.client, wire.server, wire.now
    assert clean.run(clean.client.upload(0x2000, 0, clean.now)) == value


@pytest.mark.parametrize("lost", range(2, 6))
def test_a_lost_segment_of_a_block_comes_again(lost: int) -> None:
    values, value = Values(), value_of(40)
    fates = [ONCE] * lost + [LOST]
    wire = line(values, fates)
    wire.run(wire.client.download(0x2000, 0, value, 0, block=True))
    assert values.writes == [value]


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(
                [0x20, 0x21, 0x40, 0x60, 0xA0, 0xA2, 0xA3, 0xC0, 0xC6, 0xC1]
            )
            | st.integers(0, 255),
            st.sampled_from([b"\0\x20\0", b"\3\x20\0"])
            | st.binary(min_size=3, max_size=3),
            st.binary(min_size=4, max_size=4),
        ),
        max_size=20,
    )
)
def test_any_messages(messages: list[tuple[int, bytes, bytes]]) -> None:
    """Neither end raises, and a message causes at most one block of answers."""
    server, client = SdoServer(5, Values(value_of(2000))), SdoClient(5)
    client.upload(0x2000, 0, 0, block=True)
    for head, target, rest in messages:
        data = bytes((head,)) + target + rest
        assert len(server.receive(Frame(0x605, data), 0)) <= 127
        assert len(client.receive(Frame(0x585, data), 0)) <= 127


def test_answers_are_matched() -> None:
    client = SdoClient(5)
    client.upload(0x2000, 1, 0)
    for late in ("4f01200107000000", "4f00200207000000", "8001200100000206"):
        assert client.receive(answer(late), 1) == []
        assert client.busy
    assert client.dropped == 3
    client.receive(answer("4f00200107000000"), 2)
    assert client.result() == b"\x07"


def test_time_out_aborts_and_drains() -> None:
    client = SdoClient(5, timeout=100, drain=50)
    client.upload(0x2000, 0, 0)
    assert client.poll(99) == []
    assert client.poll(100) == [request("8000200000000405")]
    with pytest.raises(SdoAbort, match="05040000h protocol timed out"):
        client.result()
    assert not client.ready
    with pytest.raises(RuntimeError, match=r"^a transfer is under way$"):
        client.upload(0x2000, 0, 100)
    client.receive(answer("4f00200007000000"), 130)
    assert client.dropped == 1
    client.poll(150)
    assert not client.ready
    client.poll(180)
    assert client.ready
    assert client.deadline is None


def test_draining_ends() -> None:
    """A server that sends forever delays the client for ten times the silence only."""
    client = SdoClient(5, timeout=100, drain=50)
    client.upload(0x2000, 0, 0)
    client.poll(100)
    for now in range(110, 600, 10):
        client.receive(answer("4f00200007000000"), now)
        client.poll(now)
        assert not client.ready
    client.poll(600)
    assert client.ready


def test_toggle_errors() -> None:
    client = SdoClient(5)
    client.upload(0x2000, 0, 0)
    assert client.receive(answer("4100200009000000"), 0) == [request("60" + "00" * 7)]
    reply = client.receive(answer("1061626364656667"), 0)
    assert reply == [request("8000200000000305")]
    server = SdoServer(5, Values())
    server.receive(request("2100200009000000"), 0)
    reply = server.receive(request("1061626364656667"), 0)
    assert reply == [answer("8000200000000305")]
    assert server.deadline is None


def test_server_gives_up_silently_gone_clients() -> None:
    server = SdoServer(5, Values(), timeout=100)
    server.receive(request("2100200009000000"), 0)
    server.receive(request("0061626364656667"), 50)
    assert server.poll(149) == []
    assert server.poll(150) == [answer("8000200000000405")]
    assert server.poll(1000) == []


def test_a_new_request_ends_the_transfer_before() -> None:
    values = Values(b"x")
    server = SdoServer(5, values)
    server.receive(request("2100200009000000"), 0)
    assert server.receive(request("4000200000000000"), 0) == [
        answer("4f00200078000000")
    ]
    reply = server.receive(request("0061626364656667"), 0)
    assert texts(reply)[0].endswith("01000405")
    assert values.writes == []


def test_bounded_sizes() -> None:
    values = Values()
    server = SdoServer(5, values, max_size=10)
    reply = server.receive(request("210020000b000000"), 0)
    assert reply == [answer("8000200012000706")]
    server.receive(request("2000200000000000"), 0)
    server.receive(request("0061626364656667"), 0)
    reply = server.receive(request("1061626364656667"), 0)
    assert reply == [answer("8000200005000405")]
    client = SdoClient(5, max_size=10)
    client.upload(0x2000, 0, 0)
    reply = client.receive(answer("410020000b000000"), 0)
    assert reply == [request("8000200005000405")]
    with pytest.raises(ValueError, match="11 octets"):
        SdoClient(5, max_size=10).download(0x2000, 0, bytes(11), 0)


def test_lengths_that_are_not_as_told() -> None:
    server = SdoServer(5, Values())
    for size, code in ((3, "12000706"), (5, "13000706")):
        server.receive(request(f"210020000{size}000000"), 0)
        reply = server.receive(request("0761626364000000"), 0)
        assert reply == [answer("80002000" + code)]


def test_wrong_crc() -> None:
    values = Values()
    server = SdoServer(5, values)
    server.receive(request("c600200003000000"), 0)
    server.receive(request("8161626300000000"), 0)
    reply = server.receive(request("d100000000000000"), 0)
    assert reply == [answer("8000200004000405")]
    assert values.writes == []


def test_block_sizes_that_cannot_be() -> None:
    server = SdoServer(5, Values())
    for size in ("00", "80"):
        reply = server.receive(request(f"a4002000{size}000000"), 0)
        assert reply == [answer("8000200002000405")]


def test_small_values_by_block_upload_may_come_at_once() -> None:
    server = SdoServer(5, Values(b"ab"))
    reply = server.receive(request("a400200010020000"), 0)
    assert reply == [answer("4b00200061620000")]


def test_size_untold() -> None:
    """22h has as many octets as the object; 42h returns four."""
    values = Values()
    values.limit = 2
    server = SdoServer(5, values)
    server.receive(request("2200200061620000"), 0)
    assert values.value == b"ab"
    client = SdoClient(5)
    client.upload(0x2000, 0, 0)
    client.receive(answer("4200200061620000"), 0)
    assert client.result() == b"ab\0\0"


@pytest.mark.parametrize(
    "frame",
    [
        request("40002000000000"),
        Frame(0x606, bytes.fromhex("4000200000000000")),
        Frame(0x605, remote=True),
        Frame(0x605, bytes.fromhex("4000200000000000"), extended=True),
        request("8000200000000405"),
    ],
)
def test_what_a_server_does_not_answer(frame: Frame) -> None:
    assert SdoServer(5, Values()).receive(frame, 0) == []


def test_acknowledgements_that_cannot_be() -> None:
    server = SdoServer(5, Values(value_of(20)))
    server.receive(request("a400200002000000"), 0)
    server.receive(request("a3" + "00" * 7), 0)
    reply = server.receive(request("a203020000000000"), 0)
    assert reply == [answer("8000200003000405")]


def test_blocks_of_which_nothing_arrives() -> None:
    """After five in a row, the sender gives up."""
    server = SdoServer(5, Values(value_of(20)))
    server.receive(request("a400200002000000"), 0)
    server.receive(request("a3" + "00" * 7), 0)
    for _ in range(4):
        assert len(server.receive(request("a200020000000000"), 0)) == 2
    reply = server.receive(request("a200020000000000"), 0)
    assert reply == [answer("8000200003000405")]


NOTHING = [
    ("40", ["0e", "1e"], "13000706"),
    ("c0", ["02"], "03000405"),
    ("c0", ["82"], "03000405"),
    ("c0", ["7f"], "03000405"),
    ("c0", ["03", "85", "7f"], "03000405"),
]
"""The first message of a transfer, those that are repeated without end, and the abort code."""


@pytest.mark.parametrize(("first", "repeated", "code"), NOTHING)
def test_a_peer_that_sends_messages_without_effect_is_given_up(
    first: str, repeated: list[str], code: str
) -> None:
    abort = f"80002000{code}"
    client = SdoClient(5)
    client.upload(0x2000, 0, 0, block=first == "c0")
    client.receive(answer(f"{first}00200000000000"), 0)
    server = SdoServer(5, Values())
    begun = "20" if first == "40" else first
    server.receive(request(f"{begun}00200000000000"), 0)
    for receive, frame in ((client.receive, answer), (server.receive, request)):
        sent = [frame(f"{each}{'00' * 7}") for each in repeated]
        answers = (receive(sent[n % len(sent)], 0) for n in range(5 * sdo.MAX_BLOCK))
        assert any(texts(frames) == [abort] for frames in answers)


def test_blocks_are_bounded() -> None:
    server = SdoServer(5, Values(), max_size=8)
    server.receive(request("c400200000000000"), 0)
    assert server.receive(request("01" + "61" * 7), 0) == []
    assert server.receive(request("02" + "61" * 7), 0) == []
    reply = server.receive(request("03" + "61" * 7), 0)
    assert reply == [answer("8000200005000405")]
    server.receive(request("c000200000000000"), 0)
    server.receive(request("01" + "61" * 7), 0)
    server.receive(request("82" + "61" * 7), 0)
    reply = server.receive(request("c1" + "00" * 7), 0)
    assert reply == [answer("8000200012000706")]


def test_aborts_are_matched_within_a_transfer() -> None:
    client = SdoClient(5)
    client.upload(0x2000, 0, 0)
    client.receive(answer("4100200009000000"), 0)
    client.receive(answer("8001200000000405"), 0)
    assert client.busy
    client.receive(answer("8000200000000405"), 0)
    assert not client.busy
    assert client.ready


def test_the_client_drains_after_its_own_abort() -> None:
    client = SdoClient(5)
    client.upload(0x2000, 0, 0)
    client.receive(answer("6000200000000000"), 0)
    assert not client.busy
    assert not client.ready


def test_toggle_of_upload_requests() -> None:
    server = SdoServer(5, Values(value_of(20)))
    server.receive(request("4000200000000000"), 0)
    reply = server.receive(request("70" + "00" * 7), 0)
    assert reply == [answer("8000200000000305")]


def test_a_request_after_the_last_block() -> None:
    """Within blocks every message is a segment; after them a transfer may begin."""
    server = SdoServer(5, Values(b"x"))
    server.receive(request("c400200000000000"), 0)
    server.receive(request("81" + "61" * 7), 0)
    assert server.receive(request("4000200000000000"), 0) == [
        answer("4f00200078000000")
    ]
