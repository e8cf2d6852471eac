"""What a system asks of the scheduler that drives its contexts, publishers and timeline."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from rtgen.runtime.component import Component
from rtgen.runtime.execution_context import Driver
from rtgen.runtime.publisher import Publisher

Action = Callable[[], None]


class Scheduler(Driver, Protocol):
    """Drives contexts, publishers and actions by one clock; times in ns since the start."""

    def start(self) -> None:
        """Lets real time begin; simulated time moves in `run` only."""

    def at(self, instant: int, action: Action) -> None:
        """Calls an action once, before the ticks of that instant; at once if it has passed."""

    def every(self, period: int, action: Action) -> Action:
        """Calls an action now and every period, after the ticks; returns how to end that."""

    def drive(self, publisher: Publisher[Any], writer: Component) -> Action:
        """Runs a publisher of a port of `writer`; returns how to end that."""

    def changed(self) -> None:
        """Told of every change of state."""

    def end_run(self, error: BaseException) -> None:
        """See `System.end_run`."""

    def run(self, until_ns: int | None, until: Callable[[], bool] | None) -> bool:
        """See `System.run`."""

    def halt(self) -> None:
        """Ends the ticks of all contexts; one that does not end in time goes on (`stopped`)."""

    def close(self) -> None:
        """Ends everything that still runs."""
