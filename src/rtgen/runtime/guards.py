"""What protects a port from two threads at once: a condition in real time, nothing in simulated."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Protocol


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
        """Waits until the predicate holds, at most `timeout` seconds; whether it held."""

    def notify_all(self) -> None: ...


class SingleThread:
    """A guard where nobody else runs: to wait would be to wait for ever, so it never does."""

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
