"""Timetables of simulated time: every call at the same time and in the same order as by a heap."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random

import pytest

from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.system import simulated_time
from rtgen.runtime.system.simulated_time import SimulatedScheduler
from rtgen.runtime.system.timetable import (
    MAX_ENTRIES,
    Due,
    Task,
    Timetable,
    timetable,
)
from rtgen.runtime.timing.clocks import SimulatedClock

RATES = (1000.0, 500.0, 250.0, 200.0, 100.0, 50.0, 10.0)
MS = 1_000_000


class Play:
    """Contexts, watchers and single actions that change each other now and then."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.clock = SimulatedClock()
        self.scheduler = SimulatedScheduler(self.clock)
        self.heard: list[tuple[int, str]] = []
        self.ends: list[Callable[[], None]] = []
        self.contexts: list[ExecutionContext] = []
        for number in range(self.random.randint(1, 5)):
            self.add(number)

    def add(self, number: int) -> None:
        context = ExecutionContext(self.random.choice(RATES), driver=self.scheduler)
        context.cycle = lambda: self.hear(f"context {number}")
        self.contexts.append(context)
        context.start()

    def hear(self, name: str) -> None:
        self.heard.append((self.clock.time, name))
        if self.random.random() < 0.002:
            self.disturb()

    def disturb(self) -> None:
        now, draw = self.clock.time, self.random
        number = len(self.heard)
        context = draw.choice(self.contexts)
        match draw.randrange(8):
            case 0:
                later = now + draw.choice((0, 1, MS, 7 * MS, 300 * MS))
                self.scheduler.at(later, lambda: self.hear(f"single {number}"))
            case 1:
                self.scheduler.after_ticks(lambda: self.hear(f"behind {number}"))
            case 2:
                period = draw.choice((MS, 3 * MS, 20 * MS))
                end = self.scheduler.every(period, lambda: self.hear(f"each {number}"))
                self.ends.append(end)
            case 3 if self.ends:
                self.ends.pop(draw.randrange(len(self.ends)))()
            case 4:
                context.set_rate(draw.choice(RATES))
            case 5:
                context.stop() if context.is_running() else context.start()
            case 6:
                self.scheduler.end_run(KeyboardInterrupt())
            case 7:
                raise ZeroDivisionError

    def run(self) -> list[tuple[int, str]]:
        for until in (50 * MS, 51 * MS, 51 * MS, 3000 * MS, 3000 * MS + 1, 5000 * MS):
            for _ in range(100):
                try:
                    self.scheduler.run(until, None)
                except (KeyboardInterrupt, ZeroDivisionError) as error:
                    self.heard.append((self.clock.time, repr(error)))
                else:
                    break
            self.heard.append((self.clock.time, "end"))
        return self.heard


@pytest.mark.parametrize("seed", range(30))
def test_as_by_the_heap_alone(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    made = []

    def noted(tasks: list[tuple[int, int, Task]]) -> object:
        made.append(timetable(tasks))
        return made[-1]

    monkeypatch.setattr(simulated_time, "_MIN_WAIT", 3)
    monkeypatch.setattr(simulated_time, "timetable", noted)
    by_table = Play(seed).run()
    assert any(made)
    monkeypatch.setattr(simulated_time, "timetable", lambda tasks: None)
    assert by_table == Play(seed).run()


def test_what_has_no_timetable() -> None:
    def task(period: int) -> Task:
        return Task(lambda: None, period)

    assert timetable([]) is None
    assert timetable([(0, 1, task(MS)), (MS, 2, task(MS))]) is None
    assert timetable([(0, 1, task(MS)), (0, 2, task(MS + 1))]) is None
    table = timetable([(5, 1, task(2)), (6, 2, task(3))])
    assert table is not None
    assert (table.begin, table.length, table.entries) == (5, 6, 5)
    assert table.entries < MAX_ENTRIES
    assert list(table.rows) == [0, 1, 2, 4]


def test_a_signal_while_a_timetable_is_made_ends_the_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = SimulatedClock()
    scheduler = SimulatedScheduler(clock)
    context = ExecutionContext(1000.0, driver=scheduler)
    context.cycle = lambda: None
    context.start()

    def interrupted(tasks: Sequence[Due]) -> Timetable | None:
        made = timetable(tasks)
        if made is not None:
            scheduler.end_run(KeyboardInterrupt())
        return made

    monkeypatch.setattr(simulated_time, "timetable", interrupted)
    with pytest.raises(KeyboardInterrupt):
        scheduler.run(3600 * 1000 * MS, None)
    assert clock.time < 10_000 * MS
