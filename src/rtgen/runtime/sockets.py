"""Time limits of sockets, without the poll() that `settimeout` puts before each call."""

from __future__ import annotations

import socket
import struct
import sys
from typing import Final

TIME_OVER: Final = (BlockingIOError, TimeoutError)
"""Exceptions raised by a send or receive on time-out."""

_NATIVE_TIMES: Final = sys.platform in ("linux", "darwin")
"""Whether SO_RCVTIMEO takes a timeval."""
_LEAST: Final = 1e-6
"""Seconds; a limit of 0 means none."""


def limit_times(connection: socket.socket, seconds: float) -> None:
    """Let each send and receive take no longer than that; then they raise `TIME_OVER`."""
    limit_receives(connection, seconds)
    if _NATIVE_TIMES:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _interval(seconds))


def limit_receives(connection: socket.socket, seconds: float) -> None:
    """Like `limit_times`, for receives; where the system limits both together, for both."""
    if _NATIVE_TIMES:
        connection.settimeout(None)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, _interval(seconds))
    else:
        connection.settimeout(max(seconds, _LEAST))


def _interval(seconds: float) -> bytes:
    whole, part = divmod(max(int(seconds * 1e6), 1), 1_000_000)
    return struct.pack("@ll", whole, part)
