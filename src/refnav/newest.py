"""The newest sample of an InPort and its age: what a behaviour acts on, and for how long."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from rtgen.runtime import SECOND, Component, InPort

T = TypeVar("T")


class Newest(Generic[T]):
    """Reads an InPort of samples with a time stamp, and knows how old the newest one is.

    A sample is as old as its stamp says; without a stamp, or with one in the future, its age counts
    from its arrival. `limit` gives the greatest age [s] at which it may be acted on; 0: any age.
    """

    __slots__ = ("_limit", "_port", "_time")

    def __init__(self, port: InPort[Any], limit: Callable[[], float]) -> None:
        self._port = port
        self._limit = limit
        self._time = 0

    def start(self, now: int) -> None:
        """Wait for a sample from now [ns] on."""
        self._time = now

    def read(self, now: int) -> T | None:
        """Return the oldest unread sample, None if there is none; one beyond the limit is
        dropped.
        """
        if not self._port.is_new():
            return None
        return self._checked(self._port.read(), now)

    def read_newest(self, now: int) -> T | None:
        """Return the newest unread sample; older ones count as read, one beyond the limit is
        dropped.
        """
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
