"""Collects what the report of a run shows: components, poses, lost samples and their causes."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

from rtgen import runtime
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.model import System
from rtgen.compiler.systems import conditions
from rtgen.compiler.systems.conditions import Condition
from rtgen.compiler.systems.measures import Course, Result
from rtgen.compiler.systems.rules import OBSERVABLE, TOLERANCE
from rtgen.runtime.services.transports import ForeignTransport, LinkReport
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.running.failures import FailureReport
from rtgen.tools.running.losses import Losses, overruns
from rtgen.tools.running.summary import Outcome, Row, Tolerance
from rtgen.tools.running.texts import ERROR, FINISHED, name_of
from rtgen.tools.running.trajectory import Pose, Sample

_NO_POSE = (math.nan, math.nan, math.nan)
_POSE = 3


def _tolerance(file: str, text: str | None) -> Tolerance | None:
    if text is None:
        return None
    try:
        values = [float(part) for part in text.split(",")]
        if not all(0.0 < value < math.inf for value in values):
            raise ValueError(text)
        return Tolerance(*values)
    except (ValueError, TypeError):
        message = f"{file}: rtgen.run.tolerance is {text[:80]!r}"
        hint = "a distance in m, or a distance and an angle in rad: 0.05, 0.1"
        raise InputError([TOLERANCE.at(None, message, hint=hint)]) from None


def _times(link: LinkReport) -> str:
    """Return what has happened to a connection, and how often."""
    parts = []
    if link.breaks:
        parts.append(f"ended {link.breaks} times, made again {link.renewals} times")
    if link.lost:
        parts.append(f"at least {link.lost} samples lost")
    return ", ".join(parts)


class View:
    """Pose and goal of the robots, as the system's properties define them for the report."""

    def __init__(
        self,
        running: runtime.System,
        profile: System,
        *,
        simulated: bool,
        judged: bool,
        report: FailureReport,
        finishing: Collection[str] = (),
        transport: object = None,
    ) -> None:
        properties = dict(profile.properties)
        self._running = running
        self._report = report
        self._finishing = finishing
        self._losses = Losses(running)
        self._foreign = transport if isinstance(transport, ForeignTransport) else None
        self._simulated = simulated
        names = properties.get(conditions.POSE, "").split(",")
        poses = [self._checked(profile, conditions.POSE, n.strip()) for n in names]
        self.poses = [name for name in poses if name]
        goal = properties.get(conditions.GOAL)
        self._goal_name = self._checked(profile, conditions.GOAL, goal)
        tolerance = _tolerance(profile.file, properties.get(conditions.TOLERANCE))
        if tolerance and not (len(self.poses) == 1 and self._goal_name):
            message = (
                f"{profile.file}: rtgen.run.tolerance needs one pose and one goal;"
                f" rtgen.run.pose names {len(self.poses)}"
            )
            raise InputError([TOLERANCE.at(None, message)])
        self._tolerance = tolerance if judged else None

    @property
    def robots(self) -> list[str]:
        """The instances whose poses are shown."""
        return [name.rpartition(".")[0] for name in self.poses]

    @property
    def time_axis(self) -> str:
        """The label of the time axis in diagrams."""
        return "simulated time [s]" if self._simulated else "time [s]"

    def _checked(self, profile: System, key: str, name: str | None) -> str | None:
        """Check the name of a pose. Raises InputError at the place of the property."""
        if not name:
            return name
        span = profile.places.get(key)
        try:
            values = self._running.observable(name)
        except runtime.RtcError as error:
            raise InputError([OBSERVABLE.at(span, str(error))]) from None
        if len(values) not in (0, _POSE):
            message = (
                f"{key}: {name} is not a pose: a pose has {_POSE} values, "
                f"x [m], y [m] and heading [rad], and {name} has {len(values)}"
            )
            raise InputError([OBSERVABLE.at(span, message)])
        return name

    def sample(self) -> Sample:
        """Return a sample of the current state."""
        poses = tuple(self._pose(name) or _NO_POSE for name in self.poses)
        return Sample(self._running.time / SECOND, poses, self._pose(self._goal_name))

    def course(self, samples: Sequence[Sample]) -> Course:
        """Return the samples in the form that measures are evaluated on."""
        return Course(
            [sample.t for sample in samples],
            {
                name: [sample.poses[number] for sample in samples]
                for number, name in enumerate(self.poses)
            },
        )

    def outcome(
        self,
        wall: float,
        measured: Sequence[Result],
        condition: Condition,
        met: bool,
        blocked: Mapping[str, object],
    ) -> Outcome:
        """Return the outcome; `blocked` are the calls that have not returned."""
        poses = zip(self.robots, map(self._pose, self.poses), strict=True)
        return Outcome(
            rows=[
                *(self._row(name, blocked) for name in self._running.instances),
                *self._foreign_rows(),
            ],
            links=self._links(),
            goal=self._pose(self._goal_name),
            poses=[(robot, pose) for robot, pose in poses if pose is not None],
            time=self._running.time / SECOND,
            wall=wall if self._simulated else None,
            measured=measured,
            tolerance=self._tolerance,
            end=self._end(condition, met),
            latencies=self._running.latencies,
        )

    def _row(self, instance: str, blocked: Mapping[str, object]) -> Row:
        s = self._running.statistics(instance)
        why = f"waits for {s.awaited}" if s.awaited else s.reason or s.condition
        if instance in blocked:
            why = f"{blocked[instance]} has not returned"
        notes = [f"{instance}: {why}"] if why else []
        if s.overruns:
            text = overruns(self._running.context(instance))
            notes.append(f"{instance}: {s.overruns} overruns: {text}")
        notes += self._losses.notes(instance, s.state)
        state = self.state_text(instance, s.state, s.reason)
        failed = state == ERROR
        return Row(instance, state, s.ticks, s.overruns, s.lost, notes, failed)

    def state_text(
        self, instance: str, state: runtime.LifeCycleState, reason: str
    ) -> str:
        """Return a state; `finished` for ERROR that is the end of the component's work.

        It is if the system says so, and if `on_execute` has returned it without an exception.
        """
        is_finishing = state is runtime.ERROR_STATE and instance in self._finishing
        if is_finishing and reason and self._report.answers.get(instance) == reason:
            return FINISHED
        return name_of(state)

    def _end(self, condition: Condition, met: bool) -> tuple[str, str] | None:
        """Return the report's line about a condition on a state."""
        instance = condition.instance
        if instance is None:
            return None
        text = f"{instance}={condition.state}"
        if met and instance in self._running.instances:
            s = self._running.statistics(instance)
            if self.state_text(instance, s.state, s.reason) == FINISHED:
                text = f"{instance} {FINISHED}"
        return "met" if met else "not met", text

    def _foreign_rows(self) -> Iterator[Row]:
        """Yield the components that rtgen does not run, with the samples not delivered to them."""
        if self._foreign is None:
            return
        reports = self._foreign.link_reports()
        for instance, state in self._foreign.foreign_states().items():
            lost = sum(
                each.lost - each.not_received
                for each in reports
                if each.there.instance == instance
            )
            text = "lost" if state is None else name_of(state)
            failed = text == ERROR and instance not in self._finishing
            yield Row(instance, text, None, None, lost, failed=failed)

    def _links(self) -> list[str]:
        """Return a line for each connection to another process that has failed."""
        reports = () if self._foreign is None else self._foreign.link_reports()
        return [f"{each.name}: {_times(each)}: {each.reason}" for each in reports]

    def _pose(self, name: str | None) -> Pose | None:
        values = self._running.observable(name) if name else ()
        return (values[0], values[1], values[2]) if len(values) == _POSE else None
