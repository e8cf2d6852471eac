"""Locks of ports: a condition variable in real time, no lock in simulated time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Protocol, TypeVar

from rtgen.runtime.timing.stepping_aside import step_aside

T = TypeVar("T")


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


class ThreadsGuard(threading.Condition):
    """A guard for several threads. It costs little while none waits."""

    def wait_for(self, predicate: Callable[[], T], timeout: float | None = None) -> T:
        result = predicate()
        if result:
            return result
        step_aside()
        return super().wait_for(predicate, timeout)

    def notify_all(self) -> None:
        if self._waiters:  # type: ignore[attr-defined]
            super().notify_all()


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
