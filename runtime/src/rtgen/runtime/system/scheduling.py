"""Interface between a system and the scheduler of its contexts, publishers and timeline."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from rtgen.runtime.ports.publisher import Publisher
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.execution_context import Driver, ExecutionContext

Action = Callable[[], None]


class Scheduler(Driver, Protocol):
    """Schedules contexts, publishers and actions by one clock; times in ns since the start."""

    def start(self) -> None:
        """Start real time; simulated time only advances in `run`."""

    def at(self, instant: int, action: Action) -> None:
        """Call an action once, before the ticks at that time; immediately if it has passed."""

    def every(self, period: int, action: Action) -> Action:
        """Call an action now and every period, after the ticks; return a function that ends it."""

    def between_instants(self, period: int, action: Action) -> None:
        """Call an action about once a period of simulated time, while something runs.

        It must schedule nothing. In real time it is not called: writers are in other threads.
        """

    def reorder(self, order_of: Mapping[ExecutionContext, int]) -> None:
        """Give contexts other places among those of one instant: those of `orders`."""

    @property
    def orders(self) -> Mapping[ExecutionContext, int]:
        """The place of each context that has been started among those of one instant."""

    def drive(self, publisher: Publisher[Any], writer: Component) -> Action:
        """Run a publisher of a port of `writer`; return a function that ends it."""

    def changed(self) -> None:
        """Called after every change of state."""

    def end_run(self, error: BaseException) -> None:
        """See `System.end_run`."""

    @property
    def is_ending(self) -> bool:
        """See `System.is_ending`."""

    def run(self, until_ns: int | None, until: Callable[[], bool] | None) -> bool:
        """See `System.run`."""

    def halt(self, end_calls: Action) -> None:
        """End the ticks of all contexts; one that does not end in time continues (`stopped`).

        `end_calls` ends the calls of other processes that ticks wait for.
        """

    def close(self) -> None:
        """End all remaining activity."""
