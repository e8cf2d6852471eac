"""Simulated time: a loop over scheduled times in integer nanoseconds, without threads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from heapq import heapify, heappop, heappush, heapreplace
from operator import itemgetter
from typing import Any

import msgspec

from rtgen.facts.connector_properties import Subscription
from rtgen.runtime.errors import EndlessFlowError
from rtgen.runtime.ports.publisher import Publisher
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.system.scheduling import Action
from rtgen.runtime.system.timetable import Task, Timetable, timetable
from rtgen.runtime.timing.clocks import SimulatedClock, period_of

# Order of actions due at the same time; within a band, in order of insertion.
_ACTIONS, _PUBLISHERS, _CONTEXTS, _BUSES, _WATCHERS = (band << 32 for band in range(5))

_ARRIVALS = -1 << 32
"""After the action that wrote a sample, and before the next one of the same time."""

_MAX_ARRIVALS = 100_000
"""Executions on samples at one time."""

_NEVER = 1 << 62

_MIN_WAIT, _MAX_WAIT = 64, 65536
"""Number of steps without a timetable after one was interrupted: the first and the maximum."""


class _Driven(msgspec.Struct):
    """A running context: its task, and the time of its first tick."""

    task: Task
    since: int


class SimulatedScheduler:
    """Runs all tasks in order of time.

    At the same time the timeline comes first, then publishers, contexts, buses, watchers. Contexts
    are in the order in which their components were added to the system.

    Tasks with fixed periods run by a timetable while nothing is scheduled between them; the heap
    contains one-time actions. Any change puts the tasks back into the heap, with the same times and
    order.
    """

    def __init__(self, clock: SimulatedClock) -> None:
        self._clock = clock
        self._heap: list[tuple[int, int, Task]] = []
        self._added = 0
        self._orders: dict[ExecutionContext, int] = {}
        self._driven: dict[ExecutionContext, _Driven] = {}
        self._resume: dict[ExecutionContext, int] = {}
        self._woken: set[ExecutionContext] = set()
        self._arrivals = 0, 0
        """A time, and the number of executions on samples then."""
        self._end: BaseException | None = None
        self._table: Timetable | None = None
        self._place = -1
        """Number of the task called last in the current row."""
        self._wait = self._next_wait = _MIN_WAIT
        self._between: Action = _nothing
        self._pause = 0
        self._due = _NEVER
        """The time of the next call of `_between`."""
        clock.instants = self

    def start(self) -> None:
        return None

    def at(self, instant: int, action: Action) -> None:
        self._push(max(instant, self._clock.time), _ACTIONS, Task(action, 0))

    def after_ticks(self, action: Action) -> None:
        """Call an action once, at the current time, after its ticks."""
        self._push(self._clock.time, _BUSES, Task(action, 0))

    def in_turn_of(
        self, context: ExecutionContext, instant: int, action: Action
    ) -> None:
        """Call an action once, before the tick that the context has, or would have, then."""
        self._leave_table()
        order = self._orders[context]
        heappush(self._heap, (max(instant, self._clock.time), order, Task(action, 0)))

    def every(self, period: int, action: Action) -> Action:
        task = Task(action, period)
        self._push(self._clock.time, _WATCHERS, task)
        return self._end_of(task)

    def between_instants(self, period: int, action: Action) -> None:
        self._between, self._pause = action, period
        self._due = self._clock.time + period

    def drive(self, publisher: Publisher[Any], writer: Component) -> Action:
        if publisher.subscription is Subscription.PERIODIC:
            period = period_of(publisher.rate)
            task = Task(publisher.publish, period)
            self._push(self._clock.time + period, _PUBLISHERS, task)
            return self._end_of(task)
        due = False

        def signal() -> None:
            nonlocal due
            if not due:
                due = True
                writer._at_end_of_cycle(deliver)

        def deliver() -> None:
            nonlocal due
            due = False
            publisher.publish()
            if not publisher.idle and not publisher.closed:
                signal()

        publisher.signal = signal
        return _nothing

    def changed(self) -> None:
        return None

    def started(self, context: ExecutionContext) -> None:
        if context not in self._orders:
            self._added += 1
            self._orders[context] = _CONTEXTS + self._added
        # A context that stops and starts in its own tick must not tick twice at the same time.
        now = self._clock.time
        instant = max(now, min(self._resume.pop(context, 0), now + context.period))
        self._schedule(context, instant, since=instant)

    @property
    def orders(self) -> Mapping[ExecutionContext, int]:
        return self._orders

    def reorder(self, order_of: Mapping[ExecutionContext, int]) -> None:
        self._leave_table()
        self._orders.update(order_of)
        orders = {id(d.task): self._orders[c] for c, d in self._driven.items()}
        self._heap[:] = [
            (due, orders.get(id(task), order), task) for due, order, task in self._heap
        ]
        heapify(self._heap)

    def stopped(self, context: ExecutionContext) -> bool:
        driven = self._driven.pop(context, None)
        if driven is not None:
            self._resume[context] = self._cancel(driven.task)
        return True

    def rate_changed(self, context: ExecutionContext) -> None:
        driven = self._driven.pop(context, None)
        if driven is None:
            return
        due = self._cancel(driven.task)
        if due > driven.since:
            due += context.period - driven.task.period
        self._schedule(context, max(self._clock.time, due), driven.since)

    def cycle_changed(self, context: ExecutionContext) -> None:
        if context in self._driven:
            self._driven[context].task.action = context.cycle

    def end_run(self, error: BaseException) -> None:
        self._leave_table()
        self._end = self._end or error

    def woken(self, context: ExecutionContext) -> None:
        if context in self._woken or context not in self._driven:
            return
        self._woken.add(context)

        def between_ticks() -> None:
            self._woken.discard(context)
            if context in self._driven:
                context.between_ticks()

        if not context.is_event_driven:
            self._push(self._clock.time, _BUSES, Task(between_ticks, 0))
        elif self._counts_arrival(context):
            self._push(self._clock.time, _ARRIVALS, Task(between_ticks, 0))

    def _counts_arrival(self, context: ExecutionContext) -> bool:
        """Count executions at this time; end the run if samples go round without end."""
        instant, count = self._arrivals
        self._arrivals = self._clock.time, (
            count + 1 if instant == self._clock.time else 1
        )
        if count < _MAX_ARRIVALS or instant != self._clock.time:
            return True
        name = context.owner.instance_name if context.owner else "a shared context"
        self.end_run(
            EndlessFlowError(
                f"{name}: samples have executed components {_MAX_ARRIVALS} times at one instant;"
                " one component of a cycle has to be periodic"
            )
        )
        return False

    @property
    def is_ending(self) -> bool:
        return self._end is not None

    def run(self, until_ns: int | None, until: Callable[[], bool] | None) -> bool:
        heap, clock = self._heap, self._clock
        self._raise_end()
        if until is not None and until():
            return True
        while heap:
            instant = heap[0][0]
            if until_ns is not None and instant >= until_ns:
                break
            self._wait -= 1
            if self._wait < 0 and until is None and self._go_by_table(until_ns):
                if not heap or heap[0][0] > clock.time:
                    self._raise_end()
                continue
            clock.time = instant
            if instant >= self._due:
                self._interpose(instant)
            while heap and heap[0][0] == instant:
                _, order, task = heap[0]
                if task.period:
                    heapreplace(heap, (instant + task.period, order, task))
                else:
                    heappop(heap)
                task.action()
            if self._end is not None:
                self._raise_end()
            if until is not None and until():
                return True
        if until_ns is not None:
            clock.time = max(clock.time, until_ns)
        return False

    def halt(self, end_calls: Action) -> None:
        return None  # nothing runs between two calls of `run`

    def close(self) -> None:
        self._leave_table()
        self._heap.clear()

    def _go_by_table(self, until_ns: int | None) -> bool:
        """Run by a timetable until `until_ns`, or until something else is scheduled.

        False if there is none, or its first time is not before `until_ns`.
        """
        heap, clock = self._heap, self._clock
        self._wait = self._next_wait
        once = [entry for entry in heap if not entry[2].period]
        stop = min((entry[0] for entry in once), default=until_ns)
        if until_ns is not None and stop is not None:
            stop = min(stop, until_ns)
        if stop is not None and stop <= heap[0][0]:
            return False
        table = timetable([entry for entry in heap if entry[2].period])
        if table is None:
            self._next_wait = _MAX_WAIT
            return False
        heapify(once)
        heap[:] = once
        self._table, self._place = table, -1
        begun = clock.time
        try:
            if self._end is None:  # A signal may have come since the last look.
                self._tick(table, stop)
        finally:
            self._leave_table()
        short = clock.time - begun < 2 * table.length
        self._next_wait = min(2 * self._next_wait, _MAX_WAIT) if short else _MIN_WAIT
        self._wait = self._next_wait
        return True

    def _tick(self, table: Timetable, stop: int | None) -> None:
        """Call the tasks of a timetable before `stop`, until it is left."""
        clock, begin, rows = self._clock, table.begin, tuple(table.rows.items())
        while True:
            for offset, row in rows:
                instant = begin + offset
                if stop is not None and instant >= stop:
                    return
                clock.time = instant
                for number, task in row:
                    self._place = number
                    task.action()
                    if self._table is None:
                        return
            begin += table.length
            if begin >= self._due:
                self._interpose(begin)

    def _interpose(self, instant: int) -> None:
        self._due = instant + self._pause
        self._between()

    def _leave_table(self) -> None:
        """Put the tasks of the timetable back into the heap."""
        table, self._table = self._table, None
        if table is not None:
            self._heap += table.after(self._clock.time, self._place)
            heapify(self._heap)

    def _raise_end(self) -> None:
        error, self._end = self._end, None
        if error is not None:
            raise error

    def _push(self, instant: int, band: int, task: Task) -> None:
        self._leave_table()
        self._added += 1
        heappush(self._heap, (instant, band + self._added, task))

    def _schedule(self, context: ExecutionContext, instant: int, since: int) -> None:
        self._leave_table()
        order = self._orders[context]
        task = Task(context.cycle, context.period)
        self._driven[context] = _Driven(task, since)
        heappush(self._heap, (instant, order, task))

    def _end_of(self, task: Task) -> Action:
        def end() -> None:
            self._cancel(task)

        return end

    def _cancel(self, task: Task) -> int:
        """Remove a task from the heap; return when it was due."""
        self._leave_table()
        try:
            place = [*map(itemgetter(2), self._heap)].index(task)
        except ValueError:
            return self._clock.time
        due = self._heap.pop(place)[0]
        heapify(self._heap)
        return due


def _nothing() -> None:
    return None
