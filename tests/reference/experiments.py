"""The joint experiments, assembled as `rtgen run` does it, for tests in simulated time."""

from __future__ import annotations

from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from pipeline import profile

from rtgen.compiler.project import load
from rtgen.compiler.systems.conditions import condition
from rtgen.compiler.systems.measures import Course, Pose, Result, evaluate
from rtgen.compiler.systems.timeline import load as load_timeline
from rtgen.runtime import (
    SECOND,
    Component,
    Record,
    SampleRecord,
    SimulatedClock,
    StateRecord,
    System,
)
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

EXPERIMENTS = Path(__file__).parents[2] / "specs" / "experiments"
PERIOD = SECOND // 50


@dataclass
class Experiment:
    """A complete run: poses every 20 ms, measures, changes of state, a hash of all samples.

    `components` are those that existed at the beginning.
    """

    system: System
    components: dict[str, Component]
    course: Course = field(default_factory=lambda: Course([], {}))
    results: list[Result] = field(default_factory=list)
    states: list[StateRecord] = field(default_factory=list)
    digest: str = ""

    def poses(self, instance: str, begin: float, end: float) -> list[Pose]:
        """Return true poses from one time to another [s]."""
        poses = self.course.poses[f"{instance}.truth"]
        return [poses[i] for i in self.course.between(begin, end)]


def perform(
    folder: Path, timeline: str = "timeline.toml", until: float = 0.0
) -> Experiment:
    """Run an experiment to its end, or until a time [s]."""
    system = profile(folder / "system.xml")
    properties = dict(system.properties)
    plan = load_timeline(folder / timeline, system)
    end = condition(properties["rtgen.run.until"], system, None).limit
    assert end is not None
    running = assemble(system, Factories(load()), SimulatedClock(), [], plan.steps)
    run = Experiment(
        running, {name: running.component(name) for name in running.instances}
    )
    times: list[float] = []
    names = [name.strip() for name in properties["rtgen.run.pose"].split(",")]
    poses: dict[str, list[Pose]] = {name: [] for name in names}
    samples = sha256()

    def listen(record: Record) -> None:
        if isinstance(record, SampleRecord):
            samples.update(f"{record.time} {record.instance}.{record.port} ".encode())
            samples.update(record.value.to_cdr())
        else:
            run.states.append(record)

    def look() -> None:
        times.append(running.time / SECOND)
        for name in names:
            x, y, theta = running.observable(name)
            poses[name].append((x, y, theta))

    running.add_listener(listen)
    running.every(PERIOD, look)
    running.run(round(until * SECOND) or end)
    run.course = Course(times, poses)
    run.results = [evaluate(measure, run.course) for measure in plan.measures]
    run.digest = samples.hexdigest()
    return run
