"""Locks of ports: a condition variable in real time, no lock in simulated time."""

from __future__ import annotations

import threading
from _thread import RLock
from collections.abc import Callable
from types import TracebackType
from typing import Protocol

from rtgen.runtime.timing.stepping_aside import step_aside


class Guard(Protocol):
    """The part of `threading.Condition` that ports and buffers use."""

    def __enter__(self) -> bool: ...

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
        /,
    ) -> None: ...

    def wait_for(
        self, predicate: Callable[[], bool], timeout: float | None = None
    ) -> bool:
        """Wait until the predicate holds, at most `timeout` seconds; return whether it holds."""

    def notify_all(self) -> None: ...


class ThreadsGuard(RLock):  # type: ignore[misc]
    """A guard for several threads: a lock without a line of Python while none waits."""

    def __init__(self) -> None:
        self._condition: threading.Condition | None = None

    def wait_for(
        self, predicate: Callable[[], bool], timeout: float | None = None
    ) -> bool:
        if predicate():
            return True
        if self._condition is None:
            self._condition = threading.Condition(self)
        step_aside()
        return self._condition.wait_for(predicate, timeout)

    def notify_all(self) -> None:
        if self._condition is not None:
            self._condition.notify_all()


class SingleThread:
    """A guard for a single thread; it never waits, since nothing could end the wait."""

    __slots__ = ()

    def __enter__(self) -> bool:
        return True

    def __exit__(self, *exception: object) -> None:
        return None

    def wait_for(
        self, predicate: Callable[[], bool], timeout: float | None = None
    ) -> bool:
        return predicate()

    def notify_all(self) -> None:
        return None


SINGLE_THREAD = SingleThread()
