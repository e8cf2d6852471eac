"""Handlers for Ctrl-C, SIGTERM and SIGHUP, for commands that run until interrupted."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final

_HANGUP: Final[signal.Signals | None] = getattr(signal, "SIGHUP", None)


def of_ending() -> tuple[signal.Signals, ...]:
    """Return the signals besides Ctrl-C that end a command in order.

    The end of the terminal (SIGHUP) is one of them, unless it is ignored as by `nohup`.
    """
    if _HANGUP is None or signal.getsignal(_HANGUP) is signal.SIG_IGN:
        return (signal.SIGTERM,)
    return signal.SIGTERM, _HANGUP


def of_interrupting() -> tuple[signal.Signals, ...]:
    """Return Ctrl-C's signal, unless it is ignored as in the background of a shell."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        return ()
    return (signal.SIGINT,)


@contextmanager
def handled(
    handler: Callable[[int, FrameType | None], None], *numbers: signal.Signals
) -> Iterator[None]:
    """Install a signal handler within the block; does nothing outside the main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = [(number, signal.signal(number, handler)) for number in numbers]
    try:
        yield
    finally:
        for number, old in before:
            signal.signal(number, old)


@contextmanager
def terminable() -> Iterator[None]:
    """Make SIGTERM and SIGHUP raise KeyboardInterrupt, as Ctrl-C does."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    with handled(interrupt, *of_ending()):
        yield
