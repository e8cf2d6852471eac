"""Runs a system in a thread of its own: play, pause, step, speed, and requests between instants."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

from rtgen import runtime
from rtgen.runtime.requests import Requests
from rtgen.runtime.timing.clocks import SECOND

_REQUEST_INTERVAL: Final = 0.02
"""Interval of executing requests while the system runs [s]."""
_REPORT_INTERVAL: Final = 0.1
"""Interval of calling `report` [s]."""
_IDLE_INTERVAL: Final = 0.05
_MAX_LAG: Final = 0.25
"""Maximum lag of simulated time behind its pace [s of the wall clock]."""
_SHARE: Final = 0.1
"""The part of the time for requests of pages that may only look, while time passes."""
_LONGEST: Final = 0.01
"""Time for requests between two parts of the run, if so many wait [s]."""


class Runner:
    """Drives a system. All methods but `submit` and `close` belong to the runner's thread.

    `speed`: simulated seconds in a second, 0 for as fast as possible; without effect in real time.
    """

    def __init__(
        self,
        system: runtime.System,
        report: Callable[[], None],
        ended: Callable[[BaseException], None],
    ) -> None:
        self.system = system
        self.playing = False
        self.speed = 1.0
        self.over = False
        """Whether the run has ended by an error."""
        self._report = report
        self._ended = ended
        self.requests = Requests(_SHARE)
        """The requests of pages, which are executed between two parts of the run."""
        self._own = self.requests.join(None, first=True)
        self._closing = threading.Event()
        self._origin = (0.0, 0.0)
        self._thread = threading.Thread(target=self._run, name="rtgen-ui", daemon=True)

    @property
    def is_simulated(self) -> bool:
        """Whether time is simulated, so that it can be paused."""
        return isinstance(self.system.clock, runtime.SimulatedClock)

    def start(self) -> None:
        """Start to execute requests."""
        self._thread.start()

    def close(self) -> None:
        """End the run and close the system."""
        self._closing.set()
        if self._thread.ident is None:
            self.system.close()
        elif threading.current_thread() is not self._thread:
            self._thread.join()

    def submit(self, request: Callable[[], None]) -> bool:
        """Execute a request of the server itself between two parts of the run; return True."""
        return self._own.put(request)

    def play(self) -> None:
        """Let time pass from now on."""
        self.playing = not self.over
        self._keep_pace()

    def set_speed(self, speed: float) -> None:
        """Change the pace of simulated time."""
        self.speed = speed
        self._keep_pace()

    def step(self, duration: int) -> None:
        """Advance simulated time [ns]; at least to the next instant."""
        self._advance(self.system.time + max(duration, 1))

    def replace(self, system: runtime.System) -> None:
        """Continue with another system; the former one is closed."""
        former, self.system = self.system, system
        self.playing = self.over = False
        former.close()

    def _keep_pace(self) -> None:
        self._origin = (time.monotonic(), self.system.time / SECOND)

    def _run(self) -> None:
        next_report = 0.0
        try:
            while not self._closing.is_set():
                self._carry_out(self._play_on() if self.playing else _IDLE_INTERVAL)
                now = time.monotonic()
                if now >= next_report:
                    next_report = now + _REPORT_INTERVAL
                    self._report()
        finally:
            self.system.close()

    def _play_on(self) -> float:
        """Advance by one slice; return the wait until the next [s]."""
        now = self.system.time
        if not self.is_simulated or self.speed == 0.0:
            self._advance(now + round(_REQUEST_INTERVAL * SECOND))
            return 0.0
        wall, simulated = self._origin
        target = simulated + (time.monotonic() - wall) * self.speed
        if target - now / SECOND > _MAX_LAG * self.speed:
            # A machine that is too slow falls behind; later it does not catch up in leaps.
            self._keep_pace()
            target = now / SECOND + _REQUEST_INTERVAL * self.speed
        self._advance(round(target * SECOND))
        return _REQUEST_INTERVAL

    def _advance(self, instant: int) -> None:
        try:
            self.system.run(instant)
        except BaseException as error:
            self.playing, self.over = False, True
            self._ended(error)

    def _carry_out(self, patience: float) -> None:
        """Execute waiting requests, and wait a little for the first."""
        limited = self.playing
        if patience:
            self.requests.wait(patience, limited=limited)
        self.requests.carry_out(_LONGEST, limited=limited)
