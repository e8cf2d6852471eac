"""Navigation alone: its states, step by step, for poses put before it."""

from __future__ import annotations

import pytest
from bench import Bench

from refnav.navigation import Navigation
from refrobots import iis, rtc


def pose(x: float, y: float, theta: float) -> rtc.Pose2D:
    return rtc.Pose2D(rtc.Point2D(x, y), theta)


def plan(*poses: tuple[float, float, float]) -> iis.TimedPath2DSeq:
    return iis.TimedPath2DSeq(pose=[pose(*p) for p in poses])


@pytest.fixture
def bench() -> Bench:
    bench = Bench(Navigation("Navigation0"), 50.0)
    bench.activate()
    return bench


def step(bench: Bench, x: float, y: float, theta: float) -> iis.State:
    """The state after one execution at a pose."""
    bench.sent("status")
    bench.send("position", iis.TimedPose2D(data=pose(x, y, theta)))
    bench.run(0.02)
    [status] = bench.sent("status")
    return iis.State(status.data)


def waypoints(bench: Bench) -> list[tuple[iis.TravelMode, float, float]]:
    return [(iis.TravelMode(p.type), p.v, p.w) for p in bench.sent("path")]


STOP = (iis.TravelMode.RUN_STOP, 0.0, 0.0)
SPIN = (iis.TravelMode.RUN_SPIN, 0.0, 1.0)
FAST = (iis.TravelMode.RUN_LINEFOLLOW, 0.3, 0.0)
SLOW = (iis.TravelMode.RUN_LINEFOLLOW, 0.1, 0.0)


def test_without_a_path_the_state_is_finish_at_every_execution(bench: Bench) -> None:
    bench.sent("status")
    bench.run(1.0)
    assert [status.data for status in bench.sent("status")] == [iis.State.FINISH] * 50
    assert bench.sent("path") == []


def test_turn_straight_turn(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 1.0), (1, 2, 1.0), (1, 2, -1.0)))
    assert step(bench, 0, 0, 0) is iis.State.ANGLE_CHECK
    assert waypoints(bench) == []
    # Element 0 is where the base is: nothing to turn to, nowhere to go.
    assert step(bench, 0, 0, 0) is iis.State.GOAL_CHECK
    assert step(bench, 0, 0, 0) is iis.State.ANGLE_CHECK
    assert waypoints(bench) == [STOP]
    assert step(bench, 0, 0, 0) is iis.State.TURNING
    assert waypoints(bench) == [SPIN]
    assert step(bench, 0, 0, 0.8) is iis.State.TURNING
    assert step(bench, 0, 0, 0.9) is iis.State.GOAL_CHECK
    assert step(bench, 0, 0, 1.0) is iis.State.ANGLE_CHECK
    assert waypoints(bench) == [STOP]
    assert step(bench, 0, 0, 0.95) is iis.State.GOAL_CHECK
    assert step(bench, 0, 0, 1.0) is iis.State.SPEED_DOWN
    assert waypoints(bench) == [FAST]
    assert step(bench, 0.5, 1.0, 1.0) is iis.State.SPEED_DOWN
    assert step(bench, 0.9, 1.8, 1.0) is iis.State.STOPPING
    assert waypoints(bench) == [SLOW]
    assert step(bench, 0.99, 1.99, 1.0) is iis.State.STOPPING
    assert step(bench, 1.01, 2.01, 1.0) is iis.State.ANGLE_CHECK
    assert waypoints(bench) == [STOP]
    assert step(bench, 1.01, 2.01, 1.0) is iis.State.TURNING2
    assert waypoints(bench) == [SPIN]
    assert step(bench, 1.01, 2.01, -0.97) is iis.State.TURNING2
    assert step(bench, 1.01, 2.01, -0.99) is iis.State.FINISH
    assert waypoints(bench) == [STOP]
    assert step(bench, 1.01, 2.01, 0.0) is iis.State.FINISH


def test_the_path_starts_where_the_base_is_by_now(bench: Bench) -> None:
    bench.send("min_path", plan((5, 5, 2), (5, 5, 0.0), (9, 9, 0.0)))
    assert step(bench, 0, 0, 1) is iis.State.ANGLE_CHECK
    assert step(bench, 0, 0, 1) is iis.State.GOAL_CHECK
    assert step(bench, 0, 0, 1) is iis.State.ANGLE_CHECK
    [stop] = bench.sent("path")
    assert (stop.x, stop.y, stop.theta) == (0, 0, 1)


def test_nothing_happens_without_a_new_pose(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 1.0)))
    bench.run(1.0)
    assert bench.sent("path") == []
    assert bench.sent("status")[-1].data == iis.State.ANGLE_CHECK


def test_the_newest_of_several_paths_counts(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 1.0)), plan((0, 0, 0), (0, 0, -2.0)))
    for _ in range(4):
        step(bench, 0, 0, 0)
    assert bench.sent("path")[-1].theta == -2.0


def test_an_empty_path_stops_the_base(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 1.0)))
    step(bench, 0, 0, 0)
    bench.send("min_path", plan())
    assert step(bench, 0, 0, 0) is iis.State.FINISH
    assert waypoints(bench) == [STOP]


def test_speeds_and_distances_follow_the_parameters(bench: Bench) -> None:
    bench.set(max_vel="0.05", judge_radius="0.2")
    bench.send("min_path", plan((0, 0, 0), (1, 0, 0), (1, 0, 0)))
    for _ in range(5):
        step(bench, 0, 0, 0)
    assert waypoints(bench)[-1] == (iis.TravelMode.RUN_LINEFOLLOW, 0.05, 0.0)
    assert step(bench, 0.75, 0, 0) is iis.State.SPEED_DOWN
    assert step(bench, 0.85, 0, 0) is iis.State.STOPPING
    assert waypoints(bench) == [(iis.TravelMode.RUN_LINEFOLLOW, 0.05, 0.0)]


def test_deactivation_forgets_the_path(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 1.0)))
    step(bench, 0, 0, 0)
    bench.deactivate()
    bench.activate()
    assert step(bench, 0, 0, 0) is iis.State.FINISH
    assert waypoints(bench) == []
