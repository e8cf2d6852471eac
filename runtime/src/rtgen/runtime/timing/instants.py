"""Interface to simulated time: the current time, and scheduled actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Instants(Protocol):
    """Schedules actions in simulated time."""

    def at(self, instant: int, action: Callable[[], None]) -> None:
        """Call an action once, before the ticks at that time; immediately if it has passed."""

    def after_ticks(self, action: Callable[[], None]) -> None:
        """Call an action once, at the current time, after its ticks."""


class SimulatedTime(Protocol):
    """A clock of simulated time."""

    @property
    def time(self) -> int:
        """Nanoseconds since the start."""

    @property
    def instants(self) -> Instants | None:
        """The scheduler that advances the time; None without one."""
