"""Conversations of SDO, octet by octet (CiA 301, 7.2.4.3): `C` and `S` are client and server.

The CRC of `123456789` is 31C3h, that of its first seven digits 86D6h. Abort codes are sent with the
low octet first.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from sdo_line import Line

from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

NINE = b"123456789"


class Cells:
    """Values by index and sub-index, of at most `limit` octets."""

    def __init__(self, value: bytes, limit: int = 9) -> None:
        self.values = {(0x2000, 0): value, (0x2A5B, 7): b"\x5a"}
        self.limit = limit

    def read(self, index: int, subindex: int) -> bytes:
        if (index, subindex) not in self.values:
            raise SdoAbort(sdo.NO_OBJECT)
        return self.values[index, subindex]

    def writable_size(self, index: int, subindex: int) -> int:
        self.read(index, subindex)
        return self.limit

    def write(self, index: int, subindex: int, value: bytes) -> None:
        self.read(index, subindex)
        if len(value) > self.limit:
            raise SdoAbort(sdo.LENGTH_TOO_HIGH)
        self.values[index, subindex] = value


def play(
    end: str,
    receive: Callable[[Frame, int], list[Frame]],
    conversation: str,
    sent: list[Frame],
) -> None:
    """Check that an end sends exactly its messages, when it receives those of the other."""
    can_id = 0x585 if end == "C" else 0x605
    messages = [frame.data.hex() for frame in sent]
    for line in conversation.strip().splitlines():
        sender, _, text = line.strip().partition(" ")
        octets = text.replace(" ", "").ljust(16, "0")
        if sender == end:
            assert messages[:1] == [octets]
            messages.pop(0)
        else:
            assert messages == []
            frame = Frame(can_id, bytes.fromhex(octets))
            messages = [answer.data.hex() for answer in receive(frame, 0)]
    assert messages == []


UPLOADS = {
    "four octets are expedited": (b"1234", "C 40 002000\nS 43 002000 31323334"),
    "another object": (b"", "C 40 5b2a07\nS 4f 5b2a07 5a"),
    "a sub-index that does not exist": (b"", "C 40 5b2a00\nS 80 5b2a00 00000206"),
    "the largest value": (b"12345678", "C 40 002000\nS 41 002000 08"),
    "a larger value": (b"123456789", "C 40 002000\nS 80 002000 05000405"),
    "a block without CRC": (
        b"12345678",
        """C a0 002000 7f
        S c6 002000 08
        C a3
        S 01 31323334353637
        S 82 38
        C a2 02 7f
        S d9
        C a1""",
    ),
    "a size of the next block that cannot be": (
        b"12345678",
        """C a4 002000 01
        S c6 002000 08
        C a3
        S 01 31323334353637
        C a2 01 00
        S 80 002000 02000405""",
    ),
    "five blocks in a row of which nothing arrives, after one of which something did": (
        b"12345678",
        """C a4 002000 01
        S c6 002000 08
        C a3
        S 01 31323334353637
        C a2 01 01
        S 81 38
        C a2 00 01
        S 81 38
        C a2 00 01
        S 81 38
        C a2 00 01
        S 81 38
        C a2 00 01
        S 81 38
        C a2 00 01
        S 80 002000 03000405""",
    ),
}


@pytest.mark.parametrize("name", UPLOADS)
def test_a_server_sends(name: str) -> None:
    value, conversation = UPLOADS[name]
    server = SdoServer(5, Cells(value), max_size=8)
    play("S", server.receive, conversation, [])


BLOCK = "S a4 002000 7f\nC 01 31323334353637\nC 82 3839\nS a2 02 7f\n"
DOWNLOADS = {
    "a block as large as the limit": (
        NINE,
        f"C c6 002000 09\n{BLOCK}C d5 c331\nS a1",
    ),
    "a block of another size than announced, below": (
        None,
        f"C c6 002000 08\n{BLOCK}C d5 c331\nS 80 002000 12000706",
    ),
    "a block without a size": (NINE, f"C c4 002000\n{BLOCK}C d5 c331\nS a1"),
    "a block without CRC": (NINE, f"C c2 002000 09\n{BLOCK}C d5 1234\nS a1"),
    "reserved octets of the end": (
        NINE,
        f"C c6 002000 09\n{BLOCK}C d5 c331 ffffffffff\nS a1",
    ),
    "a block shorter than announced": (
        None,
        """C c6 002000 09
        S a4 002000 7f
        C 81 31323334353637
        S a2 01 7f
        C c1 d686
        S 80 002000 13000706""",
    ),
    "a block announced as larger than the limit": (
        None,
        "C c6 002000 0a\nS 80 002000 12000706",
    ),
    "segments as large as the limit": (
        NINE,
        """C 21 002000 09
        S 60 002000
        C 00 31323334353637
        S 20
        C 1b 3839
        S 30""",
    ),
    "four octets, since fewer are not indicated": (
        b"abcd",
        "C 2e 002000 61626364\nS 60 002000",
    ),
}


@pytest.mark.parametrize("name", DOWNLOADS)
def test_a_server_takes(name: str) -> None:
    value, conversation = DOWNLOADS[name]
    objects = Cells(b"old")
    play("S", SdoServer(5, objects).receive, conversation, [])
    assert objects.values[0x2000, 0] == (b"old" if value is None else value)


def test_the_dictionary_refuses_more_octets_than_it_takes() -> None:
    objects = Cells(b"old", limit=2)
    conversation = "C 23 002000 61626364\nS 80 002000 12000706"
    play("S", SdoServer(5, objects).receive, conversation, [])
    assert objects.values[0x2000, 0] == b"old"


def test_a_server_writes_the_object_of_the_request() -> None:
    objects = Cells(b"old")
    play("S", SdoServer(5, objects).receive, "C 2f 5b2a07 21\nS 60 5b2a07", [])
    assert objects.values == {(0x2000, 0): b"old", (0x2A5B, 7): b"!"}


SEGMENTS = "C 60\nS 00 31323334353637\nC 70\nS 1b 3839"
BLOCKS = "C a3\nS 01 31323334353637\nS 82 3839\nC a2 02 7f\n"
RESULTS: dict[str, tuple[bytes | int, str]] = {
    "segments without a size": (NINE, f"C 40 002000\nS 40 002000\n{SEGMENTS}"),
    "segments as large as the limit": (
        NINE,
        f"C 40 002000\nS 41 002000 09\n{SEGMENTS}",
    ),
    "four octets, since fewer are not indicated": (
        b"abcd",
        "C 40 002000\nS 4e 002000 61626364",
    ),
    "a block as large as the limit": (
        NINE,
        f"C a4 002000 7f\nS c6 002000 09\n{BLOCKS}S d5 c331\nC a1",
    ),
    "a block without a size": (
        NINE,
        f"C a4 002000 7f\nS c4 002000\n{BLOCKS}S d5 c331\nC a1",
    ),
    "a block without CRC": (
        NINE,
        f"C a4 002000 7f\nS c2 002000 09\n{BLOCKS}S d5 1234\nC a1",
    ),
    "a block with a wrong CRC": (
        0x05040004,
        f"C a4 002000 7f\nS c6 002000 09\n{BLOCKS}S d5 c332\nC 80 002000 04000405",
    ),
    "a block longer than announced": (
        0x06070012,
        f"C a4 002000 7f\nS c6 002000 08\n{BLOCKS}S d5 c331\nC 80 002000 12000706",
    ),
    "a block shorter than announced": (
        0x06070013,
        """C a4 002000 7f
        S c6 002000 09
        C a3
        S 81 31323334353637
        C a2 01 7f
        S c1 d686
        C 80 002000 13000706""",
    ),
    "a block announced as larger than the limit": (
        0x05040005,
        "C a4 002000 7f\nS c6 002000 0a\nC 80 002000 05000405",
    ),
    "an answer with the command of a block's end": (
        0x05040001,
        "C a4 002000 7f\nS c1 002000\nC 80 002000 01000405",
    ),
    "another command at the end of a block": (
        0x05040001,
        f"C a4 002000 7f\nS c6 002000 09\n{BLOCKS}S d6 c331\nC 80 002000 01000405",
    ),
}


@pytest.mark.parametrize("name", RESULTS)
def test_a_client_reads(name: str) -> None:
    result, conversation = RESULTS[name]
    client = SdoClient(5, max_size=9)
    begun = client.upload(0x2000, 0, 0, block=conversation.startswith("C a4"))
    play("C", client.receive, conversation, begun)
    check(client, result)


WRITES: dict[str, tuple[bytes | int, str]] = {
    "a block": (
        b"",
        """C c6 002000 09
        S a4 002000 7f
        C 01 31323334353637
        C 82 3839
        S a2 02 7f
        C d5 c331
        S a1""",
    ),
    "a block without CRC": (
        b"",
        """C c6 002000 09
        S a0 002000 7f
        C 01 31323334353637
        C 82 3839
        S a2 02 7f
        C d5
        S a1""",
    ),
    "a block for a server that takes no segments": (
        0x05040002,
        "C c6 002000 09\nS a4 002000\nC 80 002000 02000405",
    ),
    "another command in place of the start of a block": (
        0x05040001,
        "C c6 002000 09\nS a5 002000 7f\nC 80 002000 01000405",
    ),
    "another command in place of the start of segments": (
        0x05040001,
        "C 21 002000 09\nS 61 002000\nC 80 002000 01000405",
    ),
    "a toggle bit that does not alternate": (
        0x05030000,
        """C 21 002000 09
        S 60 002000
        C 00 31323334353637
        S 30
        C 80 002000 00000305""",
    ),
}


@pytest.mark.parametrize("name", WRITES)
def test_a_client_writes(name: str) -> None:
    result, conversation = WRITES[name]
    client = SdoClient(5)
    begun = client.download(0x2000, 0, NINE, 0, block=conversation.startswith("C c6"))
    play("C", client.receive, conversation, begun)
    check(client, result)


def test_another_command_in_place_of_an_expedited_answer() -> None:
    client = SdoClient(5)
    conversation = "C 2f 002000 21\nS 61 002000\nC 80 002000 01000405"
    play("C", client.receive, conversation, client.download(0x2000, 0, b"!", 0))
    check(client, 0x05040001)


def check(client: SdoClient, result: bytes | int) -> None:
    """Check the value, or the abort code, with which a transfer has ended."""
    assert not client.busy
    if isinstance(result, bytes):
        assert client.result() == result
        return
    with pytest.raises(SdoAbort) as caught:
        client.result()
    assert caught.value.code == result


@pytest.mark.parametrize("block_size", [0x20, 0x21, 0x40])
def test_segments_whose_number_is_a_command(block_size: int) -> None:
    """The last number of a block starts a transfer, if it is no segment."""
    value = bytes(7 * block_size + 1)
    objects = Cells(b"old", limit=len(value))
    wire = Line(SdoClient(5), SdoServer(5, objects, block_size=block_size))
    assert wire.run(wire.client.download(0x2000, 0, value, 0, block=True)) == b""
    assert objects.values[0x2000, 0] == value


def test_responses_of_other_formats_are_none() -> None:
    client = SdoClient(5)
    client.upload(0x2000, 0, 0)
    data = bytes.fromhex("4f00200007000000")
    for frame in (Frame(0x585, data, extended=True), Frame(0x585, remote=True)):
        assert client.receive(frame, 0) == []
    assert client.busy
    client.receive(Frame(0x585, data), 0)
    assert client.result() == b"\7"
    assert client.dropped == 0


def test_responses_to_nothing_are_counted() -> None:
    client = SdoClient(5)
    for count in (1, 2, 3):
        client.receive(Frame(0x585, bytes.fromhex("4f00200007000000")), 0)
        assert client.dropped == count


def test_each_response_gives_the_server_the_time_for_another() -> None:
    client = SdoClient(5, timeout=100)
    client.upload(0x2000, 0, 0)
    client.receive(Frame(0x585, bytes.fromhex("4100200008000000")), 50)
    assert client.deadline == 150
    assert client.poll(149) == []
    client.receive(Frame(0x585, bytes.fromhex("0031323334353637")), 149)
    client.receive(Frame(0x585, bytes.fromhex("1d38000000000000")), 248)
    assert client.result() == b"12345678"
    assert client.deadline is None


def test_draining_lasts_for_a_silence_after_the_abort() -> None:
    client = SdoClient(5, timeout=100, drain=50)
    client.upload(0x2000, 0, 0)
    client.poll(100)
    assert client.deadline == 150
    client.poll(149)
    assert not client.ready
    client.poll(150)
    assert client.ready
