"""Time limits of sockets without the poll() that `settimeout` adds to each call; lack of files."""

from __future__ import annotations

import errno
import socket
import struct
import sys
import time
from typing import Final

TIME_OVER: Final = (BlockingIOError, TimeoutError)
"""Exceptions raised by a send or receive on time-out."""

_NATIVE_TIMES: Final = sys.platform in ("linux", "darwin")
"""Whether SO_RCVTIMEO takes a timeval."""
_MIN_SECONDS: Final = 1e-6
"""Seconds; a limit of 0 means none."""
_NO_FILES: Final = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)
_PAUSE: Final = 0.1
"""Time after which a client without a file is accepted again [s]."""


def await_files(error: OSError) -> None:
    """Wait a moment if a client was not accepted since there were no more files.

    The client is still there, and another thread may close a file.
    """
    if error.errno in _NO_FILES:
        time.sleep(_PAUSE)


def limit_times(connection: socket.socket, seconds: float) -> None:
    """Limit the time of each send and receive; TIME_OVER is raised on time-out."""
    limit_receives(connection, seconds)
    if _NATIVE_TIMES:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _interval(seconds))


def limit_receives(connection: socket.socket, seconds: float) -> None:
    """Limit the time of receives; on some systems also that of sends."""
    if _NATIVE_TIMES:
        connection.settimeout(None)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, _interval(seconds))
    else:
        connection.settimeout(max(seconds, _MIN_SECONDS))


def _interval(seconds: float) -> bytes:
    whole, part = divmod(max(int(seconds * 1e6), 1), 1_000_000)
    return struct.pack("@ll", whole, part)
