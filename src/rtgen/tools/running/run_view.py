"""Collects what the report of a run shows: components, poses, lost samples and their causes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rtgen import runtime
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.model import System
from rtgen.compiler.systems import timeline
from rtgen.compiler.systems.measures import Course, Result
from rtgen.compiler.systems.rules import OBSERVABLE, TOLERANCE
from rtgen.compiler.systems.timeline import SECOND
from rtgen.runtime.services.transports import ForeignTransport, LinkReport
from rtgen.tools.running.summary import Outcome, Row, Tolerance
from rtgen.tools.running.trajectory import Pose, Sample

_NO_POSE = (math.nan, math.nan, math.nan)
_POSE = 3


def name_of(state: runtime.LifeCycleState) -> str:
    """Return the name of a state in reports and conditions."""
    return state.name.removesuffix("_STATE")


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


def losses(
    component: runtime.Component, state: runtime.LifeCycleState
) -> Iterator[str]:
    """Yield lost samples of each InPort with cause and remedy, and missed deadlines."""
    for port in component.in_ports.values():
        for connector in port.connectors:
            if connector.lost:
                why = _why_lost(component, state, connector)
                yield f"{port}: {connector.lost} samples of {connector.source} lost: {why}"
            if missed := connector.missed_deadlines:
                within = connector.properties["dataport.qos.deadline"]
                yield (
                    f"{port}: no sample of {connector.source} within {within} s, "
                    f"{missed} times: dataport.qos.deadline"
                )
        if port.lost_when_cut:
            yield (
                f"{port}: {port.lost_when_cut} samples lost on connections that were cut"
            )


def _why_lost(
    component: runtime.Component,
    state: runtime.LifeCycleState,
    connector: runtime.DataConnector[Any],
) -> str:
    full = connector.overwritten + connector.refused
    if full < connector.dropped:
        policy = connector.settings.push_policy.value
        return f"left out by the push policy {policy!r} of the connection"
    if full < connector.missed:
        return (
            "on the way from the other process; dataport.qos.depth keeps more of them"
        )
    length = connector.buffer.settings.length
    what = "newer ones took their place" if connector.overwritten else "write refused"
    if state is not runtime.ACTIVE_STATE:
        do = f"{component.instance_name} is in {name_of(state)} and does not read"
    else:
        do = "read while is_new(), or read_newest(), in each tick"
    return f"the buffer of {length} was full, {what}; {do}"


def overruns(context: runtime.ExecutionContext) -> str:
    """Return why a context missed ticks, with a remedy."""
    longest, period = context.longest / 1e6, context.period / 1e6
    times = f"the longest tick took {longest:.3g} ms of a period of {period:.3g} ms"
    if longest > period:
        return f"{times}; do less in on_execute, or lower the rate"
    return f"ticks began late, the machine was busy; {times}"


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
        transport: object = None,
    ) -> None:
        properties = dict(profile.properties)
        self._running = running
        self._foreign = transport if isinstance(transport, ForeignTransport) else None
        self._simulated = simulated
        names = properties.get("rtgen.run.pose", "").split(",")
        poses = [self._checked(profile, "rtgen.run.pose", n.strip()) for n in names]
        self.poses = [name for name in poses if name]
        goal = properties.get("rtgen.run.goal")
        self._goal_name = self._checked(profile, "rtgen.run.goal", goal)
        tolerance = _tolerance(profile.file, properties.get("rtgen.run.tolerance"))
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
        timeline.require_instance(name.partition(".")[0], profile, span)
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
        end: tuple[str, str] | None,
        blocked: Mapping[str, object],
    ) -> Outcome:
        """Return the outcome.

        `end` is the result of the condition, `blocked` the calls that have not returned.
        """
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
            end=end,
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
        notes += losses(self._running.component(instance), s.state)
        state = name_of(s.state)
        return Row(instance, state, s.ticks, s.overruns, s.lost, notes)

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
            yield Row(instance, text, None, None, lost)

    def _links(self) -> list[str]:
        """Return a line for each connection to another process that has failed."""
        reports = () if self._foreign is None else self._foreign.link_reports()
        return [f"{each.name}: {_times(each)}: {each.reason}" for each in reports]

    def _pose(self, name: str | None) -> Pose | None:
        values = self._running.observable(name) if name else ()
        return (values[0], values[1], values[2]) if len(values) == _POSE else None
