"""Reports exceptions in components' code on the console: place, time and traceback."""

from __future__ import annotations

import linecache
import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from traceback import FrameSummary, StackSummary, TracebackException
from typing import Any

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule, Span
from rtgen.compiler.diagnostics.printable import printable
from rtgen.compiler.kit.translation import translated_word
from rtgen.compiler.project import shown
from rtgen.compiler.systems.rules import BLOCKED, CALL, IMPORT, NOTICE, RAISED
from rtgen.compiler.systems.timeline import Call as TimelineCall
from rtgen.compiler.systems.timeline import Step
from rtgen.runtime import Failure, ObservableError
from rtgen.runtime.failures import NOTE, described, ends_run, frames_of
from rtgen.runtime.rtc.logs import LOGGERS, instance_of
from rtgen.runtime.stack_frames import IMPORTING, is_users, own_frames
from rtgen.runtime.system.json_calls import Outcome
from rtgen.runtime.system.watchdog import Call, calls_under_way
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.console import Console
from rtgen.tools.running import factories
from rtgen.tools.running.factories import FactoryImportError
from rtgen.tools.running.texts import outcome_text

_QUIET_STATES = ("on_activated", "on_execute", "on_state_update", "on_rate_changed")
"""Callbacks whose error code leads to ERROR, which the final report shows."""


@dataclass(frozen=True, slots=True)
class FailureOptions:
    """How failures of components are shown; `verbose` counts `-v`.

    `counted`: components in ERROR, and exceptions of their code, make the exit code 1.
    """

    form: str = "short"
    debug: bool = False
    verbose: int = 0
    counted: bool = True


class FailureReport:
    """Prints exceptions of components' code as they happen (see `System.on_failure`).

    With `debug` the debugger opens in the failing frame; afterwards `end_run` is called. In real
    time the debugger opens in `close`, when all components have stopped.
    """

    def __init__(
        self, console: Console, options: FailureOptions, *, simulated: bool = True
    ) -> None:
        self.raised = False
        """Whether a component's code has raised an exception or returned no ReturnCode_t."""
        self.answers: dict[str, str] = {}
        """The reasons with which `on_execute` of instances has returned an error code."""
        self.interrupt: BaseException | None = None
        """The exception raised by a callback that ends the run."""
        self.end_run: Callable[[BaseException], None] = lambda error: None
        self.on_call: Callable[[str, str], None] = lambda instance, text: None
        """Called with the instance and the outcome of each call of the timeline."""
        self.on_notice: Callable[[Diagnostic], None] = lambda diagnostic: None
        """Called with each notice."""
        self.before_debugging: Callable[[], None] = lambda: None
        """Called before the debugger opens, to clear the terminal."""
        self._console = console
        self._options = options
        self._simulated = simulated
        self._to_debug: BaseException | None = None
        self._blocked: dict[str, Call] = {}

    def __call__(self, failure: Failure) -> None:
        """Report a failure of a callback or a servant."""
        error = failure.error
        if error is None:
            if failure.callback == "on_execute":
                self.answers[failure.instance] = failure.reason
            if failure.callback not in _QUIET_STATES and not failure.repeated:
                self.notice(NOTICE.at(None, str(failure)))
            return
        if ends_run(error):
            self.raised = True
            self.interrupt = error
            return
        # Exceptions of a servant (`<port>.<operation>`) are handled by the caller.
        if "." not in failure.callback:
            self.raised = True
        if not failure.repeated:
            self._show(RAISED, str(failure), error, None)
            self._debug(error)

    def cannot_make(
        self, instance: str, callback: str, error: BaseException, span: Span
    ) -> None:
        """Report a component that cannot be constructed. Re-raises exceptions that end a run."""
        if ends_run(error):
            raise error
        self.raised = True
        message = f"{instance}.{callback}: {described(error)}"
        self._show(RAISED, message, error, Related(span, "this component"))
        self._debug(error)

    def cannot_import(self, failed: FactoryImportError, span: Span) -> None:
        """Report a module that cannot be imported."""
        error = failed.__cause__
        assert error is not None
        message = f"{failed.message}: {described(error)}"
        if place(error) is None:
            # The module or its attribute is missing, so there is no line to show.
            holder = getattr(error, "obj", None)
            file = getattr(holder, "__file__", None)
            at = (
                [Related(_span(FrameSummary(file, 1, "")), "the module")]
                if file
                else []
            )
            self._print(IMPORT.at(span, message, related=at, hint=failed.hint), "")
            return
        related = Related(span, "this component")
        self._show(IMPORT, message, error, related, failed.hint)
        self._debug(error)

    def blocked(self, call: Call, seconds: float) -> None:
        """Report a call that does not return."""
        self._blocked[call.instance] = call
        what = f"has not returned for {seconds:.0f} s"
        self.waiting(call, what, hint="Ctrl-C ends the run")

    def waiting(self, call: Call, what: str, hint: str | None = None) -> None:
        """Report a call that is still running."""
        span = _span(FrameSummary(call.file, call.line, call.callback))
        message = f"{call.instance}.{call.callback} {what}"
        self.notice(BLOCKED.at(span, message, hint=hint))

    def called(
        self, time: int, step: Step, call: TimelineCall, outcome: Outcome
    ) -> None:
        """Report the outcome of a call of the timeline, at a time [ns]; a failure counts."""
        said, expected = outcome_text(outcome), call.raises
        self.on_call(call.instance, f"{call.text.text}{said}")
        if expected in (outcome.exception, outcome.exception.rpartition("::")[2]):
            text = f"{time / SECOND:.3f} s: {call.text.text}{said}"
            self._console.say(printable(text))
            return
        self.raised = True
        hint = None
        if expected:
            hint = f"the timeline expects that it raises {expected}"
        elif outcome.exception == "ObjectNotExist":
            hint = "a component serves calls once it is ACTIVE, after its first tick"
        message = f"{call.text.text} at {time / SECOND:.3f} s{said}"
        self.notice(CALL.at(step.span, message, hint=hint))

    def still_blocked(self) -> dict[str, Call]:
        """Return the reported calls that have still not returned, by instance."""
        frames = [call.frame for call in calls_under_way()]
        blocked = self._blocked.items()
        return {name: call for name, call in blocked if call.frame in frames}

    def cannot_show(self, error: ObservableError) -> None:
        """Report an observable that raised."""
        cause = error.__cause__ or error
        self.raised = True
        self._show(RAISED, str(error), cause, None)
        self._debug(cause)

    @contextmanager
    def breakpoints(self) -> Iterator[None]:
        """Make `breakpoint()` clear the terminal first."""

        def opened(*args: Any, **kwargs: Any) -> Any:
            import pdb

            self.before_debugging()
            if os.environ.get("PYTHONBREAKPOINT"):
                return sys.__breakpointhook__(*args, **kwargs)
            return pdb.Pdb().set_trace(sys._getframe(1))

        before, sys.breakpointhook = sys.breakpointhook, opened
        try:
            yield
        finally:
            sys.breakpointhook = before

    def notice(self, diagnostic: Diagnostic) -> None:
        """Print a diagnostic without a summary line."""
        self.on_notice(diagnostic)
        self._print(diagnostic, "")

    def close(self) -> None:
        """Open the debugger for the first failure, if that was postponed."""
        if self._to_debug is not None:
            self._post_mortem(self._to_debug)

    def _show(
        self,
        rule: Rule,
        message: str,
        error: BaseException,
        related: Related | None,
        hint: str | None = None,
    ) -> None:
        at = rule.at(
            place(error), message, related=[related] if related else [], hint=hint
        )
        form = self._options.form
        self._print(at, "" if form == "none" else traceback_text(error, form))

    def _print(self, diagnostic: Diagnostic, following: str) -> None:
        if self._console.form != "text":
            self._console.findings([diagnostic])
            return
        from rtgen.compiler.diagnostics.report import report

        # The traceback already shows the line.
        span = diagnostic.span
        sources = {span.file: ""} if span is not None and following else {}
        text = report([diagnostic], sources, colour=self._console.colour)
        sys.stderr.write(text + following)

    def _debug(self, error: BaseException) -> None:
        if not self._options.debug or error.__traceback__ is None:
            return
        if self._simulated:
            self._post_mortem(error)
            self.end_run(KeyboardInterrupt())
        elif self._to_debug is None:
            self._to_debug = error
            self.end_run(KeyboardInterrupt())

    def _post_mortem(self, error: BaseException) -> None:
        import pdb

        self.before_debugging()
        pdb.post_mortem(error.__traceback__)


def place(error: BaseException) -> Span | None:
    """Return the last line of a user's own file that led to an exception."""
    if isinstance(error, SyntaxError) and error.filename and error.lineno:
        line, column = error.lineno, max(error.offset or 1, 1)
        end = error.end_offset or 0
        file = shown(Path(error.filename))
        same = (error.end_lineno or line) == line and end > column
        return Span(file, line, column, line, end if same else column + 1)
    frames = own_frames(frames_of(error))
    importing = (*IMPORTING, factories.__file__)
    if not frames or frames[-1].filename.startswith(importing):
        return None
    return _span(frames[-1])


def traceback_text(error: BaseException, form: str) -> str:
    """Return the traceback: `short` only has the user's own files, `full` all frames."""
    described = TracebackException.from_exception(error, compact=True)
    if not described.stack:
        described.stack = StackSummary.from_list(frames_of(error))
    todo: list[TracebackException | None] = [described]
    while todo:
        one = todo.pop()
        if one is not None:
            frames = list(one.stack)
            if getattr(one, "filename", None):  # a SyntaxError shows its line itself
                one.filename = shown(Path(one.filename))
                frames = [f for f in frames if is_users(f.filename)]
            elif form == "short":
                frames = own_frames(frames)
            summary = StackSummary.from_list([_relative(f) for f in frames])
            # Without frames, the exception alone is printed.
            one.stack = summary if frames else None  # type: ignore[assignment]
            todo += [one.__cause__, one.__context__, *(one.exceptions or ())]
    return printable("".join(described.format()), "\n\t")


def _relative(frame: FrameSummary) -> FrameSummary:
    """Return the frame with its file name as displayed in messages."""
    _ = frame.line  # read now, while the file name is complete
    path = Path(frame.filename)
    if path.is_absolute() and path.is_relative_to(Path.cwd()):
        frame.filename = shown(path)
    return frame


def _span(frame: FrameSummary) -> Span:
    number = frame.lineno or 1
    text = linecache.getline(frame.filename, number)
    columns = frame.colno, frame.end_colno
    if None in columns or (frame.end_lineno or number) != number:
        begin = len(text) - len(text.lstrip())
        end = len(text.rstrip())
    else:
        # Columns in bytecode count octets.
        octets = text.encode()
        begin, end = (len(octets[:c].decode(errors="replace")) for c in columns)
    file = _relative(FrameSummary(frame.filename, number, frame.name)).filename
    return Span(file, number, begin + 1, number, max(end, begin + 1) + 1)


_FORM = logging.Formatter("%(message)s")


class _LogHandler(logging.Handler):
    """Prints log records of the runtime, and the lines of components."""

    def __init__(self, report: FailureReport, console: Console, form: str) -> None:
        super().__init__()
        self._report = report
        self._console = console
        self._form = form

    def emit(self, record: logging.LogRecord) -> None:
        if instance := instance_of(record):
            text = _FORM.format(record) if self._form != "none" else record.getMessage()
            level = translated_word(record.levelname.lower())
            self._console.repeat(f"{level}: {instance}: {text}")
            return
        if record.levelno < logging.WARNING:
            self._console.say(f"{record.levelname.lower()}: {record.getMessage()}")
            return
        self._report.notice(NOTICE.at(None, record.getMessage()))
        error = record.exc_info[1] if record.exc_info else None
        if error is not None and self._form != "none" and self._console.form == "text":
            sys.stderr.write(traceback_text(error, self._form))


@contextmanager
def logged(
    report: FailureReport, console: Console, options: FailureOptions
) -> Iterator[None]:
    """Print log records within the block: the runtime's warnings and notes, components' lines from
    INFO on; more with -v.
    """
    log = logging.getLogger("rtgen")
    handler = _LogHandler(report, console, options.form)
    before = log.level
    log.setLevel((NOTE, logging.INFO, logging.DEBUG)[min(options.verbose, 2)])
    log.addHandler(handler)
    components = logging.getLogger(LOGGERS)
    components.setLevel(logging.DEBUG if options.verbose else logging.INFO)
    try:
        yield
    finally:
        components.setLevel(logging.NOTSET)
        log.removeHandler(handler)
        log.setLevel(before)
