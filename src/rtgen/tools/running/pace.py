"""Paces simulated time by the wall clock, times a factor."""

from __future__ import annotations

import time
from collections.abc import Callable

from rtgen import runtime
from rtgen.runtime.timing.clocks import SECOND

_PERIOD = 0.02
"""Period of waiting for the wall clock [s]."""
_FINE_PERIOD = 0.002
"""The same where something else is done while waiting, such as the work of messages."""
_MAX_WAIT = 3600.0
"""Longest single wait [s], which operating systems limit."""


class Pace:
    """Waits by `rest` for times counted from its creation."""

    def __init__(self, rate: float, rest: Callable[[float], None] = time.sleep) -> None:
        self._rest = rest
        self._rate = rate
        self._begun = time.monotonic()

    def wait(self, instant: int) -> None:
        """Wait for a simulated time [ns]."""
        due = self._begun + instant / SECOND / self._rate
        self._rest(0.0)
        while (ahead := due - time.monotonic()) > 0.0:
            self._rest(min(ahead, _MAX_WAIT))


def pace(
    running: runtime.System,
    rate: float,
    rest: Callable[[float], None] = time.sleep,
) -> None:
    """Let a system in simulated time run at a pace from now on; `rest` waits, in seconds."""
    clock = Pace(rate, rest)
    period = _PERIOD if rest is time.sleep else _FINE_PERIOD
    running.every(
        max(1, round(period * rate * SECOND)), lambda: clock.wait(running.time)
    )
