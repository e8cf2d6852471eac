"""Threads that execute the requests of other processes: those of each client in turn."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from rtgen.runtime.requests import Queues, Requests, await_turn, charge

_MAX_THREADS = 32
_MAX_BUSY = 8
"""Maximum number of threads that execute requests of one client.

A client that waits for its answers has one request at a time; those of one that does not would
leave the components of the process little time.
"""
_MAX_WAITING = 1024
"""Maximum number of waiting requests; more are refused."""
_MAX_OF_CLIENT = 64
"""Maximum number of those of one client."""
_PATIENCE = 60.0
_CONVERSION = 2e-4
"""Time in which an engine reads a request and writes its answer [s]."""


class Workers:
    """Threads that execute requests; a single thread keeps the order of each client."""

    def __init__(self, threads: int = _MAX_THREADS) -> None:
        self._pool = ThreadPoolExecutor(threads, "rtgen call")
        self._requests = Requests(1.0)
        self._others = self._requests.join(_MAX_WAITING)
        self._queues = Queues(self._requests, _MAX_OF_CLIENT, _MAX_BUSY)
        self._closed = False

    def submit(
        self,
        work: Callable[[], None],
        client: Hashable | None = None,
        *,
        first: bool = False,
    ) -> bool:
        """Execute work soon, that of each client in turn; `first` is without effect.

        Return False if too much of the client waits, or after `close`.
        """
        if self._closed:
            return False
        mine = self._others.put if client is None else partial(self._queues.put, client)
        if not mine(work):
            return False
        try:
            self._pool.submit(self._carry_out)
        except RuntimeError:
            return False  # it has just been closed
        return True

    def _carry_out(self) -> None:
        # Work that waits for a place of its client is executed by the thread that leaves one.
        while True:
            begun = await_turn()
            if not self._requests.carry_out_one(limited=False):
                return
            charge(begun, _CONVERSION)

    def close(self) -> None:
        """Start no further work."""
        self._closed = True
        self._pool.shutdown(wait=False, cancel_futures=True)


class Desk:
    """A thread that executes requests of other processes, which may take a part of the time.

    Those that come first, such as to stop a component, wait for no others and are not limited.
    """

    def __init__(self, share: float, burst: float) -> None:
        self._requests = Requests(share, burst, conversion=_CONVERSION)
        self._queues = Queues(self._requests, _MAX_OF_CLIENT, 1)
        self._closed = threading.Event()
        self._thread: threading.Thread | None = None
        self._starting = threading.Lock()

    def submit(
        self, work: Callable[[], None], client: Hashable, *, first: bool = False
    ) -> bool:
        """Execute work of a client in turn; return False as `Workers.submit` does."""
        if self._closed.is_set() or not self._queues.put(client, work, first=first):
            return False
        with self._starting:
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._run, name="rtgen control", daemon=True
                )
                self._thread.start()
        return True

    def _run(self) -> None:
        while not self._closed.is_set():
            self._requests.wait(_PATIENCE)
            if not self._closed.is_set():
                self._requests.carry_out_one()

    def close(self) -> None:
        """Start no further work."""
        self._closed.set()
        self._requests.wake()
