"""Peers for channels and servers: a hand-written board of three functions, and scripted servers.

The board, in network order: 1 `ER set([in] int32_t)`, 2 `oneway void note([in] int32_t)`, 3 `ER
load([in] int32_t n, [in,size_is(n)] const uint8_t *data)`.
"""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rtgen.runtime.opaque_rpc import E_MAGIC, E_PAR, ProtocolError
from rtgen.runtime.opaque_rpc.channel import Handlers, More

TWO_WAY, NOTHING_FOLLOWS = b"\x5a\x3c", b"\x6d\x5e"
SOP, REPLY_SOP = b"\x67\x2a", b"\x56\x1e"
REPLY_SIZE = 8


def set_request(value: int) -> bytes:
    return SOP + struct.pack(">hi", 1, value) + TWO_WAY


def note_request(value: int) -> bytes:
    return SOP + struct.pack(">hi", 2, value) + NOTHING_FOLLOWS


def load_request(data: bytes, size: int | None = None) -> bytes:
    size = len(data) if size is None else size
    return SOP + struct.pack(">hi", 3, size) + data + TWO_WAY


def reply(value: int = 0) -> bytes:
    return REPLY_SOP + struct.pack(">i", value) + NOTHING_FOLLOWS


class Board:
    """Executes calls and keeps a list of them. `set` returns its argument."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, int | bytes]] = []
        self.noted = threading.Event()
        self.failing = False

    @property
    def handlers(self) -> Handlers:
        return {
            SOP + b"\0\1": self._set,
            SOP + b"\0\2": self._note,
            SOP + b"\0\3": self._load,
        }

    def _set(self, more: More) -> bytes:
        value, end = struct.unpack(">i2s", more(6))
        _expect(end, TWO_WAY)
        self.calls.append(("set", value))
        if self.failing:
            raise RuntimeError("the motor is gone")
        return reply(value)

    def _note(self, more: More) -> None:
        value, end = struct.unpack(">i2s", more(6))
        _expect(end, NOTHING_FOLLOWS)
        self.calls.append(("note", value))
        self.noted.set()

    def _load(self, more: More) -> bytes:
        (size,) = struct.unpack(">i", more(4))
        if size < 0:
            raise ProtocolError(E_PAR, f"a size of {size}")
        data = more(size)
        _expect(more(2), TWO_WAY)
        self.calls.append(("load", data))
        return reply(size)


def _expect(found: bytes, magic: bytes) -> None:
    if found != magic:
        raise ProtocolError(E_MAGIC, f"{found.hex()} at the end of a request")


def receive(connection: socket.socket, size: int) -> bytes:
    """Return `size` bytes; fewer at the end of the stream, or after a reset."""
    data = b""
    while len(data) < size:
        try:
            piece = connection.recv(min(size - len(data), 65536))
        except ConnectionError:
            break
        if not piece:
            break
        data += piece
    return data


def rest(connection: socket.socket) -> bytes:
    """Return all bytes until the end of the stream."""
    return receive(connection, 1 << 30)


Act = Callable[[socket.socket], None]


class Scripted:
    """A scripted TCP server: each connection is handled by the next act; the last one repeats.

    `requests` has the requests read by `answer` acts.
    """

    def __init__(self, *acts: Act) -> None:
        self._acts = list(acts)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address: tuple[str, int] = self._listener.getsockname()
        self.connections = 0
        self._closed = False
        self.requests: list[bytes] = []
        self._open: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while True:
            connection, _ = self._listener.accept()
            if self._closed:
                connection.close()
                break
            act = self._acts[min(self.connections, len(self._acts) - 1)]
            self.connections += 1
            self._open.append(connection)
            thread = threading.Thread(target=self._act, args=(act, connection))
            self._threads.append(thread)
            thread.start()

    def _act(self, act: Act, connection: socket.socket) -> None:
        with connection:
            act(connection)

    def close(self) -> None:
        self._closed = True
        socket.create_connection(self.address).close()
        self._thread.join()
        self._listener.close()
        for connection in self._open:
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:  # closed by its act or by the peer
                continue
        for thread in self._threads:
            thread.join()

    def answer(self, connection: socket.socket) -> None:
        """Read requests to `set` and `note`; reply to two-way ones."""
        while len(request := receive(connection, 10)) == 10:
            self.requests.append(request)
            if request.endswith(TWO_WAY):
                connection.sendall(REPLY_SOP + request[4:8] + NOTHING_FOLLOWS)


@contextmanager
def scripted(*acts: Act | str) -> Iterator[Scripted]:
    """Yield a scripted server; the text `answer` stands for the act of that name."""
    server = Scripted()
    server._acts = [server.answer if isinstance(act, str) else act for act in acts]
    try:
        yield server
    finally:
        server.close()
