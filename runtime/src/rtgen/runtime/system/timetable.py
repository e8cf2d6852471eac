"""Timetable of tasks with fixed periods, for the least common multiple of the periods."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import lcm
from typing import TypeAlias

MAX_ENTRIES = 4096
"""Maximum number of entries of a timetable."""


class Task:
    """An action, called every `period` nanoseconds; 0: once."""

    __slots__ = ("action", "period")

    def __init__(self, action: Callable[[], None], period: int) -> None:
        self.action = action
        self.period = period

    def __lt__(self, other: Task) -> bool:
        """Order one-time tasks before periodic ones with the same order."""
        return self.period < other.period


Due: TypeAlias = tuple[int, int, Task]
"""The next time of a task, its order among tasks at the same time, and the task."""

Row: TypeAlias = tuple[tuple[int, Task], ...]
"""The tasks at one time in order, numbered from 0."""


class Timetable:
    """The times of `tasks` from `begin` on, repeated every `length` nanoseconds."""

    __slots__ = ("_tasks", "begin", "entries", "length", "rows")

    def __init__(self, tasks: Sequence[Due], begin: int, length: int) -> None:
        self._tasks = sorted(tasks, key=lambda due: due[1])
        self.begin = begin
        self.length = length
        tasks_of: dict[int, list[Task]] = {}
        for due, _, task in self._tasks:
            for offset in range(due - begin, length, task.period):
                tasks_of.setdefault(offset, []).append(task)
        self.rows: dict[int, Row] = {
            offset: tuple(enumerate(tasks_of[offset])) for offset in sorted(tasks_of)
        }
        """The offset of each time from `begin`, with its tasks."""
        self.entries = sum(map(len, self.rows.values()))

    def after(self, now: int, place: int) -> Iterator[Due]:
        """Yield the next time of each task, if those of `now` were called up to number `place`."""
        row = (
            self.rows.get((now - self.begin) % self.length, ())
            if now >= self.begin
            else ()
        )
        called = {id(task): number <= place for number, task in row}
        for due, order, task in self._tasks:
            following = due + max(0, (now - due) // task.period + 1) * task.period
            yield (following if called.get(id(task), True) else now), order, task


def timetable(tasks: Sequence[Due]) -> Timetable | None:
    """Return the timetable of tasks; None if it is too long, or a task starts too late.

    A task must start within one of its periods.
    """
    if not tasks:
        return None
    begin = min(due for due, _, _ in tasks)
    length = lcm(*(task.period for _, _, task in tasks))
    entries = sum(length // task.period for _, _, task in tasks)
    if entries > MAX_ENTRIES or any(d - begin >= t.period for d, _, t in tasks):
        return None
    return Timetable(tasks, begin, length)
