"""The two clocks: simulated time, which the scheduler sets, and real time."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from functools import cached_property

from rtgen.runtime.timing.guards import SINGLE_THREAD, Guard, ThreadsGuard
from rtgen.runtime.timing.instants import Instants
from rtgen.runtime.timing.simulated_network import SimulatedNetwork
from rtgen.runtime.timing.traffic import Traffic

SECOND = 1_000_000_000
"""Nanoseconds in a second."""


def period_of(rate_hz: float) -> int:
    """Return the period of a rate in whole nanoseconds, at least 1."""
    return max(1, round(SECOND / rate_hz))


class Clock(ABC):
    """The source of a system's time; all times are integer nanoseconds."""

    @cached_property
    def traffic(self) -> Traffic:
        """Events of the system on this clock, for recorders."""
        return Traffic()

    @property
    def network(self) -> SimulatedNetwork | None:
        """The simulated network; None if the machine's sockets and serial lines are used."""
        return None

    @abstractmethod
    def now(self) -> int:
        """Return the time for components and time stamps: simulated, real UTC since 1970."""

    @abstractmethod
    def elapsed(self) -> int:
        """Return the time since the system started, for schedules and records."""

    @abstractmethod
    def guard(self) -> Guard:
        """Return a new guard for a port of a system on this clock."""


class SimulatedClock(Clock):
    """Time that only the scheduler advances, from 0; `now` begins at `origin` [ns]."""

    def __init__(self, origin: int = 0) -> None:
        self.time = 0
        self.origin = origin
        self.instants: Instants | None = None
        """The scheduler that advances the time; None without one."""

    @cached_property
    def network(self) -> SimulatedNetwork:
        """The simulated network, created lazily."""
        return SimulatedNetwork(self)

    def now(self) -> int:
        return self.origin + self.time

    def elapsed(self) -> int:
        return self.time

    def guard(self) -> Guard:
        return SINGLE_THREAD


class RealClock(Clock):
    """The machine's monotonic clock, set to UTC once, so that it never jumps."""

    def __init__(self) -> None:
        self._start = time.monotonic_ns()
        self._utc_offset = time.time_ns() - self._start

    def restart(self) -> None:
        """Restart `elapsed` from 0."""
        self._start = time.monotonic_ns()

    def now(self) -> int:
        return time.monotonic_ns() + self._utc_offset

    def elapsed(self) -> int:
        return time.monotonic_ns() - self._start

    def guard(self) -> Guard:
        return ThreadsGuard()
