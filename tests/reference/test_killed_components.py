"""Each component of RH3 dies during a run without a callback, and restarts from its checkpoint."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import pytest
from pipeline import at_end, build, goal, profile, truth

from rtgen.compiler.project import load
from rtgen.facts.connector_properties import own_properties
from rtgen.runtime import SECOND, CheckpointFolder, System
from rtgen.tools.kit.console import Console
from rtgen.tools.running.assembly import add_component
from rtgen.tools.running.factories import Factories
from rtgen.tools.running.failures import FailureOptions, FailureReport

TARGET = (1.0, 0.5, 0.5)
COMPONENTS = [component.instance for component in profile().components]


def dies(system: System, instance: str) -> None:
    """Remove the component and its connections, without a callback."""
    system.context(instance).stop()
    component = system.component(instance)
    component.exit = lambda: None  # type: ignore[assignment, method-assign, return-value]
    system.remove(instance)


def comes_again(system: System, instance: str) -> None:
    """Start the component again as `rtgen run --only` in a process of its own does."""
    whole = profile()
    [described] = [c for c in whole.components if c.instance == instance]
    report = FailureReport(Console("text", False, False), FailureOptions())
    folder = Path(whole.file).absolute().parent
    add_component(system, described, Factories(load()), folder, report)
    for link in whole.connections:
        if instance in (link.source.instance, link.target.instance):
            ends = [
                (end.instance, end.port.removeprefix(f"{end.instance}."))
                for end in (link.source, link.target)
            ]
            system.connect(ends[0], ends[1], own_properties(link.properties), link.name)
    for text in goal(*TARGET):
        name, _, value = text.partition("=")
        if name.startswith(instance):
            system.configure(instance, name.partition(".")[2], value)
    system.activate(instance)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seconds", [2, 4])
@pytest.mark.parametrize("instance", COMPONENTS)
def test_the_goal_is_reached(instance: str, seconds: int, tmp_path: Path) -> None:
    kept = CheckpointFolder(tmp_path)
    with build(profile(), goal(*TARGET), kept) as system:
        system.run(seconds * SECOND)
        assert hypot(*truth(system)[:2]) < 1.0
        dies(system, instance)
        system.run(system.time + 2 * SECOND)
        comes_again(system, instance)
        assert system.run(60 * SECOND, at_end)
        x, y, theta = truth(system)
        assert hypot(x - TARGET[0], y - TARGET[1]) < 0.05
        assert abs(theta - TARGET[2]) < 0.1


@pytest.mark.sampled(0)
def test_without_checkpoints_the_goal_is_not_reached() -> None:
    with build(profile(), goal(*TARGET)) as system:
        system.run(4 * SECOND)
        dies(system, "OmniTo2WD0")
        comes_again(system, "OmniTo2WD0")
        assert not system.run(60 * SECOND, at_end)
