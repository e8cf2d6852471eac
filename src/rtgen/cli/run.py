"""The command `rtgen run`: runs a system on the embedded runtime."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path

import click

from rtgen import runtime
from rtgen.cli.common import (
    BAD_INPUT,
    INTERRUPTED,
    NO,
    OK,
    Console,
    Refusal,
    WholeRange,
    with_console,
    write_out,
)
from rtgen.cli.running import foreign, partition, supervision, transports
from rtgen.cli.running.assembly import assemble
from rtgen.cli.running.curves import Curves, divided, draw_curves, write_curves
from rtgen.cli.running.factories import Factories
from rtgen.cli.running.failures import (
    FailureOptions,
    FailureReport,
    logged,
    with_failures,
)
from rtgen.cli.running.interrupts import ending
from rtgen.cli.running.live_options import LiveOptions, with_live
from rtgen.cli.running.progress import Progress, progress
from rtgen.cli.running.recording_options import (
    RecordingOptions,
    tell_missing,
    with_recording,
)
from rtgen.cli.running.ros2 import join, with_ros2
from rtgen.cli.running.run_view import View, name_of
from rtgen.cli.running.summary import summary
from rtgen.cli.running.trajectory import (
    Sample,
    check_picture,
    draw,
    opened,
    write_csv,
)
from rtgen.cli.running.transports import TransportOptions, with_transport
from rtgen.cli.running.value_checks import with_value_checks
from rtgen.diagnostics import InputError, ToolError, has_errors, in_order
from rtgen.model import System
from rtgen.project import load_around
from rtgen.runtime.failures import ends_run
from rtgen.runtime.services.transports import ForeignComponent, ForeignTransport
from rtgen.runtime.system.recording import JsonLinesRecorder
from rtgen.runtime.system.watchdog import Watchdog
from rtgen.systems import measures, timeline
from rtgen.systems.checks import check_properties
from rtgen.systems.measures import Measure
from rtgen.systems.reading import read_file
from rtgen.systems.rules import CONDITION, MEASURE, OBSERVABLE
from rtgen.systems.timeline import SECOND, Condition

_DEFAULT_LIMIT = 600 * SECOND
"""Limit of a run in simulated time that only waits for a state, in ns."""
_SAMPLE_PERIOD = SECOND // 50
_PROGRESS_PERIOD = SECOND // 10


@click.command()
@click.argument("system", metavar="SYSTEM")
@click.option(
    "--clock",
    type=click.Choice(["sim", "real"]),
    default="sim",
    show_default=True,
    help="Simulated time, as fast as the machine allows, or real time.",
)
@click.option(
    "--until",
    metavar="SECONDS|INSTANCE=STATE",
    help="End the run at this time or state.",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="INSTANCE.PARAMETER=VALUE",
    help="Set a configuration parameter.",
)
@click.option(
    "--timeline",
    "timeline_file",
    metavar="FILE",
    help="Timeline of the run; default: timeline.toml of the folder.",
)
@click.option(
    "--csv",
    "table",
    multiple=True,
    metavar="FILE|INSTANCE.PORT",
    help="Write the trajectory as CSV, or values of ports and observables.",
)
@click.option(
    "--plot",
    "picture",
    multiple=True,
    metavar="FILE|INSTANCE.PORT",
    help="Draw the trajectory (.svg, .png, .pdf), or values of ports and observables.",
)
@click.option(
    "--log", metavar="FILE", help="Write state changes and samples as JSON lines."
)
@click.option(
    "--checkpoints",
    metavar="FOLDER",
    help="Save the declared state of components there, and restore it at the start.",
)
@click.option(
    "--supervise",
    type=click.Choice(["never", "on-failure"]),
    help="Run each component in its own process, with a restart policy.",
)
@click.option(
    "--group",
    "groups",
    multiple=True,
    metavar="INSTANCE,...",
    help="Components that share a process (--supervise).",
)
@click.option(
    "--restarts",
    type=WholeRange(0, 1000000),
    default=5,
    show_default=True,
    metavar="NUMBER",
    help="Maximum number of consecutive restarts of a process (--supervise).",
)
@with_value_checks
@with_recording
@with_ros2
@with_live
@with_transport
@with_failures
@with_console
def run(
    console: Console,
    system: str,
    clock: str,
    until: str | None,
    settings: tuple[str, ...],
    timeline_file: str | None,
    table: tuple[str, ...],
    picture: tuple[str, ...],
    log: str | None,
    checkpoints: str | None,
    supervise: str | None,
    groups: tuple[str, ...],
    restarts: int,
    check_values: str,
    recording: RecordingOptions,
    ros2: str | None,
    live: LiveOptions,
    carrying: TransportOptions,
    shown_failures: FailureOptions,
) -> int:
    """Run a system on the embedded runtime.

    SYSTEM is an RtsProfile, or a folder with system.xml and optionally timeline.toml. Exit code 0:
    the condition of --until, or of the system's property rtgen.run.until, was met; 1: it was not
    met in time, the robot ended beyond rtgen.run.tolerance, or component code raised an exception;
    3: the module of a component cannot be imported; 130: Ctrl-C or SIGTERM ended it before. A run
    in simulated time that only waits for a state ends after ten minutes.

    --csv and --plot may be repeated: INSTANCE.PORT, INSTANCE.PORT.member and INSTANCE.PORT[index]
    are values over time, anything else is the output file, by default values.csv and values.svg
    below build. Without values, the file contains the trajectory.

    With --transport corba, service calls use omniORB, and components appear as components of
    OpenRTM; with --transport dds or zenoh, samples and calls use DDS or Zenoh. With --only, this
    process runs a part of the system, and exchanges samples and calls with the processes that run
    the rest.
    """
    simulated = clock == "sim"
    carrying.check(simulated=simulated)
    path = Path(system)
    folder = path if path.is_dir() else None
    profile, diagnostics, sources = read_file(path / "system.xml" if folder else path)
    found = [*diagnostics, *(check_properties(profile) if profile is not None else ())]
    console.findings(in_order(found), sources)
    if profile is None or has_errors(found):
        return BAD_INPUT
    plan = timeline.of_system(path, timeline_file, profile)
    console.findings(plan.skipped)
    steps, wanted = plan.steps, plan.measures
    condition = _condition(until, profile)
    values = [timeline.assignment(text, profile) for text in settings]
    project = load_around(path)
    factories = Factories(project)
    languages = factories.foreign
    outside = foreign.named(profile, carrying.foreign, languages)
    awaited: Sequence[ForeignComponent] = ()
    if outside:
        foreign.require_reachable(
            profile, outside, carrying, languages, simulated=simulated
        )
    if supervise is not None:
        context = click.get_current_context()
        supervision.check_options(context)
        if simulated or carrying.transport == "direct":
            raise Refusal(
                "--supervise needs --clock real and --transport corba, dds or zenoh"
            )
        whole = profile
        divided_into = supervision.divided(profile, groups, sorted(outside))
        pairs = [
            (each.instance, text) for each, text in zip(values, settings, strict=True)
        ]
        return supervision.supervise(
            lambda words: supervision.commands(
                *(system, whole, divided_into, condition, until, pairs),
                [*supervision.handed_on(context), *words],
            ),
            supervision.Policy(supervise == "on-failure", restarts),
            console,
            transport=carrying.transport,
            nameserver=carrying.nameserver,
            checkpoints=checkpoints,
        )
    if groups:
        raise Refusal("--group needs --supervise")
    if carrying.only is not None or outside:
        here = partition.named(carrying.only, profile, outside)
        awaited = foreign.awaited(profile, outside, here)
        data = carrying.joins_data
        partition.require_here(values, here)
        condition = partition.condition_here(condition, here, asked=until is not None)
        steps = partition.steps_here(steps, profile, here, data=data)
        wanted = partition.measures_here(wanted, here)
        profile = partition.share(profile, here, data=data)
    csv_file, in_table = divided(table, "--csv", profile)
    plot, in_picture = divided(picture, "--plot", profile)
    csv_file = csv_file or (_result(profile, ".csv") if in_table else None)
    plot = plot or (_result(profile, ".svg") if in_picture else None)
    check_picture(plot)
    if condition == Condition() and simulated:
        hint = "--until SECONDS, or --until INSTANCE=STATE"
        raise InputError(
            [CONDITION.at(None, "a run in simulated time needs an end", hint=hint)]
        )
    watch = runtime.SimulatedClock() if simulated else runtime.RealClock()
    report = FailureReport(console, shown_failures, simulated=simulated)
    with (
        recording.reported(),
        ExitStack() as files,
        logged(report, console, shown_failures),
        ending(report.waiting) as end,
        Watchdog(report.blocked),
        transports.opened(
            carrying, console, project.plugins, profile, simulated=simulated
        ) as transport,
        foreign.expected(transport, awaited),
        assemble(
            profile,
            factories,
            watch,
            values,
            steps,
            transport,
            carrying.patience,
            report,
            checkpoints=_kept(checkpoints),
            check_values=check_values,
        ) as running,
    ):
        report.end_run = running.end_run
        # A run limited by --until is not evaluated by its end.
        judged = until is None or condition.instance is not None
        view = View(
            running, profile, simulated=simulated, judged=judged, transport=transport
        )
        curves = Curves(running, (*in_table, *in_picture))
        of_poses = (csv_file and not in_table) or (plot and not in_picture)
        if of_poses and not view.poses:
            message = (
                f"{profile.file}: no property rtgen.run.pose, so there is no trajectory"
            )
            hint = "--plot INSTANCE.PORT and --csv INSTANCE.PORT show values of ports"
            raise InputError([OBSERVABLE.at(None, message, hint=hint)])
        _check_measures(wanted, view)
        if folder is not None and wanted:
            csv_file, plot = _files(console, folder, csv_file, plot)
        csv_stream = opened(files, csv_file)
        logging = None
        if (log_stream := opened(files, log)) is not None:
            logging = JsonLinesRecorder(log_stream)
            running.add_listener(logging)
        recorder = recording.begin(files, running)
        join(ros2, files, running, project, profile.name, simulated=simulated)
        live.begin(files, running, console, profile.name)
        samples: list[Sample] = []
        if of_poses or wanted:
            running.every(_SAMPLE_PERIOD, lambda: samples.append(view.sample()))
        with ExitStack() as shown:
            quiet = console.quiet or console.form != "text"
            bar = progress(shown, condition.limit, quiet=quiet)
            report.before_debugging = shown.close
            shown.enter_context(report.breakpoints())
            _show(running, bar, transport)
            if transport is not None:
                transports.await_others(transport, carrying.patience, console)
            before_exit = (
                transport.release_foreign
                if isinstance(transport, ForeignTransport)
                else None
            )
            end.of(running.end_run, before_exit)
            met, wall = _run(running, condition, report, simulated=simulated)
        unfinished = end.interrupted and not met
        if unfinished:
            console.say(_interrupted(condition, running.time))
        if recorder is not None:
            recorder.end(through=_limit(condition, simulated) != running.time)
        course = view.course(samples)
        measured = [measures.evaluate(measure, course) for measure in wanted]
        end_met = _end(condition, met)
        blocked = report.still_blocked()
        outcome = view.outcome(wall, measured, end_met, blocked)
        if csv_stream is not None and in_table:
            write_curves(csv_stream, curves.of(in_table))
        elif csv_stream is not None:
            write_csv(csv_stream, view.robots, samples)
    lacking = recording.tell(console, recorder)
    if logging is not None:
        lacking |= tell_missing(console, log or "", logging.missing)
    lacking |= tell_missing(console, csv_file or plot or "", curves.missing)
    report.close()
    if plot is not None and in_picture:
        draw_curves(plot, profile.name, curves.of(in_picture), view.time_axis)
    elif plot is not None:
        draw(plot, profile.name, view.robots, samples)
    if in_table or in_picture:
        console.say(f"results: {', '.join(filter(None, (csv_file, plot)))}")
    if not console.quiet:
        write_out(summary(outcome))
    if unfinished and not report.raised:
        return INTERRUPTED
    kept = all(result.kept for result in measured) and not outcome.missed
    complete = kept and not lacking
    return OK if met and complete and not report.raised else NO


def _kept(folder: str | None) -> runtime.CheckpointFolder | None:
    """Return the folder of checkpoints. Raises ToolError."""
    try:
        return None if folder is None else runtime.CheckpointFolder(Path(folder))
    except runtime.CheckpointError as error:
        raise ToolError(str(error)) from error


def _result(profile: System, ending: str) -> str:
    """Return the default file for values."""
    return str(_results_of(profile.name) / f"values{ending}")


def _results_of(name: str) -> Path:
    """Return the folder for results, created if missing. Raises ToolError."""
    results = Path("build") / name
    try:
        results.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ToolError(f"cannot make {results}: {error.strerror}") from error
    return results


def _files(
    console: Console, folder: Path, csv_file: str | None, plot: str | None
) -> tuple[str, str | None]:
    """Return the default files for the results of an experiment."""
    name = folder.resolve().name
    results = _results_of(name)
    csv_file = csv_file or str(results / f"{name}.csv")
    if plot is None:
        if find_spec("matplotlib") is not None:
            plot = str(results / f"{name}.svg")
        else:
            console.say("no picture without matplotlib: pip install 'rtgen[plot]'")
    console.say(f"results: {', '.join(filter(None, (csv_file, plot)))}")
    return csv_file, plot


def _check_measures(wanted: Sequence[Measure], view: View) -> None:
    known = ", ".join(view.poses) or "none"
    findings = [
        MEASURE.at(
            measure.span,
            f"{name!r} is not a pose of the system",
            hint=f"rtgen.run.pose names: {known}",
        )
        for measure in wanted
        for name in measure.observables
        if name not in view.poses
    ]
    if findings:
        raise InputError(findings)


def _condition(until: str | None, profile: System) -> Condition:
    text = dict(profile.properties).get("rtgen.run.until") if until is None else until
    return Condition() if text is None else timeline.condition(text, profile, None)


def _run(
    running: runtime.System,
    condition: Condition,
    report: FailureReport,
    *,
    simulated: bool,
) -> tuple[bool, float]:
    """Run to the end; return whether the condition was met, and the wall time in seconds.

    Ctrl-C, SIGTERM and the debugger's `quit` end a run in order.
    """
    limit = _limit(condition, simulated)
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


def _limit(condition: Condition, simulated: bool) -> int | None:
    """Return the latest end of a run, in ns."""
    if condition.limit is None and simulated:
        return _DEFAULT_LIMIT
    return condition.limit


def _end(condition: Condition, met: bool) -> tuple[str, str] | None:
    """Return the report's line about a condition on a state."""
    if condition.instance is None:
        return None
    return "met" if met else "not met", f"{condition.instance}={condition.state}"


def _reached(
    running: runtime.System, condition: Condition
) -> Callable[[runtime.System], bool] | None:
    if condition.instance is None:
        return None if condition.limit is not None else lambda _: False
    state = runtime.LifeCycleState[f"{condition.state}_STATE"]
    # Evaluated after every instant, so the participant is looked up only once.
    [participant] = running.context(condition.instance).participants
    return lambda _: participant.state is state


def _show(running: runtime.System, view: Progress, transport: object) -> None:
    known = {instance: running.state(instance) for instance in running.instances}
    foreign = transport if isinstance(transport, ForeignTransport) else None
    outside: dict[str, runtime.LifeCycleState] = {}

    def look() -> None:
        now = running.time
        view.at(now)
        for instance, found in (foreign.foreign_states() if foreign else {}).items():
            before = outside.get(instance, runtime.INACTIVE_STATE)
            if found is not None and found is not before:
                outside[instance] = found
                view.state(now, instance, name_of(found))
        for instance, before in known.items():
            state = running.state(instance)
            if state is not before:
                known[instance] = state
                reason = running.statistics(instance).reason
                is_error = state is runtime.ERROR_STATE and reason
                text = f"{name_of(state)} ({reason})" if is_error else name_of(state)
                view.state(now, instance, text)

    running.every(_PROGRESS_PERIOD, look)
