"""A server with clients that disconnect, stay silent, send wrong data, or request too much."""

from __future__ import annotations

import logging
import select
import selectors
import socket
import struct
import threading
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from typing import Any

import pytest
from peers import (
    NOTHING_FOLLOWS,
    REPLY_SIZE,
    SOP,
    Board,
    load_request,
    note_request,
    receive,
    reply,
    rest,
    set_request,
)

from rtgen.runtime import requests
from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    E_NOMEM,
    E_PAR,
    E_TMOUT,
    ChannelError,
    ExchangeChannel,
    MessageReader,
    PacketServer,
    ProtocolError,
    TcpChannel,
    TcpServer,
    serve_message,
    tcp_server,
)

LONG, SHORT = 20.0, 0.1


@contextmanager
def serving(
    board: Board, timeout: float = LONG, allocator_size: int = 4096
) -> Iterator[TcpServer]:
    with TcpServer(board, timeout=timeout, allocator_size=allocator_size) as server:
        yield server


def connect(server: TcpServer) -> socket.socket:
    return socket.create_connection(server.address, timeout=LONG)


def good_call(server: TcpServer, value: int = 42) -> None:
    """Check that the next client is served."""
    with connect(server) as client:
        client.sendall(set_request(value))
        assert receive(client, REPLY_SIZE) == reply(value)


def answer(server: TcpServer, request: bytes) -> bytes:
    """Return all bytes until the server closes."""
    with connect(server) as client:
        client.sendall(request)
        return rest(client)


class Turns(requests.Pace):
    """Counts the requests that ask for their turn."""

    def __init__(self) -> None:
        super().__init__(1.0)
        self.waits = 0

    def wait(self) -> None:
        self.waits += 1


def test_requests_wait_for_their_turn_while_ticks_are_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    turns = Turns()
    monkeypatch.setattr(requests, "calls", turns)
    monkeypatch.setattr(requests, "overruns", requests.Overruns(lambda: 0.0))
    board = Board()
    packets = PacketServer(board)
    with serving(board) as server:
        good_call(server)
        packets(set_request(1))
        assert turns.waits == 0
        requests.overruns.report()
        good_call(server)
        assert turns.waits == 1
        assert packets(set_request(1) * 2) == reply(1) * 2
        assert turns.waits == 3


def test_calls_one_after_the_other() -> None:
    board = Board()
    with serving(board) as server, connect(server) as client:
        for value in (1, 2, 3):
            client.sendall(set_request(value))
            assert receive(client, REPLY_SIZE) == reply(value)
    assert board.calls == [("set", 1), ("set", 2), ("set", 3)]


def test_requests_in_one_segment() -> None:
    board = Board()
    with serving(board) as server, connect(server) as client:
        client.sendall(
            set_request(1) + note_request(2) + load_request(b"abc") + set_request(4)
        )
        assert receive(client, 3 * REPLY_SIZE) == reply(1) + reply(3) + reply(4)
    assert board.calls == [("set", 1), ("note", 2), ("load", b"abc"), ("set", 4)]


def test_a_request_byte_by_byte() -> None:
    board = Board()
    with serving(board) as server, connect(server) as client:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in load_request(b"ab") + set_request(5):
            client.sendall(bytes([byte]))
        assert receive(client, 2 * REPLY_SIZE) == reply(2) + reply(5)
    assert board.calls == [("load", b"ab"), ("set", 5)]


@pytest.mark.parametrize(
    "request_",
    [
        b"\0\0",
        b"\x67\x2b",
        b"\x56\x1e",
        SOP + b"\0\x63",
        SOP + b"\0\0",
        set_request(1)[:-2] + b"\0\0",
        set_request(1)[:-2] + NOTHING_FOLLOWS,
        note_request(1)[:-2] + b"\x5a\x3c",
        load_request(b"", -1),
        load_request(b"", -(2**31)),
        load_request(b"", 2**31 - 1),
        load_request(bytes(100), 5000),
    ],
    ids=lambda request: request.hex()[:24],
)
def test_bad_bytes_are_reported_by_closing(request_: bytes) -> None:
    board = Board()
    with serving(board) as server:
        assert answer(server, request_) == b""
        good_call(server)
    assert board.calls == [("set", 42)]


@pytest.mark.parametrize("size", range(len(load_request(b"abc"))))
@pytest.mark.parametrize("reset", [False, True])
def test_a_client_that_leaves_inside_a_request(size: int, reset: bool) -> None:
    board = Board()
    with serving(board) as server:
        with connect(server) as client:
            client.sendall(load_request(b"abc")[:size])
            if reset:
                linger = struct.pack("ii", 1, 0)
                client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        good_call(server)
    assert board.calls == [("set", 42)]


def test_a_client_that_leaves_before_the_reply() -> None:
    board = Board()
    with serving(board) as server:
        with connect(server) as client:
            client.sendall(set_request(1))
        good_call(server)
    assert board.calls == [("set", 1), ("set", 42)]


@pytest.mark.parametrize("size", range(1, 10))
def test_silence_inside_a_request(size: int) -> None:
    board = Board()
    with serving(board, SHORT / 2) as server:
        assert answer(server, set_request(1)[:size]) == b""
        good_call(server)
    assert board.calls == [("set", 42)]


def test_silence_between_requests_is_allowed() -> None:
    board = Board()
    with serving(board, SHORT / 2) as server, connect(server) as client:
        for value in (1, 2):
            client.sendall(set_request(value))
            assert receive(client, REPLY_SIZE) == reply(value)
            threading.Event().wait(SHORT)


@pytest.mark.sampled(0)
def test_a_client_that_does_not_read_its_replies() -> None:
    board = Board()
    with serving(board, SHORT) as server:
        with socket.socket() as client:
            # Before it connects, or the server's buffer grows to megabytes.
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            client.connect(server.address)
            client.setblocking(False)
            requests = set_request(1) * 1000
            closed = False
            while not closed:
                try:
                    client.send(requests)
                except BlockingIOError:
                    threading.Event().wait(SHORT / 10)
                except ConnectionError:
                    closed = True
        good_call(server)


def test_others_wait_while_a_client_is_served() -> None:
    board = Board()
    with serving(board) as server, connect(server) as second, connect(server) as third:
        second.sendall(set_request(2))
        assert receive(second, REPLY_SIZE) == reply(2)
        third.sendall(set_request(3))
        second.sendall(set_request(4))
        assert receive(second, REPLY_SIZE) == reply(4)
        second.close()
        assert receive(third, REPLY_SIZE) == reply(3)
    assert board.calls == [("set", 2), ("set", 4), ("set", 3)]


@pytest.mark.skipif(not hasattr(select, "POLLRDHUP"), reason="needs POLLRDHUP (Linux)")
def test_who_gave_up_waiting_is_not_served() -> None:
    board = Board()
    with serving(board, SHORT) as server:
        with connect(server) as first:
            first.sendall(set_request(1))
            assert receive(first, REPLY_SIZE) == reply(1)
            channel = TcpChannel(*server.address, timeout=SHORT)
            with pytest.raises(ChannelError) as caught:
                channel.begin(set_request(111), REPLY_SIZE)
            assert caught.value.sub == E_TMOUT
            threading.Event().wait(SHORT)
        good_call(server)
    assert board.calls == [("set", 1), ("set", 42)]


def test_clients_come_and_go() -> None:
    board = Board()
    with serving(board) as server:
        for value in range(50):
            for request in (b"\0\0", note_request(value), b""):
                with connect(server) as client:
                    client.sendall(request)
            good_call(server, value)
    assert board.calls == [
        (name, value) for value in range(50) for name in ("note", "set")
    ]


def test_a_target_that_fails(caplog: pytest.LogCaptureFixture) -> None:
    board = Board()
    board.failing = True
    with caplog.at_level(logging.ERROR), serving(board) as server:
        assert answer(server, set_request(1)) == b""
        board.failing = False
        good_call(server)
    assert board.calls == [("set", 1), ("set", 42)]
    assert "the motor is gone" in caplog.text


def test_the_size_of_a_request_is_limited() -> None:
    board = Board()
    size = len(load_request(bytes(50)))
    with serving(board, allocator_size=size) as server:
        with connect(server) as client:
            client.sendall(2 * load_request(bytes(50)))
            assert receive(client, 2 * REPLY_SIZE) == 2 * reply(50)
        assert answer(server, load_request(bytes(51))) == b""
    assert board.calls == 2 * [("load", bytes(50))]


def test_nothing_is_allocated_for_a_size_that_lies() -> None:
    lie = load_request(b"", 2**31 - 1)
    with (
        serving(Board(), allocator_size=2**31 - 1) as server,
        connect(server) as client,
    ):
        tracemalloc.start()
        try:
            client.sendall(lie)
            client.shutdown(socket.SHUT_WR)
            assert rest(client) == b""
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert peak < 1_000_000


class Recorder(MessageReader):
    """Returns bytes of a stream one at a time and records how many were requested."""

    def __init__(self, stream: bytes, limit: int) -> None:
        super().__init__(limit)
        self._stream = iter(stream)
        self.asked: list[int] = []

    def _wait(self) -> bytes:
        return bytes([next(self._stream)])

    def _receive(self, size: int) -> bytes:
        self.asked.append(size)
        return bytes(islice(self._stream, 1))


@pytest.mark.parametrize(
    ("size", "code"), [(-1, E_PAR), (4096, E_NOMEM), (2**31 - 1, E_NOMEM), (9, E_BOVR)]
)
def test_sizes_are_checked_before_bytes_are_asked_for(size: int, code: int) -> None:
    reader = Recorder(load_request(b"", size), 4096)
    with pytest.raises((ProtocolError, ChannelError)) as caught:
        serve_message(reader, Board().handlers)
    assert caught.value.sub == code
    assert max(reader.asked) <= 9


def test_messages_need_no_socket() -> None:
    board = Board()
    channel = ExchangeChannel(PacketServer(board))
    assert channel.begin(set_request(1), 2) + channel.more(6) == reply(1)
    channel.end()
    assert channel.begin(note_request(2), 0) == b""
    channel.end()
    with pytest.raises(ChannelError):
        channel.begin(set_request(1)[:-1], REPLY_SIZE)
    with pytest.raises(ChannelError):
        channel.begin(set_request(1), REPLY_SIZE + 1)
    channel.reset()
    assert board.calls == [("set", 1), ("note", 2), ("set", 1)]


@pytest.mark.parametrize("connected", [False, True])
def test_closing_a_server_that_waits(connected: bool) -> None:
    server = TcpServer(Board(), timeout=LONG)
    server.start()
    client = connect(server) if connected else None
    if client is not None:
        client.sendall(set_request(1))
        assert receive(client, REPLY_SIZE) == reply(1)
    server.close()
    if client is not None:
        assert rest(client) == b""
        client.close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(server.address).close()
    server.close()


def test_a_server_is_closed_before_it_serves() -> None:
    server = TcpServer(Board())
    server.close()
    server.serve_forever()


def test_a_server_is_closed_when_it_is_about_to_wait(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    server = TcpServer(Board())

    class Late(selectors.DefaultSelector):
        def register(self, *args: Any) -> selectors.SelectorKey:
            server.close()
            return super().register(*args)

    monkeypatch.setattr(tcp_server.selectors, "DefaultSelector", Late)
    server.serve_forever()


def test_channel_and_server() -> None:
    board = Board()
    with serving(board) as server:
        channel = TcpChannel(*server.address, timeout=LONG)
        for value in range(100):
            assert channel.begin(set_request(value), REPLY_SIZE) == reply(value)
            channel.end()
        with pytest.raises(ChannelError):
            channel.begin(SOP + b"\0\x63\x5a\x3c", REPLY_SIZE)
        assert channel.begin(note_request(7), 0) == b""
        channel.end()
        assert board.noted.wait(LONG)
        channel.close()
    assert board.calls == [*(("set", value) for value in range(100)), ("note", 7)]
