"""Threads that execute the requests of other processes: those of each client in turn."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from rtgen.runtime.requests import Client, Requests

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
_MAX_CLIENTS = 256
_PATIENCE = 60.0


class Queues:
    """The queues of clients by their names; those of clients without requests are forgotten."""

    def __init__(self, requests: Requests, limit: int, busy: int) -> None:
        """Set up with the limits of each client: waiting requests, and those being executed."""
        self._requests = requests
        self._limit = limit
        self._busy = busy
        self._clients: OrderedDict[Hashable, Client] = OrderedDict()
        self._lock = threading.Lock()

    def put(
        self, name: Hashable, request: Callable[[], object], *, first: bool = False
    ) -> bool:
        """Add a request of a client; return False if too many wait."""
        with self._lock:
            client = self._client(name, first=first)
            return client is not None and client.put(request)

    def _client(self, name: Hashable, *, first: bool) -> Client | None:
        key = name, first
        client = self._clients.get(key)
        if client is not None:
            self._clients.move_to_end(key)
            return client
        if len(self._clients) >= _MAX_CLIENTS:
            idle = next((k for k, c in self._clients.items() if c.is_idle), None)
            if idle is None:
                return None
            self._requests.leave(self._clients.pop(idle))
        made: list[Client] = []
        ready = partial(self._is_ready, made)
        made.append(self._requests.join(self._limit, first=first, ready=ready))
        self._clients[key] = made[0]
        return made[0]

    def _is_ready(self, client: list[Client]) -> bool:
        return client[0].running < self._busy


class Workers:
    """Threads that execute requests; a single thread keeps the order of each client."""

    def __init__(self, threads: int = _MAX_THREADS) -> None:
        self._pool = ThreadPoolExecutor(threads, "rtgen call")
        self._requests = Requests(1.0)
        self._others = self._requests.join(_MAX_WAITING)
        self._queues = Queues(self._requests, _MAX_OF_CLIENT, _MAX_BUSY)
        self._closed = False

    def submit(self, work: Callable[[], None], client: Hashable | None = None) -> bool:
        """Execute work soon, that of each client in turn.

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
        while self._requests.carry_out_one(limited=False):
            pass

    def close(self) -> None:
        """Start no further work."""
        self._closed = True
        self._pool.shutdown(wait=False, cancel_futures=True)


class Desk:
    """A thread that executes requests of other processes, which may take a part of the time.

    Those that come first, such as to stop a component, wait for no others and are not limited.
    """

    def __init__(self, share: float, burst: float) -> None:
        self._requests = Requests(share, burst)
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
