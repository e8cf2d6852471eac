"""Real time: the contexts of a system in one thread, by absolute times, and those that block."""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from heapq import heappop, heappush
from typing import Any

from rtgen.facts.connector_properties import Subscription
from rtgen.runtime.errors import BlockedError
from rtgen.runtime.failures import NOTE, log
from rtgen.runtime.ports.publisher import Publisher
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.stack_frames import shown
from rtgen.runtime.system.monitor import Monitor
from rtgen.runtime.system.runner import Busy, Runner
from rtgen.runtime.system.scheduling import Action
from rtgen.runtime.system.tasks import Task, begin_of
from rtgen.runtime.system.watchdog import (
    Call,
    Watchdog,
    call_in_thread,
    calls_under_way,
    log_blocked,
)
from rtgen.runtime.timing.clocks import SECOND, RealClock, period_of
from rtgen.runtime.timing.stepping_aside import step_aside

_SWITCH_INTERVAL = 0.0005
"""Time after which a thread that computes lets another one run [s] (`sys.setswitchinterval`)."""
_POLL_INTERVAL = 5_000_000
"""Polling period of a condition of `run`, in ns, while no state changes."""
_BETWEEN_SAMPLES = 10_000_000
"""Least period of the ticks of a context that samples execute, which serve requests, in ns."""
_PERIODIC = ("on_execute", "on_state_update", "on_error")


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
    """A thread for all contexts that do not block; timeline and conditions run in that of `run`.

    A context has a thread of its own if it is asked for, or from the first tick on that waits, or
    takes longer than other contexts can wait: then another thread goes on with the others.
    """

    def __init__(self, clock: RealClock) -> None:
        self._clock = clock
        self._running = False
        self._closed = False
        self._tasks: dict[ExecutionContext, Task] = {}
        self._orders: dict[ExecutionContext, int] = {}
        self._moving = threading.RLock()
        self._shared = Runner("rtgen ticks", clock, self)
        self._runners = [self._shared]
        self._delayed: list[Action] = []
        self._timeline: list[tuple[int, int, Action]] = []
        self._added = 0
        self._changed = threading.Condition()
        self._end: BaseException | None = None
        self._watchdog = Watchdog(log_blocked)
        self._monitor = Monitor(lambda: [self._shared], self._leave_late)

    def start(self) -> None:
        if self._running:
            return
        _switching.begin()
        self._watchdog.start()
        self._monitor.start()
        own = []
        for context, task in list(self._tasks.items()):
            if context.has_own_thread:
                own.append(self._new_runner(context))
                own[-1].add(task, 0)
            else:
                self._shared.add(task, 0)
        self._clock.restart()
        self._running = True
        self._shared.start()
        for runner in own:
            runner.start()
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
        close: Callable[[], object] = _nothing

        def begin() -> None:
            nonlocal close
            if publisher.subscription is Subscription.PERIODIC:
                period = period_of(publisher.rate)
                runner = Runner("rtgen publisher", self._clock, self, ends_alone=True)
                runner.add(Task("", period, publisher.publish), self._clock.elapsed())
                close = runner.start().stop
            else:
                close = _publish_when_written(publisher)

        def end() -> None:
            if begin in self._delayed:
                self._delayed.remove(begin)
            step_aside()
            close()

        if self._running:
            begin()
        else:
            self._delayed.append(begin)
        return end

    def changed(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def started(self, context: ExecutionContext) -> None:
        if context not in self._orders:
            self._added += 1
            self._orders[context] = self._added

        def between() -> None:
            if context.is_running():
                context.between_ticks()

        def count(overruns: int, cause: str) -> None:
            context.overruns += overruns
            context.longest = max(context.longest, task.longest)
            context.causes[cause] = context.causes.get(cause, 0) + overruns

        # Registered before it starts, because its first tick may stop it.
        task = self._tasks[context] = Task(
            _name(context),
            max(context.period, _BETWEEN_SAMPLES * context.is_event_driven),
            context.cycle,
            order=self._orders[context],
            between=between,
            overrun=None if context.is_event_driven else count,
        )
        if self._running:
            due = begin_of(task.period, self._clock.elapsed())
            with self._moving:
                if context.has_own_thread:
                    runner = self._new_runner(context)
                    runner.add(task, due)
                    runner.start()
                else:
                    self._shared.add(task, due)

    @property
    def orders(self) -> Mapping[ExecutionContext, int]:
        return self._orders

    def reorder(self, order_of: Mapping[ExecutionContext, int]) -> None:
        self._orders.update(order_of)
        with self._moving:
            for context, task in list(self._tasks.items()):
                task.order = self._orders[context]
            self._shared.reorder()

    def stopped(self, context: ExecutionContext) -> bool:
        task = self._tasks.pop(context, None)
        if task is None or task.runner is None:
            return True
        runner = task.runner
        if runner.remove(task):
            return True
        for call in calls_under_way():
            if call.thread == runner.ident:
                _report_blocked(context.participants, call)
        return False

    def rate_changed(self, context: ExecutionContext) -> None:
        task = self._tasks.get(context)
        if task is None:
            return
        if task.runner is None:
            task.period = context.period
        else:
            task.runner.set_period(task, context.period)

    def cycle_changed(self, context: ExecutionContext) -> None:
        task = self._tasks.get(context)
        if task is not None:
            task.action = context.cycle

    def woken(self, context: ExecutionContext) -> None:
        task = self._tasks.get(context)
        if task is not None and task.runner is not None:
            task.runner.wake(task)

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
        with self._moving:
            runners = list(self._runners)
        for runner in runners:
            runner.halt()
        for runner in runners:
            runner.stop(end_calls)

    def close(self) -> None:
        for context in list(self._tasks):
            self.stopped(context)
        with self._moving:
            runners = list(self._runners)
        for runner in runners:
            runner.stop()
        if self._running and not self._closed:
            self._monitor.stop()
            _switching.end()
        self._watchdog.stop()
        self._closed = True

    # For runners

    def leave(self, runner: Runner, busy: Busy) -> None:
        """Let another thread go on with the other contexts of a runner."""
        if self._hand_over(runner, busy):
            log.info("%s has a thread of its own: its call waits", busy.task.name)

    def take_back(self, task: Task, due: int) -> None:
        """Let a context go on in the thread of the others."""
        with self._moving:
            self._shared.add(task, due)

    def separate(self, task: Task, due: int) -> None:
        """Let a context go on in a thread of its own."""
        context = self._context_of(task)
        if context is None:
            return
        context.has_own_thread = True
        runner = self._new_runner(context)
        runner.add(task, due)
        runner.start()
        log.log(
            NOTE,
            "%s has a thread of its own from now on: its ticks kept others from theirs",
            task.name,
        )

    def _leave_late(self, runner: Runner, busy: Busy) -> None:
        call = call_in_thread(runner.ident or 0)
        if self._hand_over(runner, busy, call) and call is not None:
            what = (
                "%s has a thread of its own %s: %s (%s, line %d) keeps others waiting"
            )
            is_periodic = call.callback in _PERIODIC
            how_long = "from now on" if is_periodic else "for this call"
            place = call.callback, shown(call.file), call.line
            level = NOTE if is_periodic else logging.INFO
            log.log(level, what, busy.task.name, how_long, *place)

    def _hand_over(self, runner: Runner, busy: Busy, call: Call | None = None) -> bool:
        call = call or call_in_thread(runner.ident or 0)
        is_once = call is not None and call.callback not in _PERIODIC
        with self._moving:
            name = f"rtgen {busy.task.name}"
            new = runner.hand_over(busy, name, once=is_once)
            if new is None:
                return False
            self._keep(new)
            self._shared = new
        context = self._context_of(busy.task)
        if context is not None and not is_once:
            context.has_own_thread = True
        return True

    def _context_of(self, task: Task) -> ExecutionContext | None:
        contexts = (c for c, t in list(self._tasks.items()) if t is task)
        return next(contexts, None)

    def _new_runner(self, context: ExecutionContext) -> Runner:
        name = f"rtgen {_name(context)}"
        runner = Runner(name, self._clock, self, ends_alone=True)
        self._keep(runner)
        return runner

    def _keep(self, runner: Runner) -> None:
        self._runners = [*(r for r in self._runners if not r.has_ended), runner]

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


def _name(context: ExecutionContext) -> str:
    return context.owner.instance_name if context.owner else "shared"


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


def _nothing() -> None:
    return None
