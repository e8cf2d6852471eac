"""A thread that does something in rounds, and what is asked of it between them."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Final

_MAX_WAITING: Final = 256
"""Maximum number of waiting requests."""


class RequestThread:
    """Calls `begin` each `period` [s], and `settle` after each request between two rounds."""

    def __init__(
        self,
        name: str,
        period: float,
        begin: Callable[[], None],
        settle: Callable[[], None],
    ) -> None:
        self._period = period
        self._begin = begin
        self._settle = settle
        self._requests: queue.Queue[Callable[[], None]] = queue.Queue(_MAX_WAITING)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    @property
    def is_closing(self) -> bool:
        """Whether the thread ends; a round then ends early."""
        return self._closing.is_set()

    def submit(self, request: Callable[[], None]) -> bool:
        """Queue a request, which must not raise; return False if too many wait."""
        try:
            self._requests.put_nowait(request)
        except queue.Full:
            return False
        return True

    def carry_out_waiting(self) -> None:
        """Carry out what waits, within a round."""
        with suppress(queue.Empty):
            while not self.is_closing:
                self._requests.get_nowait()()

    def close(self) -> None:
        """End the thread after the request or the call in progress."""
        self._closing.set()
        self.submit(lambda: None)
        self._thread.join()

    def _run(self) -> None:
        while not self.is_closing:
            next_round = time.monotonic() + self._period
            self._begin()
            while (remaining := next_round - time.monotonic()) > 0:
                try:
                    self._requests.get(timeout=remaining)()
                except queue.Empty:
                    break
                if self.is_closing:
                    return
                self._settle()
