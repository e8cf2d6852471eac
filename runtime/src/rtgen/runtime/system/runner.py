"""A thread that calls periodic tasks at absolute times of the machine's clock.

Tasks of one period and phase are a lane; the lanes that are due at one instant are a row of tasks,
in their order, which is prepared once. So a tick costs little more than its call.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from heapq import heapify, heappop, heappush
from typing import Protocol

import msgspec

from rtgen.runtime import requests
from rtgen.runtime.system import watchdog
from rtgen.runtime.system.scheduling import Action
from rtgen.runtime.system.tasks import Lane, LongTick, Task, Work, begin_of, nothing
from rtgen.runtime.timing.clocks import SECOND, RealClock
from rtgen.runtime.timing.stepping_aside import shared, step_aside

_LONG = 200_000
"""Time from which a tick counts as a long one [ns]."""
_ASKED_AGAIN = 0.05
"""Seconds after which a tick that has not ended is asked again to end: it may begin a call late."""
_TURNS = 64
"""Number of actions between ticks that are called in succession while a tick is due."""
_PATIENCE = 3
"""Times that the ticks of a task keep others from theirs before it leaves them."""

MACHINE, ALL = "", "*"
"""Causes of an overrun that are not one task: the machine, and the tasks of a thread together."""


class Busy(msgspec.Struct):
    """A tick in progress: its task, and when it began by the monotonic clock [ns]."""

    task: Task
    begun: int


class Owner(Protocol):
    """What a runner calls of its scheduler."""

    def end_run(self, error: BaseException) -> None:
        """Called with an exception of an action; its task is not called any more."""

    def leave(self, runner: Runner, busy: Busy) -> None:
        """Called in the thread of a tick that is about to wait."""

    def take_back(self, task: Task, due: int) -> None:
        """Called for a task, due then, after the tick that `hand_over` made an exception of."""

    def separate(self, task: Task, due: int) -> None:
        """Called for a task, due then, whose ticks kept others from theirs; it has no runner."""


class Runner:
    """Calls tasks in a thread of its own; `ends_alone`: it ends after its last task."""

    def __init__(
        self, name: str, clock: RealClock, owner: Owner, *, ends_alone: bool = False
    ) -> None:
        self._clock = clock
        self._owner = owner
        self._ends_alone = ends_alone
        self._changed = threading.Condition()
        self._heap: list[tuple[int, int, Lane]] = []
        self._phases: dict[tuple[int, int], Lane] = {}
        self._rows: dict[tuple[Lane, ...], tuple[Task, ...]] = {}
        self._tasks: set[Task] = set()
        self._rest: deque[Task] = deque()
        """Tasks that are due at the instant in progress."""
        self._at_once: list[Task] = []
        """Tasks whose first tick is due, and those left over by another runner."""
        self._woken: deque[Work] = deque()
        """The work of tasks between their ticks; it comes before the rest of the instant."""
        self._current: Task | Work | None = None
        self._begun = 0
        self._news = False
        """Whether someone waits for the end of the tick in progress, or has changed the row."""
        self._stopped = False
        self._given_up = 0.0
        """When a tick in progress is abandoned, by the monotonic clock in seconds."""
        self._awake = self._processor = 0
        """When the thread waited last, and the processor time that it had had then [ns]."""
        self._long: deque[LongTick] = deque(maxlen=8)
        self._is_first = True
        self._is_exception = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    # Changes, from any thread

    def start(self) -> Runner:
        """Start to call the tasks."""
        self._thread.start()
        return self

    def add(self, task: Task, due: int) -> None:
        """Add a task; its first tick is at `due`, or at once."""
        task.first = due
        with self._changed:
            if not task.ended:
                self._put(task, due)
                self._changed.notify_all()

    def set_period(self, task: Task, period: int) -> None:
        """Change a period; the next tick is one new period after the last."""
        with self._changed:
            if task.runner is self:
                before, lane = task.period, task.lane
                task.period = period
                if lane is None:
                    return
                is_new = lane.due <= task.first or task in self._at_once
                due = task.first if is_new else lane.due - before + period
                self._drop(task)
                self._put(task, max(due, begin_of(period, self._clock.elapsed())))
                self._changed.notify_all()
                return
        task.period = period
        if task.runner is not None:
            task.runner.set_period(task, period)

    def reorder(self) -> None:
        """Call the tasks of one instant in their order, which has changed."""
        with self._changed:
            for _, _, lane in self._heap:
                lane.tasks = tuple(sorted(lane.tasks, key=_order))
            self._rows.clear()

    def wake(self, task: Task) -> None:
        """Call `between` of a task after the tick in progress."""
        with self._changed:
            if task.runner is self:
                if not task.work.is_waiting and not task.ended:
                    task.work.is_waiting = True
                    self._woken.append(task.work)
                    self._changed.notify_all()
                return
        if task.runner is not None:
            task.runner.wake(task)

    def remove(self, task: Task) -> bool:
        """Call a task no more; return False if its tick in progress does not end."""
        task.action, task.ended = nothing, True
        with self._changed:
            is_here = task.runner is self
            if is_here:
                self._drop(task)
                self._changed.notify_all()
        if not is_here:
            return task.runner is None or task.runner.remove(task)
        if threading.get_ident() == self._thread.ident:
            return True
        end = self._given_up or time.monotonic() + watchdog.PATIENCE
        return self._wait_for(lambda: self._in_progress() is not task, end)

    def halt(self) -> None:
        """Begin no further tick."""
        with self._changed:
            if not self._stopped:
                self._stopped = True
                self._given_up = time.monotonic() + watchdog.PATIENCE
            self._news = True
            self._changed.notify_all()

    def stop(self, meanwhile: Action | None = None) -> bool:
        """End the thread after the tick in progress; return False if that does not end.

        `meanwhile` is called now and then until the tick has ended.
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
    def has_ended(self) -> bool:
        """Whether the thread was started and has ended."""
        return self._thread.ident is not None and not self._thread.is_alive()

    @property
    def ident(self) -> int | None:
        """The identifier of the thread."""
        return self._thread.ident

    @property
    def native_id(self) -> int | None:
        """The identifier of the thread in the operating system."""
        return self._thread.native_id

    @property
    def busy(self) -> Busy | None:
        """The tick in progress, if it keeps other tasks waiting."""
        current, begun = self._current, self._begun
        if current is None or len(self._tasks) < 2:
            return None
        return Busy(current.of, begun)

    def hand_over(self, busy: Busy, name: str, *, once: bool) -> Runner | None:
        """Leave all tasks but that of the tick in progress to a new runner, and return it.

        The thread gets the name; with `once` it ends after the tick, and `Owner.take_back` gets
        the task. None if the tick has ended meanwhile, or there are no others.
        """
        with self._changed:
            self._news = True  # from here on the thread stops for the lock after a tick
            task = busy.task
            if self._in_progress() is not task or self._begun != busy.begun:
                return None
            others = self._tasks - {task}
            if not others or self._stopped:
                return None
            new = Runner(self._thread.name, self._clock, self._owner)
            new._is_first = False
            due = None if task.lane is None else task.lane.due
            is_woken = task.work.is_waiting
            # Its work is in progress, and its tick has still to come.
            is_due = any(each is task for each in (*self._at_once, *self._rest))
            self._drop(task)
            new._heap, new._phases, new._tasks = self._heap, self._phases, others
            new._at_once = [*self._at_once, *(t for t in self._rest if t is not task)]
            new._woken = deque(self._woken)
            self._heap, self._phases, self._rows, self._tasks = [], {}, {}, set()
            self._at_once = []
            self._rest.clear()
            self._woken.clear()
            for each in others:
                each.runner = new
            if not task.ended:
                self._put(task, due or 0)
                if is_due:
                    self._at_once.append(task)
                if is_woken:
                    task.work.is_waiting = True
                    self._woken.append(task.work)
            self._ends_alone, self._is_exception = True, once
            self._thread.name = name
            shared.pop(self._thread.ident or 0, None)
        return new.start()

    # The thread

    def _run(self) -> None:
        ident = threading.get_ident()
        if not self._ends_alone:
            shared[ident] = self._leave
        try:
            while self._await_row():
                self._execute()
                if self._is_exception:
                    self._give_back()
        finally:
            shared.pop(ident, None)

    def _leave(self) -> None:
        busy = self.busy
        if busy is not None:
            self._owner.leave(self, busy)

    def _give_back(self) -> None:
        with self._changed:
            tasks = [(t, t.lane.due if t.lane is not None else 0) for t in self._tasks]
            for task, _ in tasks:
                self._drop(task)
                task.runner = None
        for task, due in tasks:
            self._owner.take_back(task, due)

    def _execute(self) -> None:
        clock, woken, rest = time.monotonic_ns, self._woken, self._rest
        task: Task | Work
        begun = clock()
        turns = 0
        try:
            while rest or woken:
                if woken and (turns < _TURNS or not rest):
                    task = self._next_work()
                    turns += 1
                else:
                    task = rest.popleft()
                    turns = 0
                self._begun, self._current = begun, task
                task.action()
                self._current = None
                now = clock()
                if now - begun > _LONG:
                    self._note_long(task, now - begun)
                if self._news:
                    self._tell_waiting()
                if turns >= _TURNS and not rest:
                    return
                begun = now
        except BaseException as error:
            self._current = None
            self._owner.end_run(error)
            with self._changed:
                self._drop(task.of)

    def _next_work(self) -> Work:
        with self._changed:
            if not self._woken:  # another thread has removed it
                return _NO_WORK
            work = self._woken.popleft()
            work.is_waiting = False
            return work

    def _tell_waiting(self) -> None:
        """Let those go on who wait for the end of the tick, or change the tasks."""
        with self._changed:
            self._news = False
            self._changed.notify_all()
            if self._stopped:
                self._rest.clear()
                for work in self._woken:
                    work.is_waiting = False
                self._woken.clear()

    def _await_row(self) -> bool:
        """Wait until there are tasks to be called; return False at the end of the thread.

        An instant at which the thread wakes late is not left out, but those that passed meanwhile.
        """
        has_waited = False
        with self._changed:
            while True:
                if self._stopped or (self._ends_alone and not self._tasks):
                    return False
                if self._at_once:
                    self._rest.extend(sorted(self._at_once, key=_order))
                    self._at_once.clear()
                    return True
                now = self._clock.elapsed()
                heap = self._heap
                if heap and heap[0][0] <= now:
                    self._rest.extend(self._take(heap[0][0] if has_waited else now))
                    return True
                if self._woken or self._rest:
                    return True
                self._changed.wait((heap[0][0] - now) / SECOND if heap else None)
                has_waited = True
                self._awake = self._clock.elapsed()
                self._processor = time.thread_time_ns()

    def _take(self, now: int) -> tuple[Task, ...]:
        """Return the tasks of the next instant."""
        heap, lanes, late = self._heap, [], []
        instant = heap[0][0]
        while heap and heap[0][0] == instant:
            lane = heappop(heap)[2]
            behind = (now - instant) // lane.period
            if behind:
                late.append((lane, behind))
            lane.due = instant + (behind + 1) * lane.period
            lanes.append(lane)
        for lane in lanes:
            heappush(heap, (lane.due, lane.number, lane))
        key = tuple(lanes)
        row = self._rows.get(key)
        if row is None:
            tasks = [task for lane in lanes for task in lane.tasks]
            row = self._rows[key] = tuple(sorted(tasks, key=_order))
        if late:
            harmful = self._leave_out(late, now)
            if harmful is not None and harmful.lane is not None:
                due = harmful.lane.due - (harmful in row) * harmful.period
                row = tuple(task for task in row if task is not harmful)
                self._drop(harmful)
                self._owner.separate(harmful, due)
        self._is_first = False
        return row

    def _leave_out(self, late: list[tuple[Lane, int]], now: int) -> Task | None:
        """Count the instants of late lanes; return a task that keeps others from theirs."""
        requests.overruns.report()
        harmful = None
        for lane, behind in late:
            since = lane.due - (behind + 1) * lane.period
            long = max(
                (tick for tick in self._long if tick.end > since),
                key=lambda tick: tick.took,
                default=None,
            )
            if long is None or 2 * long.took < now - since:
                self._count(lane, behind, None, self._why(since, now))
                continue
            task = long.task
            keeps_others = any(each is not task for each in lane.tasks)
            if keeps_others and not long.is_counted and not self._is_first:
                long.is_counted = True
                number = long.end // task.period
                task.harm = 1 if number > task.harmed + 2 else task.harm + 1
                task.harmed = number
                harmful = task if task.harm >= _PATIENCE else harmful
            # A single long tick without processor time is one that had to wait for a processor.
            waited = task.harm <= 1 and self._why(since, now) == MACHINE
            self._count(lane, behind, task, MACHINE if waited else task.name)
        return harmful

    def _count(self, lane: Lane, behind: int, culprit: Task | None, cause: str) -> None:
        for task in lane.tasks:
            if task is culprit:
                task.count(behind, task.name)
            elif not self._is_first:
                task.count(behind, cause)

    def _why(self, since: int, now: int) -> str:
        """Return why the thread is late: the machine, or what it did."""
        if self._awake > since + (now - since) // 2:
            return MACHINE
        processor = time.thread_time_ns() - self._processor
        return ALL if 2 * processor > now - self._awake else MACHINE

    def _note_long(self, called: Task | Work, took: int) -> None:
        task = called.of
        task.longest = max(task.longest, took)
        self._long.append(LongTick(self._clock.elapsed(), took, task))
        if took > task.period:
            requests.overruns.report()
            task.count(1, task.name)

    # With the lock

    def _put(self, task: Task, due: int) -> None:
        task.runner = self
        self._tasks.add(task)
        key = task.period, due % task.period
        lane = self._phases.get(key)
        if lane is None or not lane.tasks or lane.due < due:
            lane = self._phases[key] = Lane(task.period, due)
            heappush(self._heap, (due, lane.number, lane))
        elif lane.due > due:
            self._at_once.append(task)
        lane.put(task)
        self._rows.clear()

    def _drop(self, task: Task) -> None:
        self._tasks.discard(task)
        self._at_once[:] = [each for each in self._at_once if each is not task]
        if task.work.is_waiting:
            task.work.is_waiting = False
            self._woken.remove(task.work)
        lane = task.lane
        if lane is None:
            return
        lane.drop(task)
        if not lane.tasks:
            self._heap[:] = [each for each in self._heap if each[2] is not lane]
            heapify(self._heap)
            self._phases = {k: v for k, v in self._phases.items() if v is not lane}
        self._rows.clear()

    def _in_progress(self) -> Task | None:
        current = self._current
        return None if current is None else current.of

    def _wait_for(self, condition: Callable[[], bool], end: float) -> bool:
        if not condition():
            step_aside()
        with self._changed:
            while True:
                self._news = True
                if condition():
                    return True
                remaining = end - time.monotonic()
                if remaining <= 0:
                    return False
                self._changed.wait(remaining)


def _order(task: Task) -> int:
    return task.order


_NO_WORK = Task("", 1, nothing).work
