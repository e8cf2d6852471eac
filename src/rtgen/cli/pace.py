"""Lets simulated time pass as the wall clock does, times a factor."""

from __future__ import annotations

import time

from rtgen import runtime
from rtgen.cli.common import FiniteRange
from rtgen.runtime.timing.clocks import SECOND

RATE = FiniteRange(1e-6, 1e6)
"""The type of options for the factor."""

_PERIOD = 0.02
"""How often a system waits for the wall clock [s]."""
_LONGEST = 3600.0
"""The longest single wait [s]; operating systems limit it."""


class Pace:
    """Waits until instants have come, counted from when it was made."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._begun = time.monotonic()

    def wait(self, instant: int) -> None:
        """Wait for an instant [ns] of simulated time."""
        due = self._begun + instant / SECOND / self._rate
        while (ahead := due - time.monotonic()) > 0.0:
            time.sleep(min(ahead, _LONGEST))


def pace(running: runtime.System, rate: float) -> None:
    """Let a system in simulated time run at a pace from now on."""
    clock = Pace(rate)
    running.every(
        max(1, round(_PERIOD * rate * SECOND)), lambda: clock.wait(running.time)
    )
