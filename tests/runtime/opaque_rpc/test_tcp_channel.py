"""Calls over TCP to peers that disconnect, stay silent, send wrong data, or answer late."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from free_ports import free_port
from peers import (
    NOTHING_FOLLOWS,
    REPLY_SIZE,
    REPLY_SOP,
    Scripted,
    note_request,
    receive,
    reply,
    rest,
    scripted,
    set_request,
)

from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    E_OBJ,
    E_TMOUT,
    ChannelError,
    TcpChannel,
)

pytestmark = pytest.mark.waits

SHORT = 0.15
"""A time-out that a test waits for."""
MEDIUM = 1.5
"""A time-out that a test waits for, after the peer has done something."""
LONG = 20.0
PAUSE = 0.06
"""Longer than a connection is reused without a check."""


@contextmanager
def channel_to(
    server: Scripted, timeout: float = LONG, bind: str = ""
) -> Iterator[TcpChannel]:
    channel = TcpChannel(*server.address, timeout=timeout, bind=bind)
    try:
        yield channel
    finally:
        channel.close()


def call(channel: TcpChannel, value: int = 7) -> bytes:
    data = channel.begin(set_request(value), REPLY_SIZE)
    channel.end()
    return data


def failure(channel: TcpChannel, value: int = 7) -> int:
    """Return the code of a call that fails."""
    with pytest.raises(ChannelError) as caught:
        channel.begin(set_request(value), REPLY_SIZE)
    return caught.value.sub


def test_calls_share_a_connection() -> None:
    with scripted("answer") as server, channel_to(server) as channel:
        assert [call(channel, value) for value in (1, 2, -3)] == [
            reply(1),
            reply(2),
            reply(-3),
        ]
        assert server.connections == 1


def test_a_oneway_request_waits_for_nothing() -> None:
    with scripted("answer") as server, channel_to(server) as channel:
        assert channel.begin(note_request(3), 0) == b""
        channel.end()
        call(channel)
        assert server.requests == [note_request(3), set_request(7)]


def test_a_reply_is_read_in_the_steps_of_its_layout() -> None:
    with scripted("answer") as server, channel_to(server) as channel:
        assert channel.begin(set_request(258), 3) == REPLY_SOP + b"\0"
        assert channel.more(0) == b""
        assert channel.more(2) == b"\0\1"
        assert channel.more(3) == b"\2" + NOTHING_FOLLOWS
        channel.end()
        call(channel)
        assert server.connections == 1


def test_nobody_listens() -> None:
    channel = TcpChannel("127.0.0.1", free_port(), timeout=SHORT)
    assert failure(channel) == E_OBJ
    assert failure(channel) == E_OBJ


def test_a_server_that_listens_late_is_waited_for() -> None:
    address = "127.0.0.1", free_port()
    channel = TcpChannel(*address, timeout=LONG)
    replies: list[bytes] = []
    caller = threading.Thread(target=lambda: replies.append(call(channel)))
    caller.start()
    time.sleep(0.05)
    with socket.create_server(address) as listener:
        connection, _ = listener.accept()
        with connection:
            assert receive(connection, 10) == set_request(7)
            connection.sendall(reply(7))
            caller.join()
            channel.close()
    assert replies == [reply(7)]


@pytest.mark.parametrize("size", range(REPLY_SIZE))
def test_a_reply_that_is_cut_off(size: int) -> None:
    def cut(connection: socket.socket) -> None:
        receive(connection, 10)
        connection.sendall(reply()[:size])

    with scripted(cut, "answer") as server, channel_to(server) as channel:
        assert failure(channel) == E_BOVR
        assert call(channel, 8) == reply(8)
        assert server.requests == [set_request(8)]


@pytest.mark.parametrize("size", range(10))
def test_a_request_that_nobody_reads_to_its_end(size: int) -> None:
    def leave(connection: socket.socket) -> None:
        receive(connection, size)

    with scripted(leave, "answer") as server, channel_to(server) as channel:
        assert failure(channel) in (E_BOVR, E_OBJ)
        assert call(channel, 8) == reply(8)
        assert server.requests == [set_request(8)]


def test_a_part_of_the_reply_is_missing_for_ever() -> None:
    def stop(connection: socket.socket) -> None:
        receive(connection, 10)
        connection.sendall(reply()[:5])
        rest(connection)

    with scripted(stop, "answer") as server, channel_to(server, MEDIUM) as channel:
        channel.begin(set_request(1), 2)
        with pytest.raises(ChannelError) as caught:
            channel.more(6)
        assert caught.value.sub == E_TMOUT
        channel.reset()
        channel.timeout = LONG
        assert call(channel) == reply(7)


def test_the_time_is_that_of_the_whole_call() -> None:
    def drip(connection: socket.socket) -> None:
        receive(connection, 10)
        while True:
            try:
                connection.sendall(b"\x56")
            except OSError:
                return
            time.sleep(SHORT / 10)

    with scripted(drip, "answer") as server, channel_to(server, MEDIUM) as channel:
        with pytest.raises(ChannelError) as caught:
            channel.begin(set_request(1), 1000)
        assert caught.value.sub == E_TMOUT
        channel.timeout = LONG
        assert call(channel) == reply(7)


def test_a_late_reply_never_answers_the_next_call() -> None:
    late = threading.Event()

    def answer_late(connection: socket.socket) -> None:
        receive(connection, 10)
        late.wait(LONG)
        try:
            connection.sendall(reply(111))
        except ConnectionError:
            return

    with scripted(answer_late, "answer") as server:
        with channel_to(server, MEDIUM) as channel:
            assert failure(channel) == E_TMOUT
            late.set()
            channel.timeout = LONG
            assert [call(channel, value) for value in (1, 2)] == [reply(1), reply(2)]
        assert server.connections == 2


def test_a_peer_that_never_accepts() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        channel = TcpChannel(*listener.getsockname(), timeout=SHORT)
        assert failure(channel) == E_TMOUT
        connection, _ = listener.accept()
        with connection:
            assert rest(connection) == set_request(7)


def test_a_connection_that_was_closed_meanwhile_is_made_anew() -> None:
    closed = threading.Event()

    def once(connection: socket.socket) -> None:
        receive(connection, 10)
        connection.sendall(reply(1))
        connection.close()
        closed.set()

    with scripted(once, "answer") as server, channel_to(server) as channel:
        assert call(channel, 1) == reply(1)
        assert closed.wait(LONG)
        time.sleep(PAUSE)
        assert call(channel, 2) == reply(2)
        assert server.connections == 2


def test_bytes_that_came_meanwhile_are_no_reply() -> None:
    answered, said = threading.Event(), threading.Event()

    def babble(connection: socket.socket) -> None:
        receive(connection, 10)
        connection.sendall(reply(1))
        answered.wait(LONG)
        connection.sendall(reply(111))
        said.set()
        rest(connection)

    with scripted(babble, "answer") as server, channel_to(server) as channel:
        assert call(channel, 1) == reply(1)
        answered.set()
        assert said.wait(LONG)
        time.sleep(PAUSE)
        assert call(channel, 2) == reply(2)


def test_bytes_beyond_the_reply_are_no_reply() -> None:
    def twice(connection: socket.socket) -> None:
        receive(connection, 10)
        connection.sendall(reply(1) + reply(111))
        rest(connection)

    with scripted(twice, "answer") as server, channel_to(server) as channel:
        assert [call(channel, value) for value in (1, 2)] == [reply(1), reply(2)]
        assert server.connections == 2


def test_after_a_reset_the_rest_of_a_reply_is_gone() -> None:
    with scripted("answer") as server, channel_to(server) as channel:
        channel.begin(set_request(1), 2)
        channel.reset()
        assert call(channel, 2) == reply(2)
        assert server.connections == 2


def test_one_call_at_a_time() -> None:
    with scripted("answer") as server, channel_to(server) as channel:
        channel.begin(set_request(1), 2)
        channel.timeout = SHORT
        codes: list[int] = []
        other = threading.Thread(target=lambda: codes.append(failure(channel)))
        other.start()
        other.join()
        assert codes == [E_TMOUT]
        assert channel.more(6) == reply(1)[2:]
        channel.end()
        assert server.requests == [set_request(1)]


def test_calls_of_many_threads_take_turns() -> None:
    with scripted("answer") as server, channel_to(server) as channel:
        answers: dict[int, bytes] = {}

        def work(first: int) -> None:
            for value in range(first, first + 50):
                answers[value] = call(channel, value)

        threads = [threading.Thread(target=work, args=(50 * i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert answers == {value: reply(value) for value in range(200)}
        assert server.connections == 1


def _byte_by_byte(server: Callable[[], Scripted]) -> Callable[[socket.socket], None]:
    def act(connection: socket.socket) -> None:
        while len(request := receive(connection, 10)) == 10:
            server().requests.append(request)
            for byte in REPLY_SOP + request[4:8] + NOTHING_FOLLOWS:
                connection.send(bytes([byte]))

    return act


def test_a_peer_that_writes_byte_by_byte() -> None:
    server: Scripted
    with scripted(_byte_by_byte(lambda: server)) as server:
        with channel_to(server) as channel:
            assert [call(channel, i) for i in range(50)] == list(map(reply, range(50)))
        assert server.connections == 1
        assert len(server.requests) == 50


def test_large_packets() -> None:
    size = 5_000_000

    def mirror(connection: socket.socket) -> None:
        connection.sendall(receive(connection, size))
        rest(connection)

    request = bytes(range(250)) * (size // 250)
    with scripted(mirror) as server, channel_to(server) as channel:
        assert channel.begin(request, 10) == request[:10]
        assert channel.more(size - 20) == request[10:-10]
        assert channel.more(10) == request[-10:]
        channel.end()


def test_a_peer_that_does_not_read() -> None:
    done = threading.Event()
    with scripted(lambda _: done.wait(LONG) and None, "answer") as server:
        with channel_to(server, MEDIUM) as channel:
            with pytest.raises(ChannelError) as caught:
                channel.begin(bytes(50_000_000), REPLY_SIZE)
            assert caught.value.sub == E_TMOUT
            channel.timeout = LONG
            assert call(channel) == reply(7)
        done.set()


def test_closing_ends_a_call_that_hangs() -> None:
    begun = threading.Event()

    def hang(connection: socket.socket) -> None:
        receive(connection, 10)
        begun.set()
        rest(connection)

    with scripted(hang, "answer") as server:
        channel = TcpChannel(*server.address, timeout=LONG)
        codes: list[int] = []
        caller = threading.Thread(target=lambda: codes.append(failure(channel)))
        caller.start()
        assert begun.wait(LONG)
        channel.timeout = SHORT
        channel.close()
        caller.join()
        assert codes == [E_BOVR]
        channel.timeout = LONG
        assert call(channel) == reply(7)
        channel.close()


def test_a_local_address_is_bound() -> None:
    with scripted("answer") as server, channel_to(server, bind="127.0.0.1") as channel:
        assert call(channel) == reply(7)


@pytest.mark.skipif(
    not hasattr(socket, "SO_BINDTODEVICE"), reason="needs SO_BINDTODEVICE (Linux)"
)
def test_an_interface_is_bound() -> None:
    with scripted("answer") as server, channel_to(server, bind="lo") as channel:
        assert call(channel) == reply(7)


@pytest.mark.parametrize("bind", ["203.0.113.7", "no-such-nic"])
def test_what_cannot_be_bound_is_reported(bind: str) -> None:
    with scripted("answer") as server, channel_to(server, bind=bind) as channel:
        assert failure(channel) == E_OBJ


def test_a_host_that_is_unknown() -> None:
    assert failure(TcpChannel("no..host", 1, timeout=SHORT)) == E_OBJ


@pytest.mark.parametrize("timeout", [0, -1, float("inf"), float("nan")])
def test_time_outs_are_finite(timeout: float) -> None:
    with pytest.raises(ValueError, match="positive"):
        TcpChannel("127.0.0.1", 1, timeout=timeout)


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_ports_have_16_bits(port: int) -> None:
    with pytest.raises(ValueError, match="1 to 65535"):
        TcpChannel("127.0.0.1", port)


def test_more_without_a_call() -> None:
    with pytest.raises(ChannelError, match="no call"):
        TcpChannel("127.0.0.1", 1).more(1)
