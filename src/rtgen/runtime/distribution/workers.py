"""Threads that execute the requests of other processes, a bounded number at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

_MAX_THREADS = 32
_MAX_WAITING = 1024
"""Maximum number of running and waiting requests; more are refused."""


class Workers:
    """Threads that execute requests; a single thread keeps their order."""

    def __init__(self, threads: int = _MAX_THREADS) -> None:
        self._pool = ThreadPoolExecutor(threads, "rtgen call")
        self._room = threading.BoundedSemaphore(_MAX_WAITING)

    def submit(self, work: Callable[[], None]) -> bool:
        """Execute work soon; return False if too much is waiting, or after `close`."""
        if not self._room.acquire(blocking=False):
            return False
        try:
            self._pool.submit(self._carry_out, work)
        except RuntimeError:
            self._room.release()
            return False
        return True

    def _carry_out(self, work: Callable[[], None]) -> None:
        try:
            work()
        finally:
            self._room.release()

    def close(self) -> None:
        """Start no further work."""
        self._pool.shutdown(wait=False, cancel_futures=True)
