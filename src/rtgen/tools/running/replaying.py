"""Replays a recorded run into a part of a system, or prints its events."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import Connection, PortReference, System, SystemComponent
from rtgen.compiler.project import Project, load_around
from rtgen.compiler.systems import conditions, timeline
from rtgen.compiler.systems.conditions import Condition
from rtgen.compiler.systems.timeline import Connect, Disconnect, Step
from rtgen.runtime.failures import ends_run
from rtgen.runtime.system.recording import JsonLinesRecorder
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.console import Console, for_output, write_out
from rtgen.tools.kit.exits import INTERRUPTED, NO, OK
from rtgen.tools.kit.files import require_different
from rtgen.tools.recording.bag_files import Recording, open_recording
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.replay import Course, Player, Replay, course_of
from rtgen.tools.recording.selection import Choice, reported, say_losses
from rtgen.tools.running import partition
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.bag_source import BagSource, Source, is_bag
from rtgen.tools.running.factories import Factories, Factory
from rtgen.tools.running.failures import FailureOptions, FailureReport, logged
from rtgen.tools.running.interrupts import Ending, ending
from rtgen.tools.running.pace import Pace, pace
from rtgen.tools.running.plan import read_system, require_fitting
from rtgen.tools.running.recording_options import RecordingOptions, tell_missing
from rtgen.tools.running.run_view import View
from rtgen.tools.running.summary import summary
from rtgen.tools.running.trajectory import check_writable, opened

if TYPE_CHECKING:
    from rtgen.tools.recording.bag_recorder import BagRecorder

_PLAYER = "rtgen.Player"
_NO_SPAN = Span("", 1, 1, 1, 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayOptions:
    """The options of `rtgen replay --into SYSTEM`, as its help describes them."""

    system: str
    only: str | None
    rate: float | None
    until: float | None
    settings: tuple[str, ...]
    log: str | None
    check_values: str
    recording: RecordingOptions
    shown_failures: FailureOptions


def replayed(file: Path, options: ReplayOptions, console: Console) -> int:
    """Replay a recording into a system; return the exit code. Raises InputError, ToolError."""
    profile = read_system(options.system, console)
    plan = timeline.of_system(Path(options.system), None, profile)
    console.findings(plan.skipped)
    project = load_around(Path(options.system))
    require_fitting(project, profile, plan.steps, console)
    values = [timeline.assignment(text, profile) for text in options.settings]
    present = frozenset(c.instance for c in profile.components)
    if options.only is not None:
        present = partition.named(options.only, profile)
        partition.require_here(values, present)
    steps = _steps(plan.steps, profile, present)
    with reported(file):
        recorded = open_recording(file)
        if recorded is None:
            raise RecordingError(f"{file} is not an MCAP file, and no bag of ROS 2")
        source: Source
        if is_bag(recorded):
            source = BagSource(recorded, project, profile, present, console)
        else:
            source = _Run(recorded, profile, present)
    say_losses(console, recorded)
    finishing = conditions.finishing(profile)
    profile = source.profile
    record = options.recording.file
    logs = {"--log": options.log, "--record": record}
    require_different(logs, file, options.system)
    check_writable(options.log, None if source.has_topics else record)
    report = FailureReport(console, options.shown_failures, simulated=True)
    logging = None
    with (
        reported(file),
        ExitStack() as files,
        logged(report, console, options.shown_failures),
        ending(report.waiting) as end,
        assemble(
            profile,
            _Factories(project),
            source.clock,
            values,
            steps,
            report=report,
            prepare=source.prepare,
            check_values=options.check_values,
        ) as running,
    ):
        report.end_run = running.end_run
        bag = options.recording.bag(files, running) if source.has_topics else None
        if (stream := opened(files, options.log)) is not None:
            logging = JsonLinesRecorder(stream)
            running.add_listener(logging)
        recorder = options.recording.begin(files, running, bag)
        source.begin(files, running, bag)
        if options.rate is not None:
            pace(running, options.rate)
        view = View(
            running,
            _plain(profile),
            simulated=True,
            judged=False,
            report=report,
            finishing=finishing,
        )
        end.on_signal(running.end_run)
        begun = time.perf_counter()
        unfinished = _is_interrupted(source, running, options.until, end)
        if unfinished:
            console.say(f"interrupted at {running.time / SECOND:.3f} s")
        wall = time.perf_counter() - begun
        if recorder is not None:
            recorder.end(through=source.through)
        outcome = view.outcome(wall, (), Condition(), False, report.still_blocked())
    lacking = options.recording.tell(console, recorder)
    if logging is not None:
        lacking |= tell_missing(console, options.log or "", logging.missing)
    report.close()
    rows = [row for row in outcome.rows if row.instance in present]
    if not console.quiet:
        write_out(summary(dataclasses.replace(outcome, rows=rows)))
    failed = report.raised or any(row.failed for row in rows)
    if lacking or (failed and options.shown_failures.counted):
        return NO
    return INTERRUPTED if unfinished else OK


def _is_interrupted(
    source: Source, running: runtime.System, until: float | None, end: Ending
) -> bool:
    """Replay to the end, or `until` [s]; return whether a signal ended it."""
    try:
        source.run(running, None if until is None else round(until * SECOND))
    except BaseException as error:
        if not ends_run(error):
            raise
        return end.interrupted
    return False


class _Run:
    """A run that was recorded; see `Source`."""

    has_topics = False

    def __init__(
        self, recorded: Recording, profile: System, present: Collection[str]
    ) -> None:
        course = course_of(recorded)
        self._player = Replay(course, present)
        self.clock = runtime.SimulatedClock()
        self.profile = _with_players(profile, course, self._player, present)
        self.through = course.through
        self.prepare = self._player.prepare

    def begin(
        self, files: ExitStack, running: runtime.System, bag: BagRecorder | None
    ) -> None:
        """See `Source`."""

    def run(self, running: runtime.System, until: int | None) -> None:
        """See `Source`."""
        self._player.run(until)


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
    names = {
        c.name
        for c in profile.connections
        if c.source.instance in present and c.target.instance in present
    }
    result = []
    for step in steps:
        match step.action:
            case Connect(name=name, source=source, target=target):
                if source.instance in present and target.instance in present:
                    names.add(name)
                    result.append(step)
            case Disconnect(name, others):
                if not names.isdisjoint((name, *others)):
                    result.append(step)
            case action:
                if action.instance in present:
                    result.append(step)
    return result


def printed(
    console: Console,
    file: Path,
    rate: float | None = None,
    until: float | None = None,
    choice: Choice | None = None,
) -> int:
    """Print the events, those that are chosen, until a time [s], paced if there is a rate.

    Raises ToolError, InputError.
    """
    clock = None if rate is None else Pace(rate)
    chosen = choice or Choice()
    with reported(file):
        log = Log(file)
        for event in _until(log.events(chosen), until):
            if clock is not None:
                clock.wait(event["t"])
            text = for_output(json.dumps(event, ensure_ascii=False))
            print(text, flush=True)
    say_losses(console, log)
    if until is None:
        chosen.check(file)
    return OK


def _until(
    events: Iterator[dict[str, int]], until: float | None
) -> Iterator[dict[str, int]]:
    for event in events:
        if until is not None and event["t"] > until * SECOND:
            return
        yield event
