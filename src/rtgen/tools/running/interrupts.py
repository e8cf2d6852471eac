"""Handles the signals that end a run: orderly shutdown, bounded even if a call hangs."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from rtgen.runtime.system import watchdog
from rtgen.runtime.system.watchdog import Call, Since, calls_under_way, followed
from rtgen.tools.kit.exits import NO
from rtgen.tools.kit.signals import handled, of_ending

_POLL_INTERVAL = 0.1
_REPORT_AFTER = 0.3
"""Seconds after which a call that delays the end of the run is reported."""


class Ending:
    """The signal handler of a run: the first signal ends the run.

    A call that delays the end is reported, then interrupted, then abandoned. Before the run has
    begun, and from the second signal on, KeyboardInterrupt is raised immediately.
    """

    def __init__(self, say: Callable[[Call, str], None]) -> None:
        self._say = say
        self._end_run: Callable[[BaseException], None] | None = None
        self._before_exit: Callable[[], None] | None = None
        self._over = threading.Event()
        self._is_ending = False

    @property
    def interrupted(self) -> bool:
        """Whether a signal has ended the run."""
        return self._is_ending

    def on_signal(
        self,
        end_run: Callable[[BaseException], None],
        before_exit: Callable[[], None] | None = None,
    ) -> None:
        """Set the function that ends the run, and one for the case that it must be abandoned."""
        self._end_run = end_run
        self._before_exit = before_exit

    def close(self) -> None:
        """Stop waiting for calls."""
        self._over.set()

    def signalled(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal, in the main thread."""
        if self._end_run is None or self._is_ending:
            for call in calls_under_way():
                if call.thread == threading.main_thread().ident:
                    self._say(call, "is interrupted")
            raise KeyboardInterrupt
        self._is_ending = True
        self._end_run(KeyboardInterrupt())
        threading.Thread(
            target=self._enforce_end, name="rtgen ending", daemon=True
        ).start()

    def _enforce_end(self) -> None:
        main = threading.main_thread().ident
        seen: dict[int, Since] = {}
        interrupted: Call | None = None
        while not self._over.wait(_POLL_INTERVAL):
            seen = {call.thread: since for call, since in followed(seen)}
            for since in seen.values():
                if since.seconds >= _REPORT_AFTER and not since.reported:
                    since.reported = True
                    self._say(since.call, "has not returned, and the run is to end")
            blocked = seen.get(main) if main is not None else None
            if blocked is None or blocked.seconds < watchdog.PATIENCE:
                continue
            if interrupted is not None and interrupted.frame is blocked.call.frame:
                self._say(blocked.call, "does not end when interrupted; rtgen ends")
                if self._before_exit is not None:
                    self._before_exit()
                sys.stderr.flush()
                os._exit(NO)
            interrupted = blocked.call
            blocked.begin = time.monotonic()
            _interrupt(main)


def _interrupt(thread: int | None) -> None:
    """Make the main thread raise KeyboardInterrupt, even from a system call."""
    if thread is not None and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(thread, signal.SIGINT)
    else:
        interrupt_main()


@contextmanager
def ending(say: Callable[[Call, str], None]) -> Iterator[Ending]:
    """Handle Ctrl-C, SIGTERM and SIGHUP within the block."""
    handler = Ending(say)
    with handled(handler.signalled, signal.SIGINT, *of_ending()):
        try:
            yield handler
        finally:
            handler.close()
