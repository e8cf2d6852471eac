"""`rtgen run`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path

import click

from rtgen import compiler, measures, runtime, timeline
from rtgen.cli import shares, transports
from rtgen.cli.assembly import assemble
from rtgen.cli.common import BAD_INPUT, NO, OK, Console, with_console, write_out
from rtgen.cli.factories import Factories
from rtgen.cli.progress import Progress, progress
from rtgen.cli.recording import (
    Pose,
    Sample,
    check_picture,
    draw,
    opened,
    write_csv,
)
from rtgen.cli.signals import terminable
from rtgen.cli.summary import Outcome, Row, summary
from rtgen.cli.transports import TransportOptions, with_transport
from rtgen.diagnostics import InputError, ToolError, has_errors, in_order
from rtgen.measures import Course, Measure, Result
from rtgen.model import System
from rtgen.project import load
from rtgen.runtime.recording import JsonLinesRecorder
from rtgen.system_checks import check_properties
from rtgen.system_rules import CONDITION, MEASURE, OBSERVABLE
from rtgen.timeline import SECOND, Condition, Timeline

_LONGEST = 600 * SECOND
"""Where a run in simulated time ends that waits for a state only."""
_SAMPLE_PERIOD = SECOND // 50
_NOWHERE = (math.nan, math.nan, math.nan)
_LOOK_PERIOD = SECOND // 10


@click.command()
@click.argument("system", metavar="SYSTEM")
@click.option(
    "--clock",
    type=click.Choice(["sim", "real"]),
    default="sim",
    show_default=True,
    help="Simulated time, as fast as the machine allows, or real time.",
)
@click.option("--until", metavar="SECONDS|INSTANCE=STATE", help="When the run ends.")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="INSTANCE.PARAMETER=VALUE",
    help="Give a configuration parameter another value.",
)
@click.option(
    "--timeline",
    "timeline_file",
    metavar="FILE",
    help="What happens meanwhile; by default timeline.toml of the folder.",
)
@click.option("--csv", "csv_file", metavar="FILE", help="Write the trajectory as CSV.")
@click.option("--plot", metavar="FILE", help="Draw the trajectory (.svg, .png, .pdf).")
@click.option(
    "--log", metavar="FILE", help="Write state changes and samples as JSON lines."
)
@with_transport
@with_console
def run(
    console: Console,
    system: str,
    clock: str,
    until: str | None,
    settings: tuple[str, ...],
    timeline_file: str | None,
    csv_file: str | None,
    plot: str | None,
    log: str | None,
    carrying: TransportOptions,
) -> int:
    """Run a system on the embedded runtime.

    SYSTEM is an RtsProfile, or a folder with system.xml and perhaps timeline.toml. Exit code 0:
    the condition of --until, or of the system's property rtgen.run.until, was met; 1: the time
    was over before. A run in simulated time that waits for a state only ends after ten minutes.

    With --transport corba service calls go over omniORB. With --only this process runs a part of
    the system, and calls go to the processes that run the rest.
    """
    simulated = clock == "sim"
    carrying.check(simulated=simulated)
    path = Path(system)
    folder = path if path.is_dir() else None
    profile, diagnostics, sources = compiler.read_system(
        path / "system.xml" if folder else path
    )
    found = [*diagnostics, *(check_properties(profile) if profile is not None else ())]
    console.findings(in_order(found), sources)
    if profile is None or has_errors(found):
        return BAD_INPUT
    plan = _timeline(folder, timeline_file, profile)
    steps, wanted = plan.steps, plan.measures
    check_picture(plot)
    condition = _condition(until, profile)
    values = [timeline.assignment(text, profile) for text in settings]
    if carrying.only is not None:
        here = shares.named(carrying.only, profile)
        shares.require_here(values, here)
        condition = shares.condition_here(condition, here, asked=until is not None)
        steps = shares.steps_here(steps, profile, here)
        wanted = shares.measures_here(wanted, here)
        profile = shares.share(profile, here)
    if condition == Condition() and simulated:
        hint = "--until SECONDS, or --until INSTANCE=STATE"
        raise InputError(
            [CONDITION.at(None, "a run in simulated time needs an end", hint=hint)]
        )
    factories = Factories(load())
    watch = runtime.SimulatedClock() if simulated else runtime.RealClock()
    with (
        ExitStack() as files,
        transports.opened(carrying, console, simulated=simulated) as transport,
        assemble(
            profile, factories, watch, values, steps, transport, carrying.patience
        ) as running,
    ):
        view = _View(running, profile)
        if (csv_file or plot) and not view.poses:
            message = (
                f"{profile.file}: no property rtgen.run.pose, so there is no trajectory"
            )
            raise InputError([OBSERVABLE.at(None, message)])
        _check_measures(wanted, view)
        if folder is not None and wanted:
            csv_file, plot = _files(console, folder, csv_file, plot)
        table = opened(files, csv_file)
        if (log_stream := opened(files, log)) is not None:
            running.add_listener(JsonLinesRecorder(log_stream))
        samples: list[Sample] = []
        if csv_file or plot or wanted:
            running.every(_SAMPLE_PERIOD, lambda: samples.append(view.sample()))
        with ExitStack() as shown:
            quiet = console.quiet or console.form != "text"
            _show(running, progress(shown, condition.limit, quiet=quiet))
            if transport is not None:
                transports.await_others(transport, carrying.patience)
            met, wall = _run(running, condition, simulated=simulated)
        course = view.course(samples)
        measured = [measures.evaluate(measure, course) for measure in wanted]
        outcome = view.outcome(wall, measured)
        if table is not None:
            write_csv(table, view.robots, samples)
    if plot is not None:
        draw(plot, profile.name, view.robots, samples)
    write_out(summary(outcome))
    return OK if met and all(result.kept for result in measured) else NO


def _timeline(folder: Path | None, named: str | None, profile: System) -> Timeline:
    if named is not None:
        return timeline.load(Path(named), profile)
    if folder is not None and (folder / "timeline.toml").is_file():
        return timeline.load(folder / "timeline.toml", profile)
    return Timeline()


def _files(
    console: Console, folder: Path, csv_file: str | None, plot: str | None
) -> tuple[str, str | None]:
    """Where the results of an experiment go, unless the command line says otherwise."""
    name = folder.resolve().name
    results = Path("build") / name
    try:
        results.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ToolError(f"cannot make {results}: {error.strerror}") from error
    csv_file = csv_file or str(results / f"{name}.csv")
    if plot is None:
        if find_spec("matplotlib") is not None:
            plot = str(results / f"{name}.svg")
        else:
            console.say("no picture without matplotlib: pip install 'rtgen[plot]'")
    console.say(f"results: {', '.join(filter(None, (csv_file, plot)))}")
    return csv_file, plot


def _check_measures(wanted: Sequence[Measure], view: _View) -> None:
    known = ", ".join(view.poses) or "none"
    findings = [
        MEASURE.at(
            measure.span,
            f"{name!r} is no pose of the system",
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
    running: runtime.System, condition: Condition, *, simulated: bool
) -> tuple[bool, float]:
    """Runs to the end; whether the condition was met, and the wall time in seconds.

    Ctrl-C and SIGTERM end a run in order.
    """
    limit = condition.limit
    if limit is None and simulated:
        limit = _LONGEST
    until = _reached(running, condition)
    begun = time.perf_counter()
    try:
        with terminable():
            met = running.run(limit, until)
    except KeyboardInterrupt:
        met = condition == Condition()
    else:
        met = met or condition.instance is None
    return met, time.perf_counter() - begun


def _reached(
    running: runtime.System, condition: Condition
) -> Callable[[runtime.System], bool] | None:
    if condition.instance is None:
        return None if condition.limit is not None else lambda _: False
    state = runtime.LifeCycleState[f"{condition.state}_STATE"]
    # Looked at after every instant, so without asking the system by name each time.
    [participant] = running.context(condition.instance).participants
    return lambda _: participant.state is state


def _show(running: runtime.System, view: Progress) -> None:
    known = {instance: running.state(instance) for instance in running.instances}

    def look() -> None:
        now = running.time
        view.at(now)
        for instance, before in known.items():
            state = running.state(instance)
            if state is not before:
                known[instance] = state
                view.state(now, instance, _name(state))

    running.every(_LOOK_PERIOD, look)


def _name(state: runtime.LifeCycleState) -> str:
    return state.name.removesuffix("_STATE")


class _View:
    """What the system's properties say about its report: where the robot is, where it goes."""

    def __init__(self, running: runtime.System, profile: System) -> None:
        properties = dict(profile.properties)
        self._running = running
        names = properties.get("rtgen.run.pose", "").split(",")
        self.poses = [
            n for n in (self._checked(profile, n.strip()) for n in names) if n
        ]
        self._goal_name = self._checked(profile, properties.get("rtgen.run.goal"))

    @property
    def robots(self) -> list[str]:
        """The instances whose poses are shown."""
        return [name.rpartition(".")[0] for name in self.poses]

    def _checked(self, profile: System, name: str | None) -> str | None:
        if name:
            timeline.require_instance(name.partition(".")[0], profile, None)
            try:
                self._running.observable(name)
            except runtime.RtcError as error:
                raise InputError(
                    [OBSERVABLE.at(None, f"{profile.file}: {error}")]
                ) from None
        return name

    def sample(self) -> Sample:
        """The present."""
        poses = tuple(self._pose(name) or _NOWHERE for name in self.poses)
        return Sample(self._running.time / SECOND, poses, self._pose(self._goal_name))

    def course(self, samples: Sequence[Sample]) -> Course:
        """The samples as they are measured."""
        return Course(
            [sample.t for sample in samples],
            {
                name: [sample.poses[number] for sample in samples]
                for number, name in enumerate(self.poses)
            },
        )

    def outcome(self, wall: float, measured: Sequence[Result]) -> Outcome:
        """The end."""
        poses = zip(self.robots, map(self._pose, self.poses), strict=True)
        return Outcome(
            rows=[self._row(instance) for instance in self._running.instances],
            goal=self._pose(self._goal_name),
            poses=[(robot, pose) for robot, pose in poses if pose is not None],
            simulated=self._running.time / SECOND,
            wall=wall,
            measured=measured,
        )

    def _row(self, instance: str) -> Row:
        s = self._running.statistics(instance)
        why = f"waits for {s.awaited}" if s.awaited else s.reason
        return Row(instance, _name(s.state), s.ticks, s.overruns, s.lost, why)

    def _pose(self, name: str | None) -> Pose | None:
        values = self._running.observable(name) if name else ()
        return (values[0], values[1], values[2]) if len(values) == 3 else None
