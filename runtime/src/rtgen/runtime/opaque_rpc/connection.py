"""A TCP connection with limited times, for both ends."""

from __future__ import annotations

import socket
from time import monotonic

from rtgen.runtime.opaque_rpc.messages import log
from rtgen.runtime.sockets import limit_times

SMALL_BLOCK = 448
BLOCK = 65536
"""Minimum and maximum number of octets requested by a read that likely returns few.

Small blocks come from Python's own allocator, which is faster.
"""
_QUICKACK: int | None = getattr(socket, "TCP_QUICKACK", None)
_KEEP_ALIVE = {"TCP_KEEPIDLE": 5, "TCP_KEEPINTVL": 2, "TCP_KEEPCNT": 3}


def _prepare(connection: socket.socket) -> None:
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _KEEP_ALIVE.items():
        if hasattr(socket, name):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


class Connection:
    """A socket with its current time limit."""

    def __init__(self, connection: socket.socket, seconds: float) -> None:
        _prepare(connection)
        self.socket = connection
        self.send = connection.send
        self.receive = connection.recv
        self.seconds = 0.0
        self.limit(seconds)

    def limit(self, seconds: float) -> None:
        """Limit the time of each send and receive."""
        if seconds <= 0:
            raise TimeoutError("time is over")
        if seconds != self.seconds:
            limit_times(self.socket, seconds)
            self.seconds = seconds

    def send_all(self, data: bytes, deadline: float, sent: int = 0) -> None:
        """Send the bytes after the first `sent`."""
        view = memoryview(data)
        while sent < len(data):
            self.limit(deadline - monotonic())
            sent += self.send(view[sent:])

    def acknowledge(self) -> None:
        """Acknowledge received data immediately.

        A peer that writes each scalar separately, with Nagle's algorithm on, waits for that.
        """
        if _QUICKACK is not None:
            self.socket.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)

    def is_quiet(self) -> bool:
        """Return whether the connection is open and no bytes wait to be read."""
        self.socket.setblocking(False)
        self.seconds = 0.0
        try:
            self.receive(1, socket.MSG_PEEK)
        except BlockingIOError:
            return True
        except OSError as error:
            log.debug("connection lost: %s", error)
        return False

    def shut(self) -> None:
        """Shut the connection down; a thread that waits for it wakes up, and must close it."""
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError as error:
            log.debug("shutdown: %s", error)

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()
