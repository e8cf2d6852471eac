"""Periodic tasks of a thread, and the lanes of those that are due together."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import Protocol

import msgspec

from rtgen.runtime.system.scheduling import Action

GRID = 1_000_000
"""The first ticks of tasks are at multiples of this time [ns], so that they share rows."""


class TaskRunner(Protocol):
    """The thread that has a task."""

    @property
    def ident(self) -> int | None:
        """The identifier of the thread."""

    def set_period(self, task: Task, period: int) -> None:
        """Change a period; the next tick is one new period after the last."""

    def wake(self, task: Task) -> None:
        """Call `between` of a task after the tick in progress."""

    def remove(self, task: Task) -> bool:
        """Call a task no more; return False if its tick in progress does not end."""


class Work:
    """An action that is called when it is due; `of` is the task that it belongs to."""

    __slots__ = ("action", "is_waiting", "of")

    def __init__(self, action: Action, of: Task) -> None:
        self.action = action
        self.of = of
        self.is_waiting = False


class Task:
    """A periodic action; `order` is its place among those of one instant, `name` that for causes.

    `work` is done after `Runner.wake`, `overrun` with the number of instants without a tick,
    and their cause: MACHINE, ALL, or the name of the task whose tick took the time.
    """

    __slots__ = (
        "action",
        "ended",
        "first",
        "harm",
        "harmed",
        "lane",
        "longest",
        "name",
        "of",
        "order",
        "overrun",
        "period",
        "runner",
        "work",
    )

    def __init__(
        self,
        name: str,
        period: int,
        action: Action,
        *,
        order: int = 0,
        between: Action | None = None,
        overrun: Callable[[int, str], None] | None = None,
    ) -> None:
        self.name = name
        self.period = period
        self.action = action
        self.order = order
        self.work = Work(between or nothing, self)
        self.overrun = overrun
        self.longest = 0
        """The longest tick so far [ns]."""
        self.first = 0
        """When the first tick is due."""
        self.harm = self.harmed = 0
        """Number of its last ticks that kept others from theirs, and the number of the last one."""
        self.runner: TaskRunner | None = None
        self.lane: Lane | None = None
        self.of = self
        self.ended = False

    def count(self, overruns: int, cause: str) -> None:
        """Count instants without a tick."""
        if self.overrun is not None:
            self.overrun(overruns, cause)


_lane_numbers = count()


class Lane:
    """Tasks with equal period and phase, in their order; `due` is their next instant."""

    __slots__ = ("due", "number", "period", "tasks")

    def __init__(self, period: int, due: int) -> None:
        self.period = period
        self.due = due
        self.tasks: tuple[Task, ...] = ()
        self.number = next(_lane_numbers)

    def put(self, task: Task) -> None:
        self.tasks = tuple(sorted((*self.tasks, task), key=_order))
        task.lane = self

    def drop(self, task: Task) -> None:
        self.tasks = tuple(each for each in self.tasks if each is not task)
        task.lane = None


class LongTick(msgspec.Struct):
    """A tick that took long, and when it ended [ns since the start]."""

    end: int
    took: int
    task: Task
    is_counted: bool = False


def begin_of(period: int, now: int) -> int:
    """Return the first instant of a task that starts now: now, or shortly before."""
    return now - now % min(GRID, period)


def _order(task: Task) -> int:
    return task.order


def nothing() -> None:
    """Do nothing, as the action of a task that has ended."""
