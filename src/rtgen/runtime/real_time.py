"""Real time: a thread for each execution context and publisher, on a grid that does not drift."""

from __future__ import annotations

import threading
from collections.abc import Callable
from heapq import heappop, heappush
from typing import Any

from rtgen.runtime.clocks import SECOND, RealClock, period_of
from rtgen.runtime.component import Component
from rtgen.runtime.connector_properties import Subscription
from rtgen.runtime.connectors import Publisher
from rtgen.runtime.execution_context import ExecutionContext
from rtgen.runtime.scheduling import Action

_LOOK_AGAIN = 5_000_000
"""How often, in ns, a condition of `run` is looked at where no state changes."""


def next_instant(due: int, period: int, now: int) -> tuple[int, int]:
    """The instant for the tick after the one of `due`, and how many overruns that tick caused.

    All instants stay on the grid of `due`. If the next one has passed while the tick ran, the
    latest that has passed is made up for at once; those before it are left out.
    """
    following = due + period
    if now <= following:
        return following, 0
    left_out = (now - following) // period
    return following + left_out * period, left_out + 1


class PeriodicThread:
    """Calls an action at every instant of a grid, in a thread of its own."""

    def __init__(
        self,
        name: str,
        period: int,
        action: Action,
        clock: RealClock,
        on_overrun: Callable[[int], None],
    ) -> None:
        self.action = action
        self._period = period
        self._clock = clock
        self._on_overrun = on_overrun
        self._wake = threading.Condition()
        self._due = 0
        self._begun = False
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> PeriodicThread:
        """Begins to call, now."""
        self._due = self._clock.elapsed()
        self._thread.start()
        return self

    def set_period(self, period: int) -> None:
        """Changes the period; the next instant is one new period after the last."""
        with self._wake:
            if self._begun:
                self._due += period - self._period
            self._period = period
            self._wake.notify()

    def stop(self) -> None:
        """Ends the thread, after the action that may be under way."""
        with self._wake:
            self._stopped = True
            self._wake.notify()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join()

    def _run(self) -> None:
        while self._wait():
            self._begun = True
            self.action()
            with self._wake:
                now = self._clock.elapsed()
                self._due, overruns = next_instant(self._due, self._period, now)
            if overruns:
                self._on_overrun(overruns)

    def _wait(self) -> bool:
        with self._wake:
            while (
                not self._stopped and (delay := self._due - self._clock.elapsed()) > 0
            ):
                self._wake.wait(delay / SECOND)
            return not self._stopped


class RealTimeScheduler:
    """Threads for contexts and publishers; timeline and conditions in the thread of `run`."""

    def __init__(self, clock: RealClock) -> None:
        self._clock = clock
        self._running = False
        self._contexts: dict[ExecutionContext, PeriodicThread | None] = {}
        self._delayed: list[Action] = []
        self._closers: dict[int, Action] = {}
        self._timeline: list[tuple[int, int, Action]] = []
        self._added = 0
        self._changed = threading.Condition()

    def start(self) -> None:
        if self._running:
            return
        self._clock.restart()
        self._running = True
        for context in list(self._contexts):
            self._begin(context)
        for begin in self._delayed:
            begin()
        self._delayed.clear()

    def at(self, instant: int, action: Action) -> None:
        with self._changed:
            self._added += 1
            heappush(self._timeline, (instant, self._added, action))
            self._changed.notify_all()

    def every(self, period: int, action: Action) -> Action:
        ended = False

        def turn(instant: int) -> None:
            if not ended:
                action()
                following = next_instant(instant, period, self._clock.elapsed())[0]
                self.at(following, lambda: turn(following))

        def end() -> None:
            nonlocal ended
            ended = True

        first = self._clock.elapsed() if self._running else 0
        self.at(first, lambda: turn(first))
        return end

    def drive(self, publisher: Publisher[Any], writer: Component) -> Action:
        key = id(publisher)

        def begin() -> None:
            if publisher.subscription is Subscription.PERIODIC:
                period = period_of(publisher.rate)
                thread = PeriodicThread(
                    "rtgen publisher", period, publisher.publish, self._clock, _ignore
                ).start()
                self._closers[key] = thread.stop
            else:
                self._closers[key] = _publish_when_written(publisher)

        def end() -> None:
            if begin in self._delayed:
                self._delayed.remove(begin)
            self._closers.pop(key, _nothing)()

        if self._running:
            begin()
        else:
            self._delayed.append(begin)
        return end

    def changed(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def started(self, context: ExecutionContext) -> None:
        self._contexts[context] = None
        if self._running:
            self._begin(context)

    def stopped(self, context: ExecutionContext) -> None:
        thread = self._contexts.pop(context, None)
        if thread is not None:
            thread.stop()

    def rate_changed(self, context: ExecutionContext) -> None:
        thread = self._contexts.get(context)
        if thread is not None:
            thread.set_period(context.period)

    def cycle_changed(self, context: ExecutionContext) -> None:
        thread = self._contexts.get(context)
        if thread is not None:
            thread.action = context.cycle

    def run(self, until_ns: int | None, until: Callable[[], bool] | None) -> bool:
        self.start()
        while True:
            self._act()
            if until is not None and until():
                return True
            now = self._clock.elapsed()
            if until_ns is not None and now >= until_ns:
                return False
            with self._changed:
                ends = [until_ns] if until_ns is not None else []
                ends += [self._timeline[0][0]] if self._timeline else []
                ends += [now + _LOOK_AGAIN] if until is not None else []
                self._changed.wait(max(0, min(ends) - self._clock.elapsed()) / SECOND)

    def close(self) -> None:
        for context in list(self._contexts):
            self.stopped(context)

    def _begin(self, context: ExecutionContext) -> None:
        def count(overruns: int) -> None:
            context.overruns += overruns

        owner = context.owner.instance_name if context.owner else "shared"
        # Known before it starts, since its first tick may stop it.
        thread = self._contexts[context] = PeriodicThread(
            f"rtgen {owner}", context.period, context.cycle, self._clock, count
        )
        thread.start()

    def _act(self) -> None:
        while True:
            with self._changed:
                if not self._timeline or self._timeline[0][0] > self._clock.elapsed():
                    return
                action = heappop(self._timeline)[2]
            action()


def _publish_when_written(publisher: Publisher[Any]) -> Action:
    def run() -> None:
        while not publisher.closed:
            publisher.wait()
            publisher.publish()

    thread = threading.Thread(target=run, name="rtgen publisher", daemon=True)
    thread.start()
    return thread.join


def _ignore(overruns: int) -> None:
    return None


def _nothing() -> None:
    return None
