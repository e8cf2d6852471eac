"""Figure 2-5: RH3 drives along a map, with its position corrected by the ceiling."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import pytest
from pipeline import GOAL, LOCALIZED, NAVIGATION, at_end, build, goal, profile

from refnav.geometry import Pose, wrap
from refnav.path_planning import PathPlanning
from rtgen.runtime import SECOND, System

TRUTH = "RefHardRh30.truth"


def away(system: System, x: float, y: float, truth: str = TRUTH) -> float:
    pose = system.observable(truth)
    return hypot(pose[0] - x, pose[1] - y)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Pose, Path]:
    """Return the final pose of the base, and the picture of DispPosition."""
    picture = tmp_path_factory.mktemp("map") / "position.svg"
    system = build(profile(LOCALIZED), [f"DispPosition0.picture={picture}"])
    with system:
        assert system.run(200 * SECOND, at_end)
        return Pose(*system.observable(TRUTH)), picture


@pytest.mark.sampled(0)
def test_the_goal_is_reached_along_the_map(run: tuple[Pose, Path]) -> None:
    pose, _ = run
    assert hypot(pose.x - 3.4, pose.y - 7.7) < 0.05
    assert abs(wrap(pose.theta + 1.57)) < 0.1


@pytest.mark.sampled(0)
def test_the_ceiling_corrects_what_odometry_gets_wrong() -> None:
    # RH2's odometry assumes other wheels than the plant's, so alone it drifts.
    system = build(profile(LOCALIZED))
    with system:
        system.disconnect("CeilingCamera0.CameraData_CeilingNavigation0.CameraData")
        assert system.run(200 * SECOND, at_end)
        assert away(system, 3.4, 7.7) > 0.3


@pytest.mark.sampled(0)
def test_the_picture_shows_map_and_trail(run: tuple[Pose, Path]) -> None:
    text = run[1].read_text(encoding="utf-8")
    assert "<svg" in text
    assert "<!-- trail -->" in text
    assert "<!-- 7 -->" in text


def test_two_runs_are_the_same() -> None:
    poses = []
    for _ in range(2):
        with build(profile(LOCALIZED)) as system:
            system.run(5 * SECOND)
            poses.append(system.observable(TRUTH))
    assert poses[0] == poses[1]
    assert poses[0] != Pose(0.0, 0.0, 0.0)


def test_the_planner_is_swapped_by_rewiring_alone() -> None:
    """OmniTo2WD plans to the first goal, PathPlanning to the second; nothing is stopped."""
    system = build(profile(GOAL), goal(2.0, 0.0, 0.0))
    planner = PathPlanning("PathPlanning0")
    planner.folder = NAVIGATION
    with system:
        system.add(planner, 50.0)
        system.activate("PathPlanning0")
        others = {name: system.component(name) for name in system.instances}
        assert system.run(100 * SECOND, at_end)
        assert away(system, 2.0, 0.0, "RefHardRh30.truth") < 0.05
        for name in (
            "PositionInput0..positon_OmniTo2WD0.goal",
            "Odometry0.OdometryPosition_OmniTo2WD0.current_position",
            "Navigation0.status_OmniTo2WD0.status",
            "OmniTo2WD0.min_path_Navigation0.min_path",
            "OmniTo2WD0.status_PositionInput0.status",
        ):
            system.disconnect(name)
        for source, target in (
            (("PositionInput0", ".positon"), ("PathPlanning0", "goal")),
            (("Odometry0", "OdometryPosition"), ("PathPlanning0", "current_position")),
            (("Navigation0", "status"), ("PathPlanning0", "status")),
            (("PathPlanning0", "min_path"), ("Navigation0", "min_path")),
            (("PathPlanning0", "status"), ("PositionInput0", "status")),
        ):
            system.connect(source, target)
        for name, value in (("01_x", "0.0"), ("01_y", "3.0"), ("01_th", "1.57")):
            system.configure("PositionInput0", name, value)
        system.reset("PositionInput0")
        system.run(system.time + SECOND)
        system.activate("PositionInput0")
        system.run(system.time + SECOND)
        assert system.run(system.time + 100 * SECOND, at_end)
        assert away(system, 0.0, 3.0, "RefHardRh30.truth") < 0.06
        assert {name: system.component(name) for name in system.instances} == others
