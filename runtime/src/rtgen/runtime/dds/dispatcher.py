"""A thread that waits for the conditions of readers and writers and calls their handlers.

cyclonedds's listeners are not used: they run in the receiving threads, which must neither wait for
Python, nor write.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from itertools import count
from typing import Any

import msgspec
from cyclonedds.core import Entity, GuardCondition, WaitSet
from cyclonedds.domain import DomainParticipant

from rtgen.runtime.failures import log

_NO_TIMEOUT = (1 << 63) - 1
_MAX_CONDITIONS = 64
"""Maximum number of conditions that one wait reports."""


class Dispatcher:
    """Calls handlers in a thread of its own; the first one added starts it."""

    def __init__(self, participant: DomainParticipant, name: str) -> None:
        self._set = WaitSet(participant)
        self._wake = GuardCondition(participant)
        self._entries: dict[int, Entry] = {}
        self._numbers = count(1)
        self._closed = False
        self._attach(self._wake, 0)
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def add(self, condition: Entity, handler: Callable[[], None]) -> Entry:
        """Call the handler whenever the condition is true. The handler must make it false."""
        number = next(self._numbers)
        entry = Entry(self, number, condition, handler)
        self._entries[number] = entry
        self._attach(condition, number)
        if not self._thread.is_alive():
            self._thread.start()
        return entry

    def close(self) -> None:
        """End the thread."""
        self._closed = True
        self._wake.set(True)
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join()

    def _attach(self, condition: Any, number: int) -> None:
        self._set._waitset_attach(
            self._set._ref, condition._ref, ctypes.c_void_p(number)
        )

    def _remove(self, entry: Entry) -> None:
        if self._entries.pop(entry.number, None) is not None:
            self._set._waitset_detach(self._set._ref, entry.condition._ref)

    def _run(self) -> None:
        triggered = (ctypes.c_void_p * _MAX_CONDITIONS)()
        while not self._closed:
            number = self._set._waitset_wait(
                self._set._ref, triggered, _MAX_CONDITIONS, _NO_TIMEOUT
            )
            for place in range(min(number, _MAX_CONDITIONS)):
                entry = self._entries.get(triggered[place] or 0)
                if entry is not None:
                    entry.call()


class Entry(msgspec.Struct, eq=False):
    """A condition with its handler, which is not called after `close`."""

    _dispatcher: Dispatcher
    number: int
    condition: Any
    _handler: Callable[[], None]
    _lock: threading.RLock = msgspec.field(default_factory=threading.RLock)
    _closed: bool = False

    def call(self) -> None:
        """Call the handler, unless closed. An exception is logged: the thread serves others."""
        with self._lock:
            if self._closed:
                return
            try:
                self._handler()
            except Exception:
                log.exception("a message cannot be handled")

    def close(self) -> None:
        """Wait for the running call; call no more."""
        self._dispatcher._remove(self)
        with self._lock:
            self._closed = True
