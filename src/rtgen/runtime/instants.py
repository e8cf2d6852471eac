"""Simulated time as its users see it: the time, and actions at an instant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Instants(Protocol):
    """What lets things happen in simulated time: the scheduler."""

    def at(self, instant: int, action: Callable[[], None]) -> None:
        """Calls an action once, before the ticks of that instant; at once if it has passed."""

    def behind_ticks(self, action: Callable[[], None]) -> None:
        """Calls an action once, at this instant, after its ticks."""


class SimulatedTime(Protocol):
    """A clock of simulated time."""

    @property
    def time(self) -> int:
        """Nanoseconds since the start."""

    @property
    def instants(self) -> Instants | None:
        """The scheduler that moves the time on; None if there is none."""
