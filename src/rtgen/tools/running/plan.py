"""What a run of a system consists of, from its files and the options of `rtgen run`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from rtgen.compiler.diagnostics import (
    InputError,
    Severity,
    Span,
    has_errors,
    in_order,
)
from rtgen.compiler.model import System
from rtgen.compiler.project import (
    FILE_NAME,
    Project,
    cache,
    changed_inputs,
    load,
    load_around,
)
from rtgen.compiler.systems import conditions, timeline
from rtgen.compiler.systems.checks import check_properties
from rtgen.compiler.systems.conditions import Condition
from rtgen.compiler.systems.measures import Measure
from rtgen.compiler.systems.reading import read_file
from rtgen.compiler.systems.rules import CONDITION
from rtgen.compiler.systems.timeline import SetParameter, Step
from rtgen.facts.extras import installation
from rtgen.runtime.services.transports import ForeignComponent
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, Refusal, ReportedError
from rtgen.tools.kit.files import require_different, results_of, values_file
from rtgen.tools.running import foreign, partition
from rtgen.tools.running.curves import divided
from rtgen.tools.running.factories import Factories
from rtgen.tools.running.failures import FailureOptions
from rtgen.tools.running.live_options import LiveOptions
from rtgen.tools.running.recording_options import RecordingOptions
from rtgen.tools.running.trajectory import check_picture, check_writable
from rtgen.tools.running.transports import TransportOptions

if TYPE_CHECKING:
    from rtgen.compiler.judging import Judge
    from rtgen.tools.running.ros2_boards import Boards


BOARDS = FILE_NAME
"""In place of a system, the file of a project: its boards alone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """The options of `rtgen run`, as its help describes them; `system` may be a `BOARDS`.

    `until_at` is the place of `until` in rtgen.toml. `follows_ros`: the simulated time is that of
    ROS 2's topic `/clock`.
    """

    system: str
    simulated: bool = True
    follows_ros: bool = False
    until: str | None = None
    until_at: Span | None = None
    settings: tuple[str, ...] = ()
    timeline_file: str | None = None
    table: tuple[str, ...] = ()
    picture: tuple[str, ...] = ()
    log: str | None = None
    as_json: bool = False
    checkpoints: str | None = None
    check_values: str = "first"
    inactive: bool = False
    recording: RecordingOptions = field(default_factory=RecordingOptions)
    ros2: str | None = None
    live: LiveOptions = field(default_factory=LiveOptions)
    carrying: TransportOptions = field(default_factory=TransportOptions)
    shown_failures: FailureOptions = field(default_factory=FailureOptions)

    @property
    def needs_end(self) -> bool:
        """Whether the run needs a limit: simulated time at full speed does."""
        return self.simulated and self.ros2 is None


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """A run before it begins.

    `finishing` are the instances whose ERROR is the end of their work, by the system.
    `boards` are those that ROS 2 shows. `values` are the parameters of `--set`; `outside` are the
    instances that rtgen does not run, `awaited` those of other processes.
    """

    options: RunOptions
    profile: System
    steps: Sequence[Step]
    measures: Sequence[Measure]
    condition: Condition
    finishing: frozenset[str]
    values: Sequence[SetParameter]
    project: Project
    factories: Factories
    outside: frozenset[str]
    awaited: Sequence[ForeignComponent] = ()
    boards: Boards | None = None

    @property
    def folder(self) -> Path | None:
        """The folder of an experiment, whose results have default files."""
        path = Path(self.options.system)
        return path if path.is_dir() else None

    def of_this_process(self) -> Plan:
        """Return the part of the system that this process runs. Raises InputError, Refusal."""
        carrying = self.options.carrying
        if carrying.only is None and not self.outside:
            return self
        here = partition.named(carrying.only, self.profile, self.outside)
        data = carrying.joins_data
        partition.require_here(self.values, here)
        asked = self.options.until is not None and self.options.until_at is None
        return replace(
            self,
            awaited=foreign.awaited(self.profile, self.outside, here),
            condition=partition.condition_here(self.condition, here, asked=asked),
            steps=partition.steps_here(self.steps, self.profile, here, data=data),
            measures=partition.measures_here(self.measures, here),
            profile=partition.share(self.profile, here, data=data),
        )


def planned(options: RunOptions, console: Console) -> Plan:
    """Return the plan of a whole system. Raises ReportedError, InputError, Refusal, ToolError."""
    carrying, simulated = options.carrying, options.simulated
    carrying.check(simulated=simulated)
    path = Path(options.system)
    alone = options.ros2 is not None and path.name == BOARDS
    project = load(path.parent) if alone else load_around(path)
    profile = nothing(project) if alone else read_system(path, console)
    course = timeline.of_system(path, options.timeline_file, profile)
    console.findings(course.skipped)
    console.findings([*changed_inputs.findings(project)])
    boards = None
    if options.ros2 is not None:
        from rtgen.tools.running import ros2_boards

        boards = ros2_boards.of_project(project)
        if boards is not None:
            console.findings(boards.findings)
            profile = boards.completed(profile, alone=alone)
    if alone and not profile.components:
        raise Refusal(
            "no SYSTEM, no [run] system in rtgen.toml, and no boards for ROS 2"
        )
    require_fitting(project, profile, course.steps, console)
    factories = Factories(project)
    languages = factories.foreign
    plan = Plan(
        options=options,
        profile=profile,
        steps=course.steps,
        measures=course.measures,
        condition=conditions.of_run(options.until, profile, options.until_at),
        finishing=conditions.finishing(profile),
        values=[timeline.assignment(text, profile) for text in options.settings],
        project=project,
        factories=factories,
        outside=frozenset(foreign.named(profile, carrying.foreign, languages)),
        boards=boards,
    )
    if plan.outside:
        foreign.require_reachable(
            profile, plan.outside, carrying, languages, simulated=simulated
        )
    return plan


def nothing(project: Project) -> System:
    """Return a system without components, which has the name of a project's package."""
    file = str(project.root / BOARDS)
    name = project.package
    return System(
        name=name, id="", file=file, abstract="", components=(), connections=()
    )


def read_system(path: str | Path, console: Console) -> System:
    """Read a system, or that of a folder, and report its findings. Raises ReportedError."""
    file = Path(path)
    file = file / "system.xml" if file.is_dir() else file
    profile, diagnostics, sources = read_file(file)
    more = () if profile is None else check_properties(profile)
    findings = [*diagnostics, *more]
    console.findings(in_order(findings), sources)
    if profile is None or has_errors(findings):
        raise ReportedError(BAD_INPUT)
    return profile


def require_fitting(
    project: Project, profile: System, steps: Sequence[Step], console: Console
) -> None:
    """Report what the judge says of a system's connections. Raises ReportedError for errors."""
    from rtgen.compiler.judging import Judge

    judge = Judge(project, cache.default())
    if not is_fitting(judge, profile, steps, console):
        raise ReportedError(BAD_INPUT)


def is_fitting(
    judge: Judge, profile: System, steps: Sequence[Step], console: Console
) -> bool:
    """Report warnings and errors about a system's connections; return whether none is an error."""
    judgement = judge.of_system(profile, steps)
    findings = [d for d in judgement.diagnostics if d.severity is not Severity.NOTE]
    if findings:
        console.findings(in_order(findings), judgement.sources)
    return not judgement.failed


@dataclass(slots=True)
class Outputs:
    """The files of a run's results, and the values of ports in them; None: no such file."""

    csv: str | None
    plot: str | None
    in_table: tuple[str, ...]
    in_picture: tuple[str, ...]

    @classmethod
    def of(cls, plan: Plan) -> Outputs:
        """Return those that the options name. Raises Refusal, ToolError."""
        options, profile = plan.options, plan.profile
        csv, in_table = divided(options.table, "--csv", profile)
        plot, in_picture = divided(options.picture, "--plot", profile)
        csv = csv or (str(values_file(profile.name, ".csv")) if in_table else None)
        plot = plot or (str(values_file(profile.name, ".svg")) if in_picture else None)
        record = options.recording.file
        logs = {"--log": options.log, "--record": record}
        require_different({"--csv": csv, "--plot": plot, **logs}, profile.file)
        check_picture(plot)
        check_writable(csv, options.log, record if options.ros2 is None else None)
        if plan.condition == Condition() and options.needs_end:
            hint = "--until SECONDS, or --until INSTANCE=STATE"
            raise InputError(
                [CONDITION.at(None, "a run in simulated time needs an end", hint=hint)]
            )
        return cls(csv, plot, in_table, in_picture)

    @property
    def has_trajectory(self) -> bool:
        """Whether a file contains poses, not values of ports."""
        return bool(
            (self.csv and not self.in_table) or (self.plot and not self.in_picture)
        )

    @property
    def has_values(self) -> bool:
        """Whether a file contains values of ports."""
        return bool(self.in_table or self.in_picture)

    @property
    def text(self) -> str:
        """The message that names the files."""
        return f"results: {', '.join(filter(None, (self.csv, self.plot)))}"

    def add_defaults(self, folder: Path, console: Console) -> None:
        """Name the files of an experiment's results. Raises ToolError."""
        name = folder.resolve().name
        results = results_of(name)
        self.csv = self.csv or str(results / f"{name}.csv")
        if self.plot is None:
            if find_spec("matplotlib") is not None:
                self.plot = str(results / f"{name}.svg")
            else:
                console.say(f"no picture without matplotlib: {installation('plot')}")
        console.say(self.text)
