"""Executes the plan of a run, writes its results, and reports how it ended."""

from __future__ import annotations

import shlex
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, InputError, ToolError
from rtgen.compiler.kit.translation import translated_word
from rtgen.compiler.systems import measures
from rtgen.compiler.systems.conditions import Condition
from rtgen.compiler.systems.measures import Measure
from rtgen.compiler.systems.rules import BLOCKED, MEASURE, OBSERVABLE, SKIPPED
from rtgen.runtime.distribution.local_listener import ServedRun
from rtgen.runtime.failures import Failure, ends_run
from rtgen.runtime.services.transports import ForeignTransport, ProcessTransport
from rtgen.runtime.system.recording import JsonLinesRecorder
from rtgen.runtime.system.records import StateRecord
from rtgen.runtime.system.watchdog import Watchdog
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import INTERRUPTED, NO, OK
from rtgen.tools.running import foreign, transports
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.attached import Attached
from rtgen.tools.running.curves import Curves, draw_curves, write_curves
from rtgen.tools.running.failures import FailureReport, logged
from rtgen.tools.running.interrupts import Ending, ending
from rtgen.tools.running.plan import Outputs, Plan
from rtgen.tools.running.progress import Progress, progress
from rtgen.tools.running.recording_options import tell_missing
from rtgen.tools.running.ros2_time import RosTime
from rtgen.tools.running.run_view import View
from rtgen.tools.running.summary import Outcome, as_json, summary
from rtgen.tools.running.texts import ERROR, name_of, planned
from rtgen.tools.running.trajectory import Sample, draw, opened, write_csv

_DEFAULT_LIMIT = 600 * SECOND
"""Limit of a run in simulated time that only waits for a state, in ns."""
_SAMPLE_PERIOD = SECOND // 50
_PROGRESS_PERIOD = SECOND // 10


def executed(plan: Plan, console: Console) -> int:
    """Run a plan to its end; return the exit code. Raises InputError, ToolError, Refusal."""
    outputs = Outputs.of(plan)
    options = plan.options
    clock = runtime.SimulatedClock() if options.simulated else runtime.RealClock()
    report = FailureReport(console, options.shown_failures, simulated=options.simulated)
    with (
        ExitStack() as files,
        logged(report, console, options.shown_failures),
        ending(report.waiting) as end,
        Watchdog(report.blocked),
        transports.opened(
            options.carrying,
            console,
            plan.project.plugins,
            plan.profile,
            simulated=options.simulated,
        ) as transport,
        foreign.expected(transport, plan.awaited),
        assemble(
            plan.profile,
            plan.factories,
            clock,
            plan.values,
            plan.steps,
            transport,
            options.carrying.patience,
            report,
            checkpoints=_checkpoint_folder(options.checkpoints),
            check_values=options.check_values,
            threads=options.live.threads or "shared",
            stay_inactive=options.inactive,
        ) as running,
    ):
        report.end_run = running.end_run
        run = _Run(plan, console, outputs, running, transport, report)
        run.begin(files)
        met, wall = run.run(end)
        unfinished = end.interrupted and not met
        run.tell_end(met=met, interrupted=unfinished)
        if unfinished:
            console.say(_interrupted(plan.condition, running.time))
        outcome = run.outcome(met, wall)
    lacking = run.tell_missing()
    report.close()
    run.draw()
    if options.as_json:
        write_out(as_json(outcome))
    elif not console.quiet:
        write_out(summary(outcome))
    failed = options.shown_failures.counted and (
        report.raised or run.has_failed(outcome)
    )
    if unfinished and not failed:
        return INTERRUPTED
    complete = all(each.kept for each in outcome.measured) and not lacking
    succeeded = met and complete and not outcome.missed and not failed
    return OK if succeeded else NO


class _Run:
    """A run under way, with its observers and the files of its results."""

    def __init__(
        self,
        plan: Plan,
        console: Console,
        outputs: Outputs,
        running: runtime.System,
        transport: ProcessTransport | None,
        report: FailureReport,
    ) -> None:
        self._plan, self._console, self._outputs = plan, console, outputs
        self._running, self._transport, self._report = running, transport, report
        simulated = plan.options.simulated
        # A run limited by --until is not evaluated by its end.
        judged = plan.options.until is None or plan.condition.instance is not None
        self._view = View(
            running,
            plan.profile,
            simulated=simulated,
            judged=judged,
            report=report,
            finishing=plan.finishing,
            transport=transport,
        )
        self._curves = Curves(running, (*outputs.in_table, *outputs.in_picture))
        self._samples: list[Sample] = []
        self._logging: JsonLinesRecorder | None = None
        self._attached = Attached(running)

    def begin(self, files: ExitStack) -> None:
        """Open the files and add the observers, until `files` is closed.

        Raises InputError, ToolError.
        """
        plan, options, outputs = self._plan, self._plan.options, self._outputs
        running, console = self._running, self._console
        of_poses = outputs.has_trajectory
        if of_poses and not self._view.poses:
            message = f"{plan.profile.file}: no property rtgen.run.pose, so there is no trajectory"
            hint = "--plot INSTANCE.PORT and --csv INSTANCE.PORT show values of ports"
            raise InputError([OBSERVABLE.at(None, message, hint=hint)])
        _check_measures(plan.measures, self._view)
        if plan.folder is not None and plan.measures:
            outputs.add_defaults(plan.folder, console)
        bag = options.recording.bag(files, running) if options.ros2 else None
        self._table = opened(files, outputs.csv)
        if (stream := opened(files, options.log)) is not None:
            self._logging = JsonLinesRecorder(stream)
            running.add_listener(self._logging)
        self._recorder = options.recording.begin(files, running, bag)
        name, clock = plan.profile.name, RosTime.of(options)
        rest: Callable[[float], None] = time.sleep
        if options.ros2 is not None:
            from rtgen.tools.running.ros2 import join

            rest = join(
                options.ros2,
                files,
                running,
                plan.project,
                name,
                console,
                clock,
                bag=bag,
                boards=plan.boards,
            )
        if bag is not None:
            running.at(0, bag.begin)
        options.live.begin(files, running, console, name, rest)
        file = str(Path(plan.profile.file).absolute())
        command = shlex.join(["rtgen", *sys.argv[1:]])
        self._served = files.enter_context(
            ServedRun(
                running,
                name,
                file,
                command,
                plan=tuple(map(planned, plan.steps)),
                doc=plan.profile.abstract,
                doing=self._attached,
            )
        )
        self._tell_what_happens()
        if of_poses or plan.measures:
            running.every(
                _SAMPLE_PERIOD, lambda: self._samples.append(self._view.sample())
            )

    def _tell_what_happens(self) -> None:
        """Tell those who are attached of failures, of calls, and of events that were skipped."""
        tell, finishing = self._served.tell, self._plan.finishing
        report = self._running.on_failure

        def on_failure(failure: Failure) -> None:
            if failure.error is not None or failure.instance not in finishing:
                tell("error", failure.instance, failure.text)
            report(failure)

        def on_notice(finding: Diagnostic) -> None:
            if finding.code in (SKIPPED.code, BLOCKED.code):
                kind = "skipped" if finding.code == SKIPPED.code else "blocked"
                tell(kind, "", finding.message)

        self._running.on_failure = on_failure
        self._report.on_notice = on_notice
        self._report.on_call = partial(tell, "call")
        self._attached.tell = tell

    def run(self, end: Ending) -> tuple[bool, float]:
        """Run to the end; return whether the condition was met, and the wall time in seconds."""
        plan, console, report = self._plan, self._console, self._report
        transport = self._transport
        with ExitStack() as shown:
            quiet = console.quiet or console.form != "text"
            bar = progress(shown, plan.condition.limit, quiet=quiet)
            report.before_debugging = shown.close
            shown.enter_context(report.breakpoints())
            shown.callback(_show(self._running, bar, transport, self._view))
            if transport is not None:
                transports.await_others(
                    transport, plan.options.carrying.patience, console
                )
            before_exit = (
                transport.release_foreign
                if isinstance(transport, ForeignTransport)
                else None
            )
            end.on_signal(self._running.end_run, before_exit)
            limit = _limit(plan.condition, plan.options.needs_end)
            self._running.measure_latencies()
            return _run(self._running, plan.condition, report, limit)

    def tell_end(self, *, met: bool, interrupted: bool) -> None:
        """Tell those who are attached that the run is over, and serve it no more."""
        limit = _limit(self._plan.condition, self._plan.options.needs_end)
        self._attached.end(through=limit != self._running.time)
        reason = "it is complete" if met else "it has not met its condition"
        self._served.end("it was interrupted" if interrupted else reason)
        self._served.close()

    def outcome(self, met: bool, wall: float) -> Outcome:
        """Return the outcome, and write the table. `wall` in seconds."""
        plan, outputs = self._plan, self._outputs
        if self._recorder is not None:
            limit = _limit(plan.condition, plan.options.needs_end)
            self._recorder.end(through=limit != self._running.time)
        course = self._view.course(self._samples)
        measured = [measures.evaluate(measure, course) for measure in plan.measures]
        blocked = self._report.still_blocked()
        outcome = self._view.outcome(wall, measured, plan.condition, met, blocked)
        if self._table is not None and outputs.in_table:
            write_curves(self._table, self._curves.of(outputs.in_table))
        elif self._table is not None:
            write_csv(self._table, self._view.robots, self._samples)
        return outcome

    def has_failed(self, outcome: Outcome) -> bool:
        """Return whether a component has ended in ERROR, other than the one of `--until`."""
        condition = self._plan.condition
        awaited = condition.instance if condition.state == ERROR else None
        return any(row.failed and row.instance != awaited for row in outcome.rows)

    def tell_missing(self) -> bool:
        """Report the samples that are missing in files; return whether there are some."""
        options, outputs = self._plan.options, self._outputs
        lacking = options.recording.tell(self._console, self._recorder)
        if self._logging is not None:
            lacking |= tell_missing(
                self._console, options.log or "", self._logging.missing
            )
        file = outputs.csv or outputs.plot or ""
        return tell_missing(self._console, file, self._curves.missing) | lacking

    def draw(self) -> None:
        """Draw the picture. Raises ToolError."""
        outputs, name = self._outputs, self._plan.profile.name
        if outputs.plot is not None and outputs.in_picture:
            curves = self._curves.of(outputs.in_picture)
            draw_curves(outputs.plot, name, curves, self._view.time_axis)
        elif outputs.plot is not None:
            draw(outputs.plot, name, self._view.robots, self._samples)
        if outputs.has_values:
            self._console.say(outputs.text)


def _checkpoint_folder(folder: str | None) -> runtime.CheckpointFolder | None:
    """Return the folder of checkpoints. Raises ToolError."""
    try:
        return None if folder is None else runtime.CheckpointFolder(Path(folder))
    except runtime.CheckpointError as error:
        raise ToolError(str(error)) from error


def _check_measures(required: Sequence[Measure], view: View) -> None:
    names = ", ".join(view.poses) or "none"
    findings = [
        MEASURE.at(
            measure.span,
            f"{name!r} is not a pose of the system",
            hint=f"rtgen.run.pose names: {names}",
        )
        for measure in required
        for name in measure.observables
        if name not in view.poses
    ]
    if findings:
        raise InputError(findings)


def _run(
    running: runtime.System,
    condition: Condition,
    report: FailureReport,
    limit: int | None,
) -> tuple[bool, float]:
    """Run to the end; return whether the condition was met, and the wall time in seconds.

    Ctrl-C, SIGTERM and the debugger's `quit` end a run in order.
    """
    until = _reached(running, condition)
    begun = time.perf_counter()
    try:
        met = running.run(limit, until) or condition.instance is None
    except runtime.ObservableError as error:
        report.cannot_show(error)
        met = False
    except BaseException as error:
        if not ends_run(error):
            raise
        met = condition == Condition()
    return met, time.perf_counter() - begun


def _interrupted(condition: Condition, now: int) -> str:
    """Return the message of a run that a signal ends before its condition; `now` in ns."""
    end = f"at {now / SECOND:.3f} s"
    if condition.instance is None and condition.limit is not None:
        return f"interrupted {end} of {condition.limit / SECOND:g} s"
    return f"interrupted {end}, before {condition.instance}={condition.state}"


def _limit(condition: Condition, needs_end: bool) -> int | None:
    """Return the latest end of a run, in ns."""
    if condition.limit is None and needs_end:
        return _DEFAULT_LIMIT
    return condition.limit


def _reached(
    running: runtime.System, condition: Condition
) -> Callable[[runtime.System], bool] | None:
    if condition.instance is None:
        return None if condition.limit is not None else lambda _: False
    state = runtime.LifeCycleState[f"{condition.state}_STATE"]
    # Evaluated after every instant, so the participant is looked up only once.
    [participant] = running.context(condition.instance).participants
    return lambda _: participant.state is state


def _show(
    running: runtime.System, bar: Progress, transport: object, view: View
) -> Callable[[], None]:
    """Show time and changes of state, until the returned function is called."""
    foreign = transport if isinstance(transport, ForeignTransport) else None
    outside: dict[str, runtime.LifeCycleState] = {}
    changes: deque[StateRecord] = deque()
    ended = False

    def show_changes() -> None:
        while changes:
            _, time, instance, _, state, _, reason = changes.popleft()
            text = translated_word(view.state_text(instance, state, reason))
            bar.state(time, instance, f"{text} ({reason})" if reason else text)

    def changed(record: StateRecord) -> None:
        if ended:
            return
        changes.append(record)
        if isinstance(running.clock, runtime.SimulatedClock):
            show_changes()  # in real time not in the component's thread

    def look() -> None:
        now = running.time
        show_changes()
        bar.at(now)
        for instance, state in (foreign.foreign_states() if foreign else {}).items():
            before = outside.get(instance, runtime.INACTIVE_STATE)
            if state is not None and state is not before:
                outside[instance] = state
                bar.state(now, instance, name_of(state))

    running.watch_states(changed)
    running.every(_PROGRESS_PERIOD, look)

    def end() -> None:
        nonlocal ended
        ended = True
        show_changes()

    return end
