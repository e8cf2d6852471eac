"""Work of network threads in simulated time, which has one thread: it is done between instants."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any

from rtgen.runtime.failures import log
from rtgen.runtime.requests import Requests
from rtgen.runtime.services.servants import CallEnded

_MAX_WAITING = 10_000
_PATIENCE = 10.0
"""Seconds that a call waits for its turn."""
_LONGEST = 0.05
"""Seconds of work after which the clock is looked at."""


class Turns:
    """The work that waits; `rest` does it, in the thread of simulated time."""

    def __init__(self) -> None:
        self._requests = Requests(1.0)
        self._waiting = self._requests.join(_MAX_WAITING)
        self._left_out = 0

    def post(self, work: Callable[[], None]) -> None:
        """Do work soon, in order. Too much is left out, with a warning."""
        if not self._waiting.put(work):
            self._left_out += 1
            if self._left_out == 1:
                log.warning("messages are left out: more come than the run can take")

    def call(self, function: Callable[[], Any]) -> Any:
        """Return the result of a function that is called in its turn. Raises what it raises.

        Raises CallEnded if its turn does not come.
        """
        result: Future[Any] = Future()

        def work() -> None:
            if not result.set_running_or_notify_cancel():
                return
            try:
                result.set_result(function())
            except BaseException as error:
                result.set_exception(error)

        self.post(work)
        try:
            return result.result(_PATIENCE)
        except FutureTimeoutError:
            result.cancel()
            raise CallEnded("the run stands, or has ended") from None

    def rest(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Do the work that comes within a time [s], or until a condition holds after some work."""
        end = time.monotonic() + seconds
        while True:
            self._requests.carry_out(_LONGEST, limited=False)
            remaining = end - time.monotonic()
            if remaining <= 0 or until():
                return
            self._requests.wait(remaining, limited=False)
