"""Interface to simulated time: the time, and actions at an instant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Instants(Protocol):
    """Schedules actions in simulated time."""

    def at(self, instant: int, action: Callable[[], None]) -> None:
        """Call an action once, before the ticks of that instant; immediately if it has passed."""

    def behind_ticks(self, action: Callable[[], None]) -> None:
        """Call an action once, at this instant, after its ticks."""


class SimulatedTime(Protocol):
    """A clock of simulated time."""

    @property
    def time(self) -> int:
        """Nanoseconds since the start."""

    @property
    def instants(self) -> Instants | None:
        """The scheduler that advances the time; None without one."""
