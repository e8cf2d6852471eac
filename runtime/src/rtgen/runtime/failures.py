"""Failures of components' own code, and how they are reported."""

from __future__ import annotations

import logging
import select
import sys
import traceback
from traceback import FrameSummary
from typing import TextIO

import msgspec

from rtgen.runtime.errors import BlockedError, CallbackError
from rtgen.runtime.stack_frames import own_frames, shown
from rtgen.runtime.timing.clocks import SECOND

log = logging.getLogger("rtgen.runtime")

NOTE = (logging.INFO + logging.WARNING) // 2
"""Log level of messages that users should see, but need not act on."""
logging.addLevelName(NOTE, "NOTE")

ON_ERROR = "on_error"


class Failure(msgspec.Struct, frozen=True):
    """A call of a component's own code that failed, at `time` [ns since the start].

    `error` is the exception, a CallbackError for a callback of another signature, and
    None for a callback that returned a ReturnCode_t other than RTC_OK. `repeated`: the callback
    failed in the same way the last time it failed.
    """

    instance: str
    callback: str
    time: int
    reason: str
    error: BaseException | None = None
    repeated: bool = False

    def __str__(self) -> str:
        what = self.reason if self.error is None else described(self.error)
        return f"{self.instance}.{self.callback} at {self.time / SECOND:.3f} s: {what}"

    @property
    def text(self) -> str:
        """The callback, the place of an exception, and the reason, in one line."""
        if self.reason.startswith(self.callback):
            return self.reason
        return f"{self.callback}{_place(self.error)}: {self.reason}"


def log_failure(failure: Failure) -> None:
    """Log a failure to `rtgen.runtime`; the traceback is only logged once, not for each tick."""
    if failure.error is not None and ends_run(failure.error):
        log.info("%s", failure)  # `run` raises it.
        return
    is_transition = failure.callback.startswith("on_") and failure.callback != ON_ERROR
    if failure.repeated and not is_transition:
        log.debug("%s", failure)
    elif failure.error is None or failure.repeated:
        log.warning("%s", failure)
    elif isinstance(failure.error, CallbackError) and failure.error.code:
        code = failure.error.code
        log.error("%s (%s, line %d)", failure, code.co_filename, code.co_firstlineno)
    else:
        log.error("%s", failure, exc_info=failure.error)


def ends_run(error: BaseException) -> bool:
    """Return whether an exception ends the run.

    These are KeyboardInterrupt, the debugger's `quit`, and a print to a pipe whose reader has gone.
    """
    if isinstance(error, BrokenPipeError):
        return any(map(has_lost_its_reader, (sys.stdout, sys.stderr)))
    debugger = sys.modules.get("bdb")
    return isinstance(error, KeyboardInterrupt) or (
        debugger is not None and isinstance(error, debugger.BdbQuit)
    )


def has_lost_its_reader(stream: TextIO | None) -> bool:
    """Return whether a stream is a pipe without a reader; False if the system cannot tell."""
    if stream is None or not hasattr(select, "poll"):
        return False
    poll = select.poll()
    try:
        poll.register(stream.fileno(), 0)
    except (OSError, ValueError):
        return False  # It is closed, or not a file.
    return any(event & select.POLLERR for _, event in poll.poll(0))


def failed_call(callback: str, error: BaseException, what: str = "") -> str:
    """Return `CALLBACK (FILE:LINE): Kind: message`; `what` replaces the text of the exception."""
    return f"{callback}{_place(error)}: {what or described(error)}"


def frames_of(error: BaseException) -> list[FrameSummary]:
    """Return the frames that led to an exception; of a callback that it names, one at its place."""
    match error:
        case CallbackError(code=code) if code is not None:
            return [FrameSummary(code.co_filename, code.co_firstlineno, code.co_name)]
        case BlockedError():
            return [FrameSummary(error.file, error.line, error.callback)]
    return list(traceback.extract_tb(error.__traceback__))


def _place(error: BaseException | None) -> str:
    """Return ` (FILE:LINE)` of the user's own line that led to an exception; empty if none did."""
    own = own_frames(frames_of(error)) if error is not None else []
    return f" ({shown(own[-1].filename)}:{own[-1].lineno})" if own else ""


def described(error: BaseException) -> str:
    """Return `Kind: message`, or the kind alone; see `encodable`."""
    kind = type(error).__name__
    try:
        text = str(error)
    except Exception:
        text = "(its message cannot be shown: __str__ failed)"
    return encodable(f"{kind}: {text}" if text else kind)


def encodable(text: str) -> str:
    """Return a text with escapes for lone surrogates, such as of names that are not UTF-8.

    No message to another process can have them.
    """
    return text.encode(errors="backslashreplace").decode()
