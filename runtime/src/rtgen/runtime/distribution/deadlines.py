"""Deadlines of subscriptions, for engines that do not support them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import msgspec


class Deadline(msgspec.Struct, eq=False):
    """Counts the periods of `seconds` without a sample (DDS 1.4, 2.2.3.7).

    The first period begins with the first sample, each other one with a sample or with the end of
    the previous period. None means no deadline. `clock` returns seconds.
    """

    _seconds: float | None
    _clock: Callable[[], float] = time.monotonic
    _last: float | None = None
    _missed: int = 0
    _lock: threading.Lock = msgspec.field(default_factory=threading.Lock)

    def met(self) -> None:
        """Note the arrival of a sample."""
        if self._seconds is not None:
            with self._lock:
                now = self._clock()
                self._missed += self._since(now)
                self._last = now

    def end(self) -> None:
        """End the monitoring."""
        with self._lock:
            self._missed += self._since(self._clock())
            self._last = None

    @property
    def missed(self) -> int:
        """Number of periods that ended without a sample."""
        with self._lock:
            return self._missed + self._since(self._clock())

    def _since(self, now: float) -> int:
        if self._last is None or self._seconds is None:
            return 0
        return int((now - self._last) / self._seconds)
