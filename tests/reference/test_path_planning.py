"""PathPlanning alone: its plans for goals, paths and maps."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest
from component_bench import Bench

from refnav.path_planning import PathPlanning
from refrobots import iis, rtc
from rtgen.runtime import LifeCycleState

MAP = "n 0 0 0 9\nn 1 2 0 9\nn 2 2 3 9\nn 3 9 9 9\nl 0 1 0\nl 1 2 0\n"


def pose(x: float, y: float, theta: float, *place: int) -> iis.TimedPose2D:
    return iis.TimedPose2D(id=list(place), data=rtc.Pose2D(rtc.Point2D(x, y), theta))


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    (tmp_path / "route_map").write_text(MAP, encoding="utf-8")
    bench = Bench(PathPlanning("PathPlanning0"), 50.0)
    bench.component.folder = tmp_path
    bench.activate()
    return bench


def path(bench: Bench) -> list[tuple[float, float, float]]:
    [sample] = bench.sent("min_path")
    assert sample.velocity == [rtc.Velocity2D(1.0, 0.0, 0.0)] * len(sample.pose)
    return [(p.position.x, p.position.y, p.heading) for p in sample.pose]


def test_headings_are_those_of_arrival_and_the_goal_comes_last(bench: Bench) -> None:
    bench.send("current_position", pose(0.1, -0.2, 1.0))
    bench.send("goal", pose(2.1, 2.8, -1.5))
    bench.run(0.02)
    assert path(bench) == [
        (0.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
        (2.0, 3.0, pi / 2),
        (2.1, 2.8, -1.5),
    ]


def test_a_goal_is_held_until_there_is_a_pose(bench: Bench) -> None:
    bench.send("goal", pose(0.0, 0.0, 0.5))
    bench.run(0.1)
    assert bench.sent("min_path") == []
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.run(0.02)
    assert path(bench) == [(0.0, 0.0, 0.0), (0.0, 0.0, 0.5)]


def test_a_path_goes_through_its_waypoints(bench: Bench) -> None:
    bench.send("current_position", pose(2.0, 0.1, 0.0))
    bench.send("goal", pose(2.0, 3.0, 0.0, 100), pose(0.0, 0.0, 3.0, 102))
    bench.run(0.02)
    assert [point[:2] for point in path(bench)] == [
        (2.0, 0.0),
        (2.0, 3.0),
        (2.0, 0.0),
        (0.0, 0.0),
        (0.0, 0.0),
    ]


def test_no_way_leads_to_error(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("goal", pose(9.0, 9.0, 0.0))
    bench.run(0.04)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert "route_map: no way from node 0 to node 3" in bench.component.reason


def test_finish_is_passed_on_once_for_each_path(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("status", *[rtc.TimedState(data=0)] * 3)
    bench.send("goal", pose(2.0, 0.0, 0.0))
    bench.run(0.02)
    bench.send("current_position", pose(2.0, 0.0, 0.0))
    bench.send("status", *[rtc.TimedState(data=value) for value in (0, 1, 5, 0, 0)])
    bench.run(0.04)
    assert [state.data for state in bench.sent("status")] == [iis.State.FINISH]


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("missing", None, "map_file: missing: No such file or directory"),
        ("long", "#" * 1_048_577, "map_file: long: more than 1048576 characters"),
        ("broken", "n 1\n", "map_file: broken:1: n and 4 finite numbers expected"),
    ],
)
def test_without_map_it_is_not_activated(
    tmp_path: Path, name: str, text: str | None, why: str
) -> None:
    if text is not None:
        (tmp_path / name).write_text(text, encoding="utf-8")
    bench = Bench(PathPlanning("PathPlanning0"), 50.0)
    bench.component.folder = tmp_path
    bench.set(map_file=name)
    bench.activate()
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason == why
