"""The reference systems, assembled as `rtgen run` does it, for tests in simulated time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from refnav.geometry import Pose
from rtgen.compiler import model
from rtgen.compiler.project import load
from rtgen.compiler.systems.reading import read_file
from rtgen.compiler.systems.timeline import assignment
from rtgen.runtime import (
    ERROR_STATE,
    SECOND,
    CheckpointFolder,
    Record,
    SampleRecord,
    SimulatedClock,
    System,
)
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

NAVIGATION = Path(__file__).parents[2] / "specs" / "navigation"
GOAL = NAVIGATION / "rh3_goal.xml"
PATH = NAVIGATION / "rh3_path.xml"
LOCALIZED = NAVIGATION / "map.xml"
MAX_DURATION = 600 * SECOND


def profile(file: Path = GOAL) -> model.System:
    """Return a system as described by its file."""
    system, diagnostics, _ = read_file(file)
    assert system is not None, diagnostics
    assert not diagnostics
    return system


def goal(x: float, y: float, theta: float) -> list[str]:
    """Return the settings for one goal from the parameters."""
    values = {"input": "parameters", "01_x": x, "01_y": y, "01_th": theta}
    return [f"PositionInput0.{name}={value}" for name, value in values.items()]


def placed(start: Pose, base: str) -> list[str]:
    """Return the settings for the pose in which a base starts."""
    return [
        f"{instance}.{name}_{axis}={value}"
        for instance, name in (("Odometry0", "initialPose"), (base, "PlantStart"))
        for axis, value in zip(("x", "y", "theta"), start, strict=True)
    ]


def build(
    system: model.System,
    settings: Iterable[str] = (),
    kept: CheckpointFolder | None = None,
) -> System:
    """Return the system in simulated time, its components INACTIVE."""
    values = [assignment(text, system) for text in settings]
    factories = Factories(load())
    return assemble(system, factories, SimulatedClock(), values, [], checkpoints=kept)


def at_end(system: System) -> bool:
    """Return whether the last command is completed."""
    return system.state("PositionInput0") is ERROR_STATE


def truth(system: System) -> Pose:
    """Return the true pose of the base."""
    return Pose(*system.observable("RefHardRh30.truth"))


@dataclass
class Recording:
    """A complete run: all samples, and the true pose every 10 ms."""

    system: System
    records: list[Record] = field(default_factory=list)
    trajectory: list[tuple[int, Pose]] = field(default_factory=list)

    def samples(self, instance: str, port: str) -> list[tuple[int, Any]]:
        """Return time [ns] and value of all samples of an OutPort."""
        return [
            (record.time, record.value)
            for record in self.records
            if isinstance(record, SampleRecord)
            and (record.instance, record.port) == (instance, port)
        ]

    def between(self, begin: int, end: int) -> list[Pose]:
        """Return true poses from one time to another [ns]."""
        return [pose for time, pose in self.trajectory if begin <= time <= end]


def record(file: Path, settings: Sequence[str] = ()) -> Recording:
    """Run a system until its last command is completed."""
    run = Recording(build(profile(file), settings))
    run.system.add_listener(run.records.append)
    run.system.every(
        SECOND // 100,
        lambda: run.trajectory.append((run.system.time, truth(run.system))),
    )
    assert run.system.run(MAX_DURATION, at_end)
    return run
