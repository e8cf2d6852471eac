"""Deadlines of subscriptions, by a clock of the test."""

from __future__ import annotations

from rtgen.runtime.distribution.deadlines import Deadline


class Clock:
    """A clock whose time is set by the test [s]."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_each_period_without_a_sample_counts_once() -> None:
    clock = Clock()
    deadline = Deadline(0.5, clock)
    clock.now += 10
    assert deadline.missed == 0
    deadline.met()
    clock.now += 0.25
    deadline.met()
    clock.now += 0.375
    assert deadline.missed == 0
    clock.now += 0.875
    assert deadline.missed == deadline.missed == 2
    deadline.met()
    clock.now += 0.5
    assert deadline.missed == 3
    deadline.end()
    clock.now += 10
    assert deadline.missed == 3


def test_without_a_deadline_nothing_is_missed() -> None:
    clock = Clock()
    deadline = Deadline(None, clock)
    deadline.met()
    clock.now += 1e6
    assert deadline.missed == 0
