"""The newest sample of an InPort and its age, with the age up to which it may be used."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from rtgen.runtime import SECOND, Component, InPort

T = TypeVar("T")


class Newest(Generic[T]):
    """Reads an InPort of samples with a time stamp, and watches the age of the newest one.

    The age counts from the time stamp; without a stamp, or with one in the future, from the
    arrival. `limit` returns the greatest age [s] at which the sample may be used; 0: any age.
    """

    __slots__ = ("_limit", "_port", "_time")

    def __init__(self, port: InPort[Any], limit: Callable[[], float]) -> None:
        self._port = port
        self._limit = limit
        self._time = 0

    def start(self, now: int) -> None:
        """Start at the time `now` [ns], without a sample."""
        self._time = now

    def read(self, now: int) -> T | None:
        """Return the oldest unread sample if it is within the limit, else None."""
        if not self._port.is_new():
            return None
        return self._checked(self._port.read(), now)

    def read_newest(self, now: int) -> T | None:
        """Return the newest unread sample if it is within the limit; older ones count as read."""
        if not self._port.is_new():
            return None
        return self._checked(self._port.read_newest(), now)

    def is_late(self, now: int) -> bool:
        """Return whether the newest sample, or the wait for the first one, is beyond the limit."""
        waited = now - self._time
        return waited > 0 and 0.0 < self._limit() * SECOND < waited

    @property
    def complaint(self) -> str:
        """The condition to report for a late input."""
        return f"{self._port.name}: nothing newer than {self._limit():g} s"

    def _checked(self, sample: Any, now: int) -> T | None:
        if sample is None:
            return None
        tm = sample.tm
        stamp = tm.sec * SECOND + tm.nsec
        time = stamp if 0 < stamp <= now else now
        age = now - time
        if age and 0.0 < self._limit() * SECOND < age:
            return None
        if time > self._time:
            self._time = time
        found: T = sample
        return found


def complaints(now: int, *inputs: Newest[Any]) -> str:
    """Return the condition to report for all late inputs; empty if none is late."""
    return "; ".join(one.complaint for one in inputs if one.is_late(now))


def all_in_time(component: Component, now: int, *inputs: Newest[Any]) -> bool:
    """Return whether no input is late; the component reports late ones."""
    for one in inputs:
        if one.is_late(now):
            component.report(complaints(now, *inputs))
            return False
    component.report("")
    return True
