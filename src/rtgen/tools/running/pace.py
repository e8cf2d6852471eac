"""Paces simulated time by the wall clock, times a factor."""

from __future__ import annotations

import time

from rtgen import runtime
from rtgen.runtime.timing.clocks import SECOND

_PERIOD = 0.02
"""Period of waiting for the wall clock [s]."""
_MAX_WAIT = 3600.0
"""Longest single wait [s], which operating systems limit."""


class Pace:
    """Waits for times counted from its creation."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._begun = time.monotonic()

    def wait(self, instant: int) -> None:
        """Wait for a simulated time [ns]."""
        due = self._begun + instant / SECOND / self._rate
        while (ahead := due - time.monotonic()) > 0.0:
            time.sleep(min(ahead, _MAX_WAIT))


def pace(running: runtime.System, rate: float) -> None:
    """Let a system in simulated time run at a pace from now on."""
    clock = Pace(rate)
    running.every(
        max(1, round(_PERIOD * rate * SECOND)), lambda: clock.wait(running.time)
    )
