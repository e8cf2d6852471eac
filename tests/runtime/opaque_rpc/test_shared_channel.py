"""Several signatures on one connection, with the bytes of recorded exchanges."""

from __future__ import annotations

import socket
import struct

import pytest
from peers import TWO_WAY, Act, receive, rest, scripted

from rtgen.runtime.opaque_rpc import (
    E_MAGIC,
    ChannelError,
    PacketServer,
    ProtocolError,
    SharedChannel,
    SharedUnmarshaller,
    TcpChannel,
    TcpServer,
)
from rtgen.runtime.opaque_rpc.channel import Handlers, More

LONG = 20.0
REQUEST = bytes.fromhex("2a670100785634123c5a")
REPLY = bytes.fromhex("1e56000000005e6d")
BEGIN, END = b"\x41\x31", b"\x18\x27"
EXCHANGE = BEGIN + b"\0\0" + REQUEST + END
ONEWAY = bytes.fromhex("2a6702005e6d")


class Native:
    """A little-endian board: 1 `ER func([in] int32_t)`, 2 `oneway void event(void)`."""

    def __init__(self) -> None:
        self.calls: list[int] = []

    @property
    def handlers(self) -> Handlers:
        return {b"\x2a\x67\1\0": self._func, b"\x2a\x67\2\0": self._event}

    def _func(self, more: More) -> bytes:
        value, end = struct.unpack("<i2s", more(6))
        if end != TWO_WAY[::-1]:
            raise ProtocolError(E_MAGIC, "end")
        self.calls.append(value)
        return REPLY

    def _event(self, more: More) -> None:
        more(2)
        self.calls.append(0)


def test_the_client_writes_what_was_recorded() -> None:
    sent: list[bytes] = []

    def act(connection: socket.socket) -> None:
        sent.append(receive(connection, len(EXCHANGE) - 2))
        connection.sendall(REPLY)
        sent.append(receive(connection, 2))
        sent.append(rest(connection))

    with scripted(act) as server:
        base = TcpChannel(*server.address, timeout=LONG)
        first, second = SharedChannel(base, 0), SharedChannel(base, 1)
        assert first.begin(REQUEST, 6) + first.more(2) == REPLY
        first.end()
        assert second.begin(ONEWAY, 0) == b""
        second.end()
        base.close()
    assert sent == [EXCHANGE[:-2], END, BEGIN + b"\1\0" + ONEWAY + END]


def test_a_reply_counts_though_the_connection_breaks_behind_it() -> None:
    def act(connection: socket.socket) -> None:
        receive(connection, len(EXCHANGE) - 2)
        connection.sendall(REPLY)
        linger = struct.pack("ii", 1, 0)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)

    again: Act = act
    with scripted(act, again) as server:
        base = TcpChannel(*server.address, timeout=LONG)
        channel = SharedChannel(base, 0)
        for _ in range(2):
            assert channel.begin(REQUEST, 8) == REPLY
            receive_nothing_more(base)
            channel.end()
        base.close()


def receive_nothing_more(channel: TcpChannel) -> None:
    """Wait until the peer has reset the connection."""
    with pytest.raises(ChannelError):
        channel.more(1)


def test_a_reset_frees_the_connection() -> None:
    boards = [Native()]
    with TcpServer(SharedUnmarshaller(boards)) as server:
        base = TcpChannel(*server.address, timeout=LONG)
        channel = SharedChannel(base, 0)
        channel.begin(REQUEST, 2)
        channel.reset()
        assert channel.begin(REQUEST, 8) == REPLY
        channel.end()
        base.close()


def test_sub_channels_have_their_own_boards() -> None:
    boards = [Native(), Native()]
    with TcpServer(SharedUnmarshaller(boards)) as server:
        base = TcpChannel(*server.address, timeout=LONG)
        for number in (0, 1, 0):
            channel = SharedChannel(base, number)
            assert channel.begin(REQUEST, 8) == REPLY
            channel.end()
        base.close()
    assert [board.calls for board in boards] == [[0x12345678] * 2, [0x12345678]]


@pytest.mark.parametrize(
    "bad",
    [
        b"\0\0\0\0\0\0",
        BEGIN + b"\2\0",
        BEGIN + b"\xff\xff",
        BEGIN + b"\0\0" + b"\0\0\0\0",
        BEGIN + b"\0\0" + b"\x2a\x67\x63\0",
        EXCHANGE[:-4] + b"\0\0",
        BEGIN + BEGIN,
        END,
    ],
    ids=bytes.hex,
)
def test_the_server_passes_over_what_is_no_exchange(bad: bytes) -> None:
    board = Native()
    with (
        TcpServer(SharedUnmarshaller([board])) as server,
        socket.create_connection(server.address, timeout=LONG) as client,
    ):
        client.sendall(bad + EXCHANGE)
        assert receive(client, 8) == REPLY
        client.sendall(EXCHANGE)
        assert receive(client, 8) == REPLY
    assert board.calls == [0x12345678] * 2


@pytest.mark.parametrize("end", [b"\0\0", END + END])
def test_a_wrong_end_is_passed_over(end: bytes) -> None:
    board = Native()
    serve = PacketServer(SharedUnmarshaller([board]))
    assert serve(EXCHANGE[:-2] + end + EXCHANGE) == 2 * REPLY


def test_at_the_end_of_the_stream_the_next_client_is_served() -> None:
    board = Native()
    with TcpServer(SharedUnmarshaller([board]), timeout=LONG) as server:
        for size in range(len(EXCHANGE)):
            with socket.create_connection(server.address, timeout=LONG) as client:
                client.sendall(EXCHANGE[:size])
                client.shutdown(socket.SHUT_WR)
                assert rest(client) in (b"", REPLY)
    assert board.calls == [0x12345678] * 2
