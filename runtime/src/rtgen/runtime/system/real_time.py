"""Real time: a thread for each execution context and publisher, with drift-free periods."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Sequence
from heapq import heappop, heappush
from typing import Any

from rtgen.facts.connector_properties import Subscription
from rtgen.runtime import requests
from rtgen.runtime.errors import BlockedError
from rtgen.runtime.ports.publisher import Publisher
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.system import watchdog
from rtgen.runtime.system.scheduling import Action
from rtgen.runtime.system.watchdog import (
    Call,
    Watchdog,
    calls_under_way,
    log_blocked,
)
from rtgen.runtime.timing.clocks import SECOND, RealClock, period_of

_SWITCH_INTERVAL = 0.0005
"""Time after which a thread that computes lets another one run [s] (`sys.setswitchinterval`)."""
_POLL_INTERVAL = 5_000_000
"""Polling period of a condition of `run`, in ns, while no state changes."""
_ASKED_AGAIN = 0.05
"""Seconds after which a tick that has not ended is asked again to end: it may begin a call late."""


def next_instant(due: int, period: int, now: int) -> tuple[int, int]:
    """Return the time of the tick after that of `due`, and the number of overruns.

    All times are multiples of the period from `due`. If the next one passed while the tick ran, the
    latest passed one is made up for immediately; earlier ones are skipped.
    """
    following = due + period
    if now <= following:
        return following, 0
    left_out = (now - following) // period
    return following + left_out * period, left_out + 1


class PeriodicThread:
    """Calls an action periodically, in a separate thread."""

    def __init__(
        self,
        name: str,
        period: int,
        action: Action,
        clock: RealClock,
        on_overrun: Callable[[int], None],
        on_error: Callable[[BaseException], None],
    ) -> None:
        self.action = action
        self._period = period
        self._clock = clock
        self._on_overrun = on_overrun
        self._on_error = on_error
        self._wake = threading.Condition()
        self._due = 0
        self._begun = False
        self.longest = 0
        """The longest action so far, in ns."""
        self._stopped = False
        self._given_up = 0.0
        """When an action in progress is abandoned, by the monotonic clock in seconds."""
        self._woken: Action | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> PeriodicThread:
        """Start to call the action, now."""
        self._due = self._clock.elapsed()
        self._thread.start()
        return self

    def set_period(self, period: int) -> None:
        """Change the period; the next time is one new period after the last."""
        with self._wake:
            if self._begun:
                self._due += period - self._period
            self._period = period
            self._wake.notify()

    def wake(self, action: Action) -> None:
        """Call another action in the thread, soon; the next tick also makes up for it."""
        with self._wake:
            self._woken = action
            self._wake.notify()

    def halt(self) -> None:
        """Start no further actions."""
        with self._wake:
            if not self._stopped:
                self._stopped = True
                self._given_up = time.monotonic() + watchdog.PATIENCE
            self._wake.notify()

    def stop(self, meanwhile: Action | None = None) -> bool:
        """End the thread after the action in progress; return False if that does not end.

        `meanwhile` is called now and then until the action has ended.
        """
        self.halt()
        if threading.current_thread() is self._thread:
            return True
        while self._thread.is_alive():
            remaining = self._given_up - time.monotonic()
            if remaining <= 0:
                return False
            if meanwhile is not None:
                meanwhile()
            self._thread.join(
                remaining if meanwhile is None else min(remaining, _ASKED_AGAIN)
            )
        return True

    @property
    def ident(self) -> int | None:
        """The identifier of the thread."""
        return self._thread.ident

    def _run(self) -> None:
        while self._wait():
            woken, self._woken = self._woken, None
            is_due = self._due <= self._clock.elapsed()
            self._begun = self._begun or is_due
            begun = self._clock.elapsed()
            try:
                if is_due:
                    self.action()
                elif woken is not None:
                    woken()
            except BaseException as error:
                self._on_error(error)
                return
            if not is_due:
                continue
            with self._wake:
                now = self._clock.elapsed()
                self.longest = max(self.longest, now - begun)
                self._due, overruns = next_instant(self._due, self._period, now)
            if overruns:
                requests.overruns.report()
                self._on_overrun(overruns)

    def _wait(self) -> bool:
        with self._wake:
            while (
                not self._stopped
                and self._woken is None
                and (delay := self._due - self._clock.elapsed()) > 0
            ):
                self._wake.wait(delay / SECOND)
            return not self._stopped


class _Switching:
    """Lets threads wait for the interpreter shortly, while a system runs in real time.

    The interpreter's own interval is five periods of a component of 1 kHz, during which a thread
    that computes, such as one that answers requests from outside, keeps all others waiting.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._users = 0
        self._before = 0.0

    def begin(self) -> None:
        """Shorten the interval."""
        with self._lock:
            if self._users == 0:
                self._before = sys.getswitchinterval()
                sys.setswitchinterval(min(self._before, _SWITCH_INTERVAL))
            self._users += 1

    def end(self) -> None:
        """Restore the interval after the last user."""
        with self._lock:
            self._users -= 1
            if self._users == 0:
                sys.setswitchinterval(self._before)


_switching = _Switching()


class RealTimeScheduler:
    """Threads for contexts and publishers; timeline and conditions run in the thread of `run`."""

    def __init__(self, clock: RealClock) -> None:
        self._clock = clock
        self._running = False
        self._closed = False
        self._contexts: dict[ExecutionContext, PeriodicThread | None] = {}
        self._delayed: list[Action] = []
        self._closers: dict[int, Callable[[], object]] = {}
        self._timeline: list[tuple[int, int, Action]] = []
        self._added = 0
        self._changed = threading.Condition()
        self._end: BaseException | None = None
        self._watchdog = Watchdog(log_blocked)

    def start(self) -> None:
        if self._running:
            return
        self._clock.restart()
        _switching.begin()
        self._watchdog.start()
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

    def between_instants(self, period: int, action: Action) -> None:
        return None

    def drive(self, publisher: Publisher[Any], writer: Component) -> Action:
        key = id(publisher)

        def begin() -> None:
            if publisher.subscription is Subscription.PERIODIC:
                period = period_of(publisher.rate)
                thread = PeriodicThread(
                    "rtgen publisher",
                    period,
                    publisher.publish,
                    self._clock,
                    _ignore,
                    self.end_run,
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

    def stopped(self, context: ExecutionContext) -> bool:
        thread = self._contexts.pop(context, None)
        if thread is None or thread.stop():
            return True
        for call in calls_under_way():
            if call.thread == thread.ident:
                _report_blocked(context.participants, call)
        return False

    def rate_changed(self, context: ExecutionContext) -> None:
        thread = self._contexts.get(context)
        if thread is not None:
            thread.set_period(context.period)

    def cycle_changed(self, context: ExecutionContext) -> None:
        thread = self._contexts.get(context)
        if thread is not None:
            thread.action = context.cycle

    def woken(self, context: ExecutionContext) -> None:
        thread = self._contexts.get(context)
        if thread is not None:
            thread.wake(context.between_ticks)

    def end_run(self, error: BaseException) -> None:
        with self._changed:
            self._end = self._end or error
            self._changed.notify_all()

    @property
    def is_ending(self) -> bool:
        return self._end is not None

    def run(self, until_ns: int | None, until: Callable[[], bool] | None) -> bool:
        self.start()
        while True:
            self._act()
            self._raise_end()
            if until is not None and until():
                return True
            now = self._clock.elapsed()
            if until_ns is not None and now >= until_ns:
                return False
            with self._changed:
                if self._end is not None:
                    continue
                ends = [until_ns] if until_ns is not None else []
                ends += [self._timeline[0][0]] if self._timeline else []
                ends += [now + _POLL_INTERVAL] if until is not None else []
                self._changed.wait(max(0, min(ends) - self._clock.elapsed()) / SECOND)

    def halt(self, end_calls: Action) -> None:
        threads = [thread for thread in self._contexts.values() if thread is not None]
        for thread in threads:
            thread.halt()
        for thread in threads:
            thread.stop(end_calls)

    def close(self) -> None:
        for context in list(self._contexts):
            self.stopped(context)
        self._watchdog.stop()
        if self._running and not self._closed:
            _switching.end()
        self._closed = True

    def _begin(self, context: ExecutionContext) -> None:
        def count(overruns: int) -> None:
            context.overruns += overruns
            context.longest = thread.longest

        owner = context.owner.instance_name if context.owner else "shared"
        # Registered before it starts, because its first tick may stop it.
        thread = self._contexts[context] = PeriodicThread(
            f"rtgen {owner}",
            context.period,
            context.cycle,
            self._clock,
            count,
            self.end_run,
        )
        thread.start()

    def _raise_end(self) -> None:
        error, self._end = self._end, None
        if error is not None:
            raise error

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


def _report_blocked(participants: Sequence[Participant], call: Call) -> None:
    """Report a call that does not return as a failure of the context's participants."""
    error = BlockedError(call.callback, call.file, call.line)
    for participant in participants:
        if participant.component.instance_name == call.instance:
            participant.component._failed(call.callback, str(error), error)
        else:
            participant.component._failed(call.callback, f"waits for {call}", error)


def _ignore(overruns: int) -> None:
    return None


def _nothing() -> None:
    return None
