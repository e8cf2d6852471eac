"""The instants of tasks with fixed periods, worked out for the least common multiple of these."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import lcm
from typing import TypeAlias

MAX_ENTRIES = 4096
"""Timetables with more entries are not made."""


class Task:
    """An action, called every `period` nanoseconds; 0: once."""

    __slots__ = ("action", "period")

    def __init__(self, action: Callable[[], None], period: int) -> None:
        self.action = action
        self.period = period

    def __lt__(self, other: Task) -> bool:
        """What is called once goes before what is called again and again in the same turn."""
        return self.period < other.period


Due: TypeAlias = tuple[int, int, Task]
"""When a task is due next, its order among those of one instant, the task."""

Row: TypeAlias = tuple[tuple[int, Task], ...]
"""The tasks of one instant in their order, numbered from 0."""


class Timetable:
    """The instants of `tasks` from `begin` on, repeated every `length` nanoseconds."""

    __slots__ = ("_tasks", "begin", "entries", "length", "rows")

    def __init__(self, tasks: Sequence[Due], begin: int, length: int) -> None:
        self._tasks = sorted(tasks, key=lambda due: due[1])
        self.begin = begin
        self.length = length
        found: dict[int, list[Task]] = {}
        for due, _, task in self._tasks:
            for offset in range(due - begin, length, task.period):
                found.setdefault(offset, []).append(task)
        self.rows: dict[int, Row] = {
            offset: tuple(enumerate(found[offset])) for offset in sorted(found)
        }
        """The offset of each instant from `begin`, with its tasks."""
        self.entries = sum(map(len, self.rows.values()))

    def after(self, now: int, place: int) -> Iterator[Due]:
        """When each task is due next, if those of `now` have been called up to number `place`."""
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
    """Return the timetable of tasks; None if it is too long, or a task begins after one of its
    periods.
    """
    if not tasks:
        return None
    begin = min(due for due, _, _ in tasks)
    length = lcm(*(task.period for _, _, task in tasks))
    entries = sum(length // task.period for _, _, task in tasks)
    if entries > MAX_ENTRIES or any(d - begin >= t.period for d, _, t in tasks):
        return None
    return Timetable(tasks, begin, length)
