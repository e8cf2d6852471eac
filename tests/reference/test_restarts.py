"""Runs in which a component dies or is restarted."""

from __future__ import annotations

from math import hypot

import pytest
from pipeline import LOCALIZED, at_end, build, goal, profile

from refnav.geometry import Pose
from rtgen.runtime import ERROR_STATE, INACTIVE_STATE, SECOND, System

TARGET = (2.0, 1.0, 0.5)


def restart(system: System, instance: str, seconds: float) -> None:
    """Deactivate a component, and activate it again some time later."""
    system.deactivate(instance)
    system.run(system.time + round(seconds * SECOND))
    assert system.state(instance) is INACTIVE_STATE
    system.activate(instance)


def away(system: System, truth: str) -> float:
    goal_pose = system.observable("PositionInput0.goal")
    pose = Pose(*system.observable(truth))
    return hypot(pose.x - goal_pose[0], pose.y - goal_pose[1])


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seconds", [pytest.param(0.05, marks=pytest.mark.slow), 2.0])
@pytest.mark.parametrize(
    "instance",
    ["PositionInput0", "OmniTo2WD0", "Navigation0", "PathFollower0", "RefHardRh30"],
)
def test_a_restart_leads_to_the_goal(instance: str, seconds: float) -> None:
    with build(profile(), goal(*TARGET)) as system:
        system.run(6 * SECOND)
        assert 0.5 < away(system, "RefHardRh30.truth") < 1.9
        restart(system, instance, seconds)
        assert system.run(60 * SECOND, at_end)
        assert away(system, "RefHardRh30.truth") < 0.05


@pytest.mark.sampled(0)
@pytest.mark.parametrize("seconds", [0.05, 2.0])
def test_odometry_that_begins_anew_ends_the_travel(seconds: float) -> None:
    with build(profile(), goal(*TARGET)) as system:
        system.run(6 * SECOND)
        restart(system, "Odometry0", seconds)
        assert not system.run(40 * SECOND, at_end)
        assert system.state("Navigation0") is ERROR_STATE
        reason = system.statistics("Navigation0").reason
        assert "was its source restarted?" in reason
        assert system.observable("RefHardRh30.wheels") == (0.0, 0.0)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("instance", ["Odometry0", "Navigation0"])
def test_without_position_or_waypoints_the_base_stops(instance: str) -> None:
    with build(profile(), goal(*TARGET)) as system:
        system.run(6 * SECOND)
        system.context(instance).fail_component(system.component(instance), "dead")
        begin = Pose(*system.observable("RefHardRh30.truth"))
        system.run(system.time + 30 * SECOND)
        end = Pose(*system.observable("RefHardRh30.truth"))
        # 0.5 s at 0.3 m/s, and the way to a stop.
        assert hypot(end.x - begin.x, end.y - begin.y) < 0.2
        assert system.observable("RefHardRh30.wheels") == (0.0, 0.0)


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "instance", ["OdometryRh20", "LocalizeCenter0", "CeilingNavigation0"]
)
def test_a_restart_of_the_localisation_leads_to_the_goal(instance: str) -> None:
    with build(profile(LOCALIZED), goal(2.0, 0.0, 0.0)) as system:
        truth = profile_truth()
        system.run(5 * SECOND)
        assert 0.5 < away(system, truth) < 1.9
        restart(system, instance, 0.5)
        assert system.run(100 * SECOND, at_end)
        assert away(system, truth) < 0.05


def profile_truth() -> str:
    return dict(profile(LOCALIZED).properties)["rtgen.run.pose"]


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "target",
    [pytest.param((1.3, 2.1, 0.4), marks=pytest.mark.nightly), (2.6, 1.2, -1.0)],
)
def test_a_goal_between_the_nodes_of_the_map_is_driven_to(
    target: tuple[float, float, float],
) -> None:
    with build(profile(LOCALIZED), goal(*target)) as system:
        assert system.run(200 * SECOND, at_end)
        assert away(system, profile_truth()) < 0.05
