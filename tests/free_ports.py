"""Ports for servers of tests that are started later, or by other processes."""

from __future__ import annotations

import atexit
import socket
from collections.abc import Iterator
from functools import cache
from itertools import cycle

_ALL = range(10_000, 20_000)
"""Below those that systems give to sockets without a port of their own."""
_BLOCK = 100


def free_port() -> int:
    """Return a free port of the loopback interface.

    Neither the system nor another process of these tests takes it until it is used.
    """
    return next(port for port in _own() if _is_free(port))


@cache
def _own() -> Iterator[int]:
    """Return the ports of this process in turn; the one before them is held until its end."""
    for first in _ALL[::_BLOCK]:
        held = socket.socket()
        try:
            held.bind(("127.0.0.1", first))
        except OSError:
            held.close()
            continue
        atexit.register(held.close)
        return cycle(range(first + 1, first + _BLOCK))
    raise AssertionError("all ports are in use")


def _is_free(port: int) -> bool:
    with socket.socket() as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True
