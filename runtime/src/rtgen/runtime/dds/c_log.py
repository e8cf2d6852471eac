"""The log of Cyclone DDS's C library as messages of the runtime's log.

A domain logs to what C's `stderr` is when it is created, and errors in configurations go to what
it was when a domain was deleted: here a pipe that a thread reads. The library cannot be given a
function of Python, since its receiving threads must not wait for Python's lock.
"""

from __future__ import annotations

import ctypes
import os
import re
import sys
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import cache
from typing import Any, Final

from rtgen.runtime.failures import log

_SYMBOLS: Final = {"linux": "stderr", "darwin": "__stderrp"}
"""C's variable by platform; on others the log stays where it is."""
_HEAD: Final = re.compile(r"\d+\.\d+ \[\d*\]\s+[^:]*: ")
_NUMBERS: Final = re.compile(r"#\d+|[0-9a-f:]*\d[0-9a-f:]*")
_OF_SERVICES: Final = re.compile(r"deserialization r[qr]/\S+ failed")
"""Requests and responses of ROS 2 in another form, whose senders `ros2.dds_ends` reports."""
_MAX_REPORTED: Final = 32
_MAX_LINE: Final = 1 << 16
_DONE: Final = b"\0\n"
"""A line that the library does not write."""


def logged() -> AbstractContextManager[list[str]]:
    """Let the domain that is created in the context log here.

    The context's list gets the messages of the creation, if that raises an exception.
    """
    c_log = _log()
    return nullcontext([]) if c_log is None else c_log.creation()


def closing() -> AbstractContextManager[None]:
    """Let what is logged after the domain that is deleted in the context be logged here, too.

    The library then goes back to what C's `stderr` is, for the next errors in configurations.
    """
    c_log = _log()
    return nullcontext() if c_log is None else c_log.exchanged()


@cache
def _log() -> _Log | None:
    symbol = _SYMBOLS.get(sys.platform)
    with suppress(OSError, ValueError, AttributeError):
        return None if symbol is None else _Log(symbol)
    return None


class _Log:
    """The pipe of this process; one domain is created at a time."""

    def __init__(self, symbol: str) -> None:
        libc: Any = ctypes.CDLL(None)
        self._stderr = ctypes.c_void_p.in_dll(libc, symbol)
        self._read, self._write = os.pipe()
        # A full pipe loses messages; the threads of the library do not wait.
        os.set_blocking(self._write, False)
        libc.fdopen.restype = ctypes.c_void_p
        libc.fdopen.argtypes = (ctypes.c_int, ctypes.c_char_p)
        self._file = libc.fdopen(self._write, b"w")
        self._creating: list[str] | None = None
        self._read_all = threading.Event()
        self._kinds: set[str] = set()
        threading.Thread(
            target=self._run, name="log of Cyclone DDS", daemon=True
        ).start()

    @contextmanager
    def creation(self) -> Iterator[list[str]]:
        """See `logged`."""
        messages: list[str] = []
        self._creating = messages
        try:
            with self.exchanged():
                yield messages
        finally:
            self._end_creation()
        for message in messages:
            self._report(message)

    @contextmanager
    def exchanged(self) -> Iterator[None]:
        """Let C's `stderr` be the pipe meanwhile."""
        before, self._stderr.value = self._stderr.value, self._file
        try:
            yield
        finally:
            self._stderr.value = before

    def _end_creation(self) -> None:
        """Wait for the messages of a creation."""
        self._read_all.clear()
        with suppress(BlockingIOError):
            os.write(self._write, _DONE)
            self._read_all.wait()
        self._creating = None

    def _run(self) -> None:
        rest = b""
        while octets := os.read(self._read, _MAX_LINE):
            *lines, rest = (rest + octets).split(b"\n")
            rest = rest[-_MAX_LINE:]
            for line in lines:
                if line == _DONE.rstrip():
                    self._read_all.set()
                    continue
                message = _HEAD.sub("", line.decode("utf-8", "replace"), count=1)
                if self._creating is not None:
                    self._creating.append(message)
                else:
                    self._report(message)

    def _report(self, message: str) -> None:
        """Log a message; for debugging only, if one differed from it in numbers only."""
        kind = _NUMBERS.sub("", message)
        if (
            kind in self._kinds
            or len(self._kinds) >= _MAX_REPORTED
            or _OF_SERVICES.search(message)
        ):
            log.debug("Cyclone DDS: %s", message)
            return
        self._kinds.add(kind)
        log.warning("Cyclone DDS: %s", message)
