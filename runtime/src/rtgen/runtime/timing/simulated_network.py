"""The network of a system in simulated time.

It replaces sockets and serial lines. Octets go through a socket pair, and the listening end is
served inside the other end's `send`: there are no threads, nothing blocks, and a run is
deterministic.
"""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Callable
from typing import TypeAlias, TypeVar

from rtgen.runtime.timing.instants import SimulatedTime

_CHUNK = 65536


class Stream:
    """One end of a connection. It never blocks: missing data raise TimeoutError."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end = end
        self._peer: Stream | None = None
        self._unsent = bytearray()
        self.on_data: Callable[[], None] | None = None
        """Called inside `send` and `close` of the other end, when data have arrived."""

    def send(self, data: bytes) -> None:
        """Send all data; the rest that a socket cannot hold is sent when the other end reads."""
        self._unsent += data
        self._push()
        waiting = -1
        while waiting != len(self._unsent):
            waiting = len(self._unsent)
            self._wake_peer()
            self._push()

    def take(self, size: int) -> bytes:
        """Return received data, at most `size` octets; empty at the end of the stream."""
        if self._peer is not None and self._peer._unsent:
            self._peer._push()
        try:
            return self._end.recv(size)
        except BlockingIOError:
            raise TimeoutError("nothing has arrived") from None
        except OSError:
            return b""

    def receive(self, size: int) -> bytes:
        """Return exactly `size` bytes."""
        pieces = []
        while size > 0:
            piece = self.take(min(size, _CHUNK))
            if not piece:
                raise EOFError("the stream ended")
            pieces.append(piece)
            size -= len(piece)
        return b"".join(pieces)

    @property
    def stale(self) -> bool:
        """Whether the stream has ended, or contains unread octets."""
        try:
            self._end.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return False
        except OSError:
            return True
        return True

    def close(self) -> None:
        """Close the connection; the other end sees the end of the stream."""
        self.on_data = None
        self._unsent.clear()
        self._end.close()
        self._wake_peer()

    def _push(self) -> None:
        try:
            while self._unsent:
                del self._unsent[: self._end.send(self._unsent)]
        except BlockingIOError:
            return
        except OSError:
            self._unsent.clear()
            raise

    def _wake_peer(self) -> None:
        if self._peer is not None and self._peer.on_data is not None:
            self._peer.on_data()


Accept: TypeAlias = Callable[[Stream], bool]
"""Function that accepts the listening end of a new connection; False rejects it."""


class Listener:
    """An address at which a component listens, until `close`."""

    def __init__(self, listeners: dict[str, Listener], address: str, accept: Accept):
        self._listeners = listeners
        self._address = address
        self.accept = accept
        self._listeners[address] = self

    def close(self) -> None:
        """Free the address."""
        if self._listeners.get(self._address) is self:
            del self._listeners[self._address]


D = TypeVar("D")


class SimulatedNetwork:
    """Listeners by address, and named devices such as buses.

    An address is any text: `127.0.0.1:8931`, or the name of a device.
    """

    def __init__(self, clock: SimulatedTime) -> None:
        self.clock = clock
        self._listeners: dict[str, Listener] = {}
        self._devices: dict[tuple[type[object], str], object] = {}

    def device(self, kind: type[D], name: str, make: Callable[[], D]) -> D:
        """Return the device of that kind and name, created at the first call."""
        device = self._devices.get((kind, name))
        if not isinstance(device, kind):
            device = self._devices[kind, name] = make()
        return device

    def listen(self, address: str, accept: Accept) -> Listener:
        """Listen at an address. Raises OSError (EADDRINUSE) if it is in use."""
        if address in self._listeners:
            code = errno.EADDRINUSE
            raise OSError(code, os.strerror(code), address)
        return Listener(self._listeners, address, accept)

    def connect(self, address: str) -> Stream:
        """Connect to the listener of an address. Raises ConnectionRefusedError without one."""
        listener = self._listeners.get(address)
        near, far = (Stream(end) for end in socket.socketpair())
        near._peer, far._peer = far, near
        if listener is None or not listener.accept(far):
            near.close()
            far.close()
            raise ConnectionRefusedError(f"nobody listens at {address}")
        return near
