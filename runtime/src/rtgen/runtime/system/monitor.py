"""Detects ticks that keep the other contexts of their thread waiting."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

from rtgen.runtime.system.runner import Busy, Runner

_PERIOD = 0.01
_TOO_LONG = 20_000_000
"""Time from which a tick is too long for a thread that it shares [ns]."""


class Monitor:
    """Calls `leave` for ticks of a runner that wait or compute for too long, in its own thread.

    A tick that only waits for a processor is left where it is: the machine is busy, and another
    thread would not have one either.
    """

    def __init__(
        self,
        runners: Callable[[], list[Runner]],
        leave: Callable[[Runner, Busy], None],
    ) -> None:
        self._runners = runners
        self._leave = leave
        self._end = threading.Event()
        self._seen: tuple[int, int] = (0, 0)
        self._thread = threading.Thread(
            target=self._run, name="rtgen monitor", daemon=True
        )

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._end.set()
        if self._thread.is_alive():
            self._thread.join()

    def _run(self) -> None:
        while not self._end.wait(_PERIOD):
            for runner in self._runners():
                busy = runner.busy
                if busy is not None:
                    self._look(runner, busy)

    def _look(self, runner: Runner, busy: Busy) -> None:
        waits, used = _activity(runner)
        begun, before = self._seen
        if begun != busy.begun:
            self._seen = busy.begun, used
        elif time.monotonic_ns() - busy.begun >= _TOO_LONG and (waits or used > before):
            self._leave(runner, busy)


def _activity(runner: Runner) -> tuple[bool, int]:
    """Return whether a thread waits for something else than a processor, and its time on one.

    The time is in ticks of the system's clock. Waits and 0 if the system does not tell.
    """
    file = Path(f"/proc/self/task/{runner.native_id}/stat")
    try:
        fields = file.read_text("ascii").rpartition(")")[2].split()
    except OSError:
        return True, 0  # not Linux, or the thread has ended
    return fields[0] != "R", int(fields[11]) + int(fields[12])
