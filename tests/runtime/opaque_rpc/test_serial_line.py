"""Calls over pseudo terminals: noise, cut messages, silence, and resynchronization."""

from __future__ import annotations

import errno
import logging
import os
import random
import select
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest
from peers import (
    REPLY_SIZE,
    Board,
    load_request,
    note_request,
    reply,
    set_request,
)
from seeds import cases

from rtgen.runtime.opaque_rpc import (
    E_OBJ,
    E_TMOUT,
    ChannelError,
    SerialChannel,
    SerialServer,
    SharedChannel,
    SharedUnmarshaller,
)
from rtgen.runtime.opaque_rpc.errors import RpcError
from rtgen.runtime.opaque_rpc.messages import log
from rtgen.runtime.opaque_rpc.serial import silence

pytestmark = pytest.mark.waits

tty = pytest.importorskip("tty", reason="pseudo terminals are POSIX")
termios = pytest.importorskip("termios", reason="pseudo terminals are POSIX")

LONG, SHORT = 20.0, 0.1
PAUSE = 0.05
"""Longer than the silence that ends an error at this rate."""
RATE = 115200


class Terminal:
    """A pseudo terminal: the device's name, and the far end of the line."""

    def __init__(self) -> None:
        self.far, self._near = os.openpty()
        tty.setraw(self._near)
        self.device = os.ttyname(self._near)

    def write(self, data: bytes) -> None:
        os.write(self.far, data)

    def read(self, size: int, seconds: float = LONG) -> bytes:
        """Return `size` bytes; fewer after the time-out."""
        data = b""
        end = time.monotonic() + seconds
        while len(data) < size:
            left = max(end - time.monotonic(), 0.0)
            if not select.select([self.far], [], [], left)[0]:
                break
            data += os.read(self.far, size - len(data))
        return data

    def close(self) -> None:
        os.close(self.far)
        os.close(self._near)


@pytest.fixture
def line() -> Iterator[Terminal]:
    """Yield a line whose far end the test controls."""
    terminal = Terminal()
    yield terminal
    terminal.close()


@pytest.fixture
def cable() -> Iterator[tuple[Terminal, Terminal]]:
    """Yield two terminals that are connected."""
    ends = (Terminal(), Terminal())
    stop, alarm = os.pipe()
    other = {ends[0].far: ends[1].far, ends[1].far: ends[0].far}

    def copy() -> None:
        while True:
            ready, _, _ = select.select([*other, stop], [], [])
            if stop in ready:
                return
            for far in ready:
                os.write(other[far], os.read(far, 4096))

    thread = threading.Thread(target=copy)
    thread.start()
    yield ends
    os.close(alarm)
    thread.join()
    os.close(stop)
    for end in ends:
        end.close()


@pytest.fixture
def silent_again() -> Iterator[threading.Event]:
    """Yield an event that is set when a server has waited for silence after an error."""
    event = threading.Event()

    class Listener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if "silent again" in record.getMessage():
                event.set()

    listener = Listener()
    level = log.level
    log.addHandler(listener)
    log.setLevel(logging.INFO)
    yield event
    log.removeHandler(listener)
    log.setLevel(level)


@contextmanager
def channel_on(terminal: Terminal, timeout: float = LONG) -> Iterator[SerialChannel]:
    channel = SerialChannel(terminal.device, RATE, timeout)
    try:
        yield channel
    finally:
        channel.close()


@contextmanager
def serving(
    terminal: Terminal, board: Board, timeout: float = LONG, allocator_size: int = 4096
) -> Iterator[SerialServer]:
    with SerialServer(board, terminal.device, RATE, timeout, allocator_size) as server:
        yield server


def call(channel: SerialChannel, value: int = 7) -> bytes:
    data = channel.begin(set_request(value), REPLY_SIZE)
    channel.end()
    return data


def unanswered(terminal: Terminal, channel: SerialChannel, value: int) -> None:
    """Send a request that has no answer; in a slow process a call may end before it is sent."""
    sent = False
    while not sent:
        with pytest.raises(ChannelError) as caught:
            channel.begin(set_request(value), REPLY_SIZE)
        assert caught.value.sub == E_TMOUT
        sent = terminal.read(10, PAUSE) == set_request(value)


def far_answers(terminal: Terminal, *answers: bytes) -> threading.Thread:
    """Answer each request at the far end, with noise or truncated replies on request."""

    def run() -> None:
        for answer in answers:
            terminal.read(10)
            terminal.write(answer)

    thread = threading.Thread(target=run)
    thread.start()
    return thread


def test_silence_is_20_ms_or_30_characters() -> None:
    assert silence(115200) == 0.02
    assert silence(9600) == 300 / 9600


def test_channel_and_server(cable: tuple[Terminal, Terminal]) -> None:
    board = Board()
    here, there = cable
    with serving(there, board), channel_on(here) as channel:
        for value in range(20):
            assert call(channel, value) == reply(value)
        assert channel.begin(note_request(3), 0) == b""
        channel.end()
        data = bytes(range(256)) * 10
        assert channel.begin(load_request(data), 2) == reply(2560)[:2]
        assert channel.more(6) == reply(2560)[2:]
        channel.end()
    assert board.calls == [
        *(("set", value) for value in range(20)),
        ("note", 3),
        ("load", data),
    ]


@pytest.mark.parametrize("noise", [b"\0\xff", b"\x56", b"\x56\x56", b"\xff" * 5000])
def test_noise_before_a_reply(line: Terminal, noise: bytes) -> None:
    with channel_on(line) as channel:
        far = far_answers(line, noise + reply(7), reply(8))
        assert call(channel) == reply(7)
        assert call(channel, 8) == reply(8)
        far.join()


def test_what_came_before_a_request_is_no_reply(line: Terminal) -> None:
    with channel_on(line) as channel:
        far = far_answers(line, reply(1), reply(2))
        assert call(channel, 1) == reply(1)
        line.write(reply(111))
        assert call(channel, 2) == reply(2)
        far.join()


def test_bytes_beyond_a_reply_are_discarded(line: Terminal) -> None:
    with channel_on(line) as channel:
        far = far_answers(line, reply(1) + reply(111), reply(2))
        assert [call(channel, value) for value in (1, 2)] == [reply(1), reply(2)]
        far.join()


@pytest.mark.parametrize("size", range(REPLY_SIZE))
def test_a_reply_that_is_cut_off(line: Terminal, size: int) -> None:
    with channel_on(line, SHORT) as channel:
        far = far_answers(line, reply()[:size])
        with pytest.raises(ChannelError) as caught:
            channel.begin(set_request(7), REPLY_SIZE)
        assert caught.value.sub == E_TMOUT
        far.join()
        channel.timeout = LONG
        far = far_answers(line, reply(8))
        assert call(channel, 8) == reply(8)
        far.join()


def test_a_late_reply_never_answers_the_next_call(line: Terminal) -> None:
    with channel_on(line, SHORT) as channel:
        unanswered(line, channel, 1)
        line.write(reply(111))
        channel.timeout = LONG
        far = far_answers(line, reply(2))
        assert call(channel, 2) == reply(2)
        far.join()


def test_a_line_that_never_falls_silent(line: Terminal) -> None:
    stop = threading.Event()

    def babble() -> None:
        while not stop.wait(0.002):
            line.write(b"\xff")

    thread = threading.Thread(target=babble)
    with channel_on(line, 2 * SHORT) as channel:
        unanswered(line, channel, 1)
        thread.start()
        with pytest.raises(ChannelError) as caught:
            channel.begin(set_request(2), REPLY_SIZE)
        assert caught.value.sub == E_TMOUT
        stop.set()
        thread.join()
        # A thread that did not run for 20 ms left the line silent, and request 2 was sent.
        assert line.read(10, 0.0) in (b"", set_request(2))
        far = far_answers(line, reply(3))
        channel.timeout = LONG
        assert call(channel, 3) == reply(3)
        far.join()
        assert line.read(1, 0.0) == b""


@pytest.mark.parametrize(
    "noise",
    [b"\0", b"\xff\x67", b"\x67\x67", b"\x2a\x67\x56\x1e", b"\xff" * 5000],
    ids=len,
)
def test_noise_before_a_request(line: Terminal, noise: bytes) -> None:
    board = Board()
    with serving(line, board):
        line.write(noise + set_request(1))
        assert line.read(REPLY_SIZE) == reply(1)
        line.write(set_request(2))
        assert line.read(REPLY_SIZE) == reply(2)
    assert board.calls == [("set", 1), ("set", 2)]


@pytest.mark.parametrize(
    "bad",
    [
        set_request(1)[:-2] + b"\0\0",
        b"\x67\x2a\0\x63\x5a\x3c",
        load_request(b"", -1),
        load_request(bytes(9), 2**31 - 1),
    ],
    ids=lambda request: request.hex(),
)
def test_after_a_bad_request_the_server_waits_for_silence(
    line: Terminal, bad: bytes, silent_again: threading.Event
) -> None:
    board = Board()
    with serving(line, board):
        line.write(bad + set_request(111))
        assert silent_again.wait(LONG)
        line.write(set_request(2))
        assert line.read(REPLY_SIZE) == reply(2)
        assert line.read(1, PAUSE) == b""
    assert board.calls == [("set", 2)]


@pytest.mark.parametrize("size", range(1, 10))
def test_a_request_that_is_cut_off(
    line: Terminal, size: int, silent_again: threading.Event
) -> None:
    board = Board()
    with serving(line, board, timeout=PAUSE):
        line.write(set_request(1)[:size])
        assert silent_again.wait(LONG)
        line.write(set_request(2))
        assert line.read(REPLY_SIZE) == reply(2)
    assert board.calls == [("set", 2)]


def test_a_target_that_fails(line: Terminal, silent_again: threading.Event) -> None:
    board = Board()
    board.failing = True
    with serving(line, board):
        line.write(set_request(1))
        assert silent_again.wait(LONG)
        board.failing = False
        line.write(set_request(2))
        assert line.read(REPLY_SIZE) == reply(2)
    assert board.calls == [("set", 1), ("set", 2)]


def damaged(drawn: random.Random, whole: bytes) -> bytes:
    """Return octets that are not a message, or a message with noise, cut off or changed."""
    at = drawn.randrange(len(whole))
    match drawn.randrange(6):
        case 0:
            return drawn.randbytes(drawn.choice((1, 2, 3, 50, 5000)))
        case 1:
            return whole[:at]
        case 2:
            return whole[:at] + drawn.randbytes(1) + whole[at + 1 :]
        case 3:
            return whole[:at] + drawn.randbytes(drawn.randrange(1, 9)) + whole[at:]
        case 4:
            return whole[:2] * drawn.randrange(1, 300)
    return load_request(b"", drawn.choice((-1, 4097, 2**31 - 1)))


@pytest.mark.random
@pytest.mark.parametrize("case", cases(6))
def test_a_server_goes_on_after_any_garbage(line: Terminal, case: int) -> None:
    drawn = random.Random(case)
    whole = (set_request(7), load_request(bytes(99)))
    over = threading.Event()
    with serving(line, Board(), timeout=PAUSE):

        def read() -> None:
            while not over.is_set():
                line.read(4096, 0.01)

        reading = threading.Thread(target=read)
        reading.start()
        for _ in range(drawn.randrange(1, 6)):
            line.write(damaged(drawn, drawn.choice(whole)))
            if drawn.random() < 0.3:
                termios.tcsendbreak(line.far, 0)
        over.set()
        reading.join()
        # The first ones may be read as the rest of a damaged one.
        answers, number = b"", 1
        while not answers.endswith(reply(number)):
            number += 1
            line.write(set_request(number))
            answers = answers[-99:] + line.read(4096, 2 * number * PAUSE)
        line.write(set_request(0))
        assert line.read(REPLY_SIZE) == reply(0)


@pytest.mark.random
@pytest.mark.parametrize("case", cases(6))
def test_a_caller_goes_on_after_any_garbage(line: Terminal, case: int) -> None:
    drawn = random.Random(case)
    with channel_on(line, PAUSE) as channel:
        for _ in range(3):
            far = far_answers(line, damaged(drawn, reply(7)))
            with suppress(RpcError):
                call(channel)
            far.join()
        channel.reset()
        channel.timeout = LONG
        line.read(4096, 0.0)
        far = far_answers(line, reply(8))
        assert call(channel, 8) == reply(8)
        far.join()


def test_several_signatures_on_a_line(cable: tuple[Terminal, Terminal]) -> None:
    boards = [Board(), Board()]
    here, there = cable
    shared = SharedUnmarshaller(boards, "big")
    with SerialServer(shared, there.device, RATE, LONG), channel_on(here) as line:
        for number in (0, 1, 1):
            channel = SharedChannel(line, number, "big")
            assert channel.begin(set_request(number), REPLY_SIZE) == reply(number)
            channel.end()
        channel = SharedChannel(line, 0, "big")
        assert channel.begin(note_request(5), 0) == b""
        channel.end()
        assert boards[0].noted.wait(LONG)
    assert boards[0].calls == [("set", 0), ("note", 5)]
    assert boards[1].calls == [("set", 1), ("set", 1)]


def test_a_device_that_is_not_there() -> None:
    channel = SerialChannel("/dev/no-such-device", RATE, SHORT)
    expected = f"^/dev/no-such-device: {os.strerror(errno.ENOENT)} "
    with pytest.raises(ChannelError, match=expected) as caught:
        channel.begin(set_request(1), REPLY_SIZE)
    assert caught.value.sub == E_OBJ
    with pytest.raises(ChannelError, match="no-such-device"):
        SerialServer(Board(), "/dev/no-such-device")


def test_a_device_is_not_shared(line: Terminal) -> None:
    with serving(line, Board()), pytest.raises(ChannelError, match="in use") as caught:
        SerialServer(Board(), line.device)
    assert caught.value.sub == E_OBJ


def test_a_device_that_is_pulled_out() -> None:
    terminal = Terminal()
    channel = SerialChannel(terminal.device, RATE, SHORT)
    far = far_answers(terminal, reply(1))
    assert call(channel, 1) == reply(1)
    far.join()
    terminal.close()
    for _ in range(2):
        with pytest.raises(ChannelError) as caught:
            channel.begin(set_request(1), REPLY_SIZE)
        assert caught.value.sub == E_OBJ
    channel.close()


def test_pyserial_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    channel = SerialChannel("/dev/ttyS0")
    with pytest.raises(ChannelError, match=r"'\.\[serial\]'"):
        channel.begin(set_request(1), REPLY_SIZE)
