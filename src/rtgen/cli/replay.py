"""The command `rtgen replay`: plays a recorded run, into a system or to standard output."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import click
from msgspec.structs import replace

from rtgen import runtime
from rtgen.cli.common import (
    BAD_INPUT,
    INTERRUPTED,
    NO,
    OK,
    Console,
    FiniteRange,
    Refusal,
    for_output,
    with_console,
    write_out,
)
from rtgen.cli.log.common import reported, say_losses
from rtgen.cli.running import partition
from rtgen.cli.running.assembly import assemble
from rtgen.cli.running.factories import Factories, Factory
from rtgen.cli.running.failures import (
    FailureOptions,
    FailureReport,
    logged,
    with_failures,
)
from rtgen.cli.running.interrupts import ending
from rtgen.cli.running.pace import RATE, Pace, pace
from rtgen.cli.running.recording_options import (
    RecordingOptions,
    tell_missing,
    with_recording,
)
from rtgen.cli.running.run_view import View
from rtgen.cli.running.summary import summary
from rtgen.cli.running.trajectory import opened
from rtgen.cli.running.value_checks import with_value_checks
from rtgen.diagnostics import Span, has_errors, in_order
from rtgen.model import Connection, PortReference, System, SystemComponent
from rtgen.project import Project, load_around
from rtgen.recording.events import Log
from rtgen.recording.mcap_reader import McapFile
from rtgen.recording.replay import Course, Player, Replay, course_of
from rtgen.runtime.failures import ends_run
from rtgen.runtime.system.recording import JsonLinesRecorder
from rtgen.systems import timeline
from rtgen.systems.checks import check_properties
from rtgen.systems.reading import read_file
from rtgen.systems.timeline import SECOND, Connect, Disconnect, Step

_PLAYER = "rtgen.Player"
_NO_SPAN = Span("", 1, 1, 1, 1)
_MAX_SECONDS = 1e9
"""Maximum duration of a replay in seconds."""


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--into",
    metavar="SYSTEM",
    help="Run components of this system; default: print the events.",
)
@click.option(
    "--only", metavar="INSTANCE,...", help="Run only these components of the system."
)
@click.option(
    "--rate",
    type=RATE,
    metavar="FACTOR",
    help="Speed factor; default: as fast as possible.",
)
@click.option(
    "--until",
    type=FiniteRange(0, _MAX_SECONDS),
    metavar="SECONDS",
    help="Stop at this time of the recording.",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="INSTANCE.PARAMETER=VALUE",
    help="Set a configuration parameter.",
)
@click.option(
    "--log", metavar="FILE", help="Write state changes and samples as JSON lines."
)
@with_value_checks
@with_recording
@with_failures
@with_console
def replay(
    console: Console,
    file: Path,
    into: str | None,
    only: str | None,
    rate: float | None,
    until: float | None,
    settings: tuple[str, ...],
    log: str | None,
    check_values: str,
    recording: RecordingOptions,
    shown_failures: FailureOptions,
) -> int:
    """Replay a run that `rtgen run --record` has recorded, in simulated time.

    With --into, the components of SYSTEM run, and the recorded samples of the other components
    reach their InPorts over the recorded connections. The initial states, parameters and timeline
    of the components are those of SYSTEM. Exit code 1: component code raised an exception.
    """
    if into is None:
        if only or settings or log or recording.file:
            raise Refusal("--only, --set, --log and --record go with --into")
        return _print(console, file, rate, until)
    path = Path(into)
    profile, diagnostics, sources = read_file(
        path / "system.xml" if path.is_dir() else path
    )
    found = [*diagnostics, *(check_properties(profile) if profile is not None else ())]
    console.findings(in_order(found), sources)
    if profile is None or has_errors(found):
        return BAD_INPUT
    plan = timeline.of_system(path, None, profile)
    console.findings(plan.skipped)
    values = [timeline.assignment(text, profile) for text in settings]
    present = frozenset(c.instance for c in profile.components)
    if only is not None:
        present = partition.named(only, profile)
        partition.require_here(values, present)
    steps = _steps(plan.steps, profile, present)
    with reported():
        recorded = McapFile(file)
        course = course_of(recorded)
    say_losses(console, recorded)
    player = Replay(course, present)
    profile = _with_players(profile, course, player, present)
    clock = runtime.SimulatedClock()
    report = FailureReport(console, shown_failures, simulated=True)
    factories = _Factories(load_around(path))
    with (
        reported(),
        ExitStack() as files,
        logged(report, console, shown_failures),
        ending(report.waiting) as end,
        assemble(
            profile,
            factories,
            clock,
            values,
            steps,
            report=report,
            prepare=player.prepare,
            check_values=check_values,
        ) as running,
    ):
        report.end_run = running.end_run
        logging = None
        if (stream := opened(files, log)) is not None:
            logging = JsonLinesRecorder(stream)
            running.add_listener(logging)
        recorder = recording.begin(files, running)
        if rate is not None:
            pace(running, rate)
        end.of(running.end_run)
        unfinished = False
        begun = time.perf_counter()
        try:
            player.run(None if until is None else round(until * SECOND))
        except BaseException as error:
            if not ends_run(error):
                raise
            unfinished = end.interrupted
            if unfinished:
                console.say(f"interrupted at {running.time / SECOND:.3f} s")
        wall = time.perf_counter() - begun
        if recorder is not None:
            recorder.end(through=course.through)
        view = View(running, _plain(profile), simulated=True, judged=False)
        outcome = view.outcome(wall, (), None, report.still_blocked())
    lacking = recording.tell(console, recorder)
    if logging is not None:
        lacking |= tell_missing(console, log or "", logging.missing)
    report.close()
    if not console.quiet:
        rows = [row for row in outcome.rows if row.instance in present]
        write_out(summary(dataclasses.replace(outcome, rows=rows)))
    if report.raised or lacking:
        return NO
    return INTERRUPTED if unfinished else OK


class _Factories(Factories):
    """The factories of a project, and the player's."""

    def __init__(self, project: Project) -> None:
        super().__init__(project)

    def __contains__(self, type_name: str) -> bool:
        return type_name == _PLAYER or super().__contains__(type_name)

    def __getitem__(self, type_name: str) -> Factory:
        return Player if type_name == _PLAYER else super().__getitem__(type_name)


def _with_players(
    profile: System, course: Course, player: Replay, present: Collection[str]
) -> System:
    """Return the system with players for the recorded components that are not present.

    Components and connections are in the recorded order; those not recorded are last.
    """
    own = {c.instance: c for c in profile.components if c.instance in present}
    recorded = {
        each.instance: own.get(each.instance) or _player(each.instance, each.rate)
        for each in course.components
    }
    return replace(
        profile,
        components=tuple((recorded | own).values()),
        connections=tuple(_connections(profile, course, player, present)),
        activation=tuple(a for a in profile.activation if a.instance in present),
    )


def _connections(
    profile: System, course: Course, player: Replay, present: Collection[str]
) -> Iterator[Connection]:
    own = {
        c.name: c
        for c in profile.connections
        if c.source.instance in present and c.target.instance in present
    }
    for recorded in course.beginning(present):
        source, target = map(_reference, (recorded.source, recorded.target))
        if source.instance in present and target.instance in present:
            if recorded.name in own:
                yield own.pop(recorded.name)
        else:
            yield Connection(
                name=recorded.name,
                source=source,
                target=target,
                service=False,
                span=_NO_SPAN,
                properties=tuple(player.properties(recorded).items()),
            )
    yield from own.values()


def _reference(text: str) -> PortReference:
    instance, _, port = text.partition(".")
    return PortReference(instance=instance, port=port)


def _plain(profile: System) -> System:
    """Return the system without observables for the report: players have none."""
    return replace(profile, properties=())


def _player(instance: str, rate: float) -> SystemComponent:
    return SystemComponent(
        instance=instance,
        type=_PLAYER,
        id="",
        path_uri="",
        span=_NO_SPAN,
        rate=rate if rate > 0.0 else 1.0,
    )


def _steps(
    steps: Sequence[Step], profile: System, present: Collection[str]
) -> Sequence[Step]:
    """Return the steps of a timeline that only concern present components."""
    known = {
        c.name
        for c in profile.connections
        if c.source.instance in present and c.target.instance in present
    }
    kept = []
    for step in steps:
        match step.action:
            case Connect(name=name, source=source, target=target):
                if source.instance in present and target.instance in present:
                    known.add(name)
                    kept.append(step)
            case Disconnect(name, others):
                if not known.isdisjoint((name, *others)):
                    kept.append(step)
            case action:
                if action.instance in present:
                    kept.append(step)
    return kept


def _print(
    console: Console, file: Path, rate: float | None, until: float | None
) -> int:
    """Print the events, paced if there is a rate."""
    clock = None if rate is None else Pace(rate)
    with reported():
        log = Log(file)
        for event in _until(log.events(), until):
            if clock is not None:
                clock.wait(event["t"])
            click.echo(for_output(json.dumps(event, ensure_ascii=False)))
    say_losses(console, log)
    return OK


def _until(
    events: Iterator[dict[str, int]], until: float | None
) -> Iterator[dict[str, int]]:
    for event in events:
        if until is not None and event["t"] > until * SECOND:
            return
        yield event
