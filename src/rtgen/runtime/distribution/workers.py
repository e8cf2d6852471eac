"""Threads that carry out the requests of other processes, a bounded number at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

_THREADS = 32
_WAITING = 1024
"""Requests under way or waiting; more are refused."""


class Workers:
    """Threads that carry out requests; one thread keeps their order."""

    def __init__(self, threads: int = _THREADS) -> None:
        self._pool = ThreadPoolExecutor(threads, "rtgen call")
        self._room = threading.BoundedSemaphore(_WAITING)

    def submit(self, work: Callable[[], None]) -> bool:
        """Carry out work, soon; False if there is too much already, or after `close`."""
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
        """Begin no further work."""
        self._pool.shutdown(wait=False, cancel_futures=True)
