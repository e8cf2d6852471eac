"""Detects code of components that does not return, by inspecting the stacks of all threads.

Nothing is recorded when a callback starts, so ticks cost the same with and without it.
"""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType
from typing import ParamSpec, TypeVar

import msgspec

from rtgen.runtime.failures import log
from rtgen.runtime.rtc.callbacks import succeeds
from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.stack_frames import is_debugger, shown, users_frame

PATIENCE = 2.0
"""Seconds after which a call is reported, and after which a run that ends abandons it."""
_PERIOD = 0.2

P = ParamSpec("P")
T = TypeVar("T")


class Call(msgspec.Struct, frozen=True):
    """A call of a component's code in progress; `file` and `line` are its current place."""

    instance: str
    callback: str
    file: str
    line: int
    thread: int
    frame: FrameType

    def __str__(self) -> str:
        return f"{self.instance}.{self.callback} ({shown(self.file)}, line {self.line})"


def calling(
    instance: str,
    callback: str,
    function: Callable[P, T],
    *args: P.args,
    **kwargs: P.kwargs,
) -> T:
    """Call code of a component other than a callback, such as a constructor, under a name."""
    return function(*args, **kwargs)


def _of_calling(frame: FrameType) -> tuple[str, str]:
    return frame.f_locals["instance"], frame.f_locals["callback"]


def _of_succeeds(frame: FrameType) -> tuple[str, str]:
    return frame.f_locals["component"].instance_name, frame.f_locals["callback"]


def _of_cycle(frame: FrameType) -> tuple[str, str]:
    return frame.f_locals["self"].component.instance_name, "on_execute"


_CALLERS: dict[CodeType, Callable[[FrameType], tuple[str, str]]] = {
    calling.__code__: _of_calling,
    succeeds.__code__: _of_succeeds,
    Participant.cycle.__code__: _of_cycle,
}
"""The functions that call components, with their components."""


def calls_under_way() -> list[Call]:
    """Return the calls of components' code in all threads, except those in the debugger."""
    with _without_collection():
        frames = sys._current_frames()
        return [
            call
            for thread, frame in frames.items()
            if (call := _call_in(thread, frame)) is not None
        ]


def call_in_thread(thread: int) -> Call | None:
    """Return the call of a component's code in a thread, by its identifier."""
    with _without_collection():
        frame = sys._current_frames().get(thread)
        return None if frame is None else _call_in(thread, frame)


@contextmanager
def _without_collection() -> Iterator[None]:
    """Do not collect garbage while frames of other threads are read, in CPython 3.11.

    It can collect garbage while it makes a frame object. If a finalizer then lets another thread
    return from that frame, the process crashes.
    """
    collects = gc.isenabled() and sys.version_info < (3, 12)
    if collects:
        gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _call_in(thread: int, innermost: FrameType) -> Call | None:
    inside: list[FrameType] = []
    frame: FrameType | None = innermost
    while frame is not None:
        find = _CALLERS.get(frame.f_code)
        if find is not None and inside:
            if any(map(is_debugger, inside)):
                return None
            try:
                instance, callback = find(frame)
            except (KeyError, AttributeError):
                return None  # The frame has just started, or is about to end.
            at = users_frame(inside)
            file, line = at.f_code.co_filename, at.f_lineno
            return Call(instance, callback, file, line, thread, frame)
        inside.append(frame)
        frame = frame.f_back
    return None


class Watchdog:
    """Reports calls that take longer than PATIENCE, once each, from a separate thread.

    It inspects all threads of the process; a second instance does nothing.
    """

    _at_work = threading.Lock()

    def __init__(self, report: Callable[[Call, float], None]) -> None:
        self._report = report
        self._end = threading.Event()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> Watchdog:
        self.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()

    def start(self) -> None:
        """Start the thread."""
        if self._at_work.acquire(blocking=False):
            self._thread = threading.Thread(
                target=self._run, name="rtgen watchdog", daemon=True
            )
            self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        if self._thread is not None:
            self._end.set()
            self._thread.join()
            self._thread = None
            self._at_work.release()

    def _run(self) -> None:
        seen: dict[int, Since] = {}
        while not self._end.wait(min(_PERIOD, PATIENCE / 4)):
            seen = {call.thread: since for call, since in followed(seen)}
            for since in seen.values():
                if since.seconds >= PATIENCE and not since.reported:
                    since.reported = True
                    self._report(since.call, since.seconds)


class Since(msgspec.Struct):
    """A call in progress, the time when it was first seen, and whether it was reported."""

    call: Call
    begin: float
    reported: bool = False

    @property
    def seconds(self) -> float:
        """Minimum duration so far in seconds."""
        return time.monotonic() - self.begin


def followed(seen: dict[int, Since]) -> Iterator[tuple[Call, Since]]:
    """Yield the calls in progress; those seen before keep their start time."""
    for call in calls_under_way():
        before = seen.get(call.thread)
        if before is not None and before.call.frame is call.frame:
            before.call = call
            yield call, before
        else:
            yield call, Since(call, time.monotonic())


def log_blocked(call: Call, seconds: float) -> None:
    """Log a call that does not return to `rtgen.runtime`."""
    log.warning("%s has not returned for %.0f s", call, seconds)
