"""Navigation alone: its states, step by step, for given poses."""

from __future__ import annotations

from itertools import groupby

import pytest
from component_bench import Bench

from refnav.navigation import Navigation
from refrobots import iis, rtc
from rtgen.runtime import LifeCycleState


def pose(x: float, y: float, theta: float) -> rtc.Pose2D:
    return rtc.Pose2D(rtc.Point2D(x, y), theta)


def plan(*poses: tuple[float, float, float]) -> iis.TimedPath2DSeq:
    return iis.TimedPath2DSeq(pose=[pose(*p) for p in poses])


@pytest.fixture
def bench() -> Bench:
    bench = Bench(Navigation("Navigation0"), 50.0)
    # Successive poses are farther apart than a base gets in an execution.
    bench.set(MaxJump="0")
    bench.activate()
    return bench


def step(bench: Bench, x: float, y: float, theta: float) -> iis.State:
    """Return the state after one execution at a pose."""
    bench.sent("status")
    bench.send("position", iis.TimedPose2D(data=pose(x, y, theta)))
    bench.run(0.02)
    [status] = bench.sent("status")
    return iis.State(status.data)


def waypoints(bench: Bench) -> list[tuple[iis.TravelMode, float, float]]:
    """Return the sent waypoints, without repetitions."""
    points = [(p.type, p.x, p.y, p.theta, p.v, p.w) for p in bench.sent("path")]
    return [(iis.TravelMode(p[0]), p[4], p[5]) for p, _ in groupby(points)]


STOP = (iis.TravelMode.RUN_STOP, 0.0, 0.0)
SPIN = (iis.TravelMode.RUN_SPIN, 0.0, 1.0)
FAST = (iis.TravelMode.RUN_LINEFOLLOW, 0.3, 0.0)
SLOW = (iis.TravelMode.RUN_LINEFOLLOW, 0.1, 0.0)


def test_there_is_a_state_from_the_first_path_on(bench: Bench) -> None:
    bench.run(1.0)
    assert bench.sent("status") == []
    bench.send("min_path", plan((0, 0, 0), (0, 0, 0)))
    for _ in range(6):
        state = step(bench, 0, 0, 0)
    assert state is iis.State.FINISH
    bench.sent("path")
    bench.run(1.0)
    assert [status.data for status in bench.sent("status")] == [iis.State.FINISH] * 50
    assert bench.sent("path") == []


def test_turn_straight_turn(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 1.0), (1, 2, 1.0), (1, 2, -1.0)))
    assert step(bench, 0, 0, 0) is iis.State.ANGLE_CHECK
    assert waypoints(bench) == []
    # Element 0 is the pose of the base: no turn, no motion.
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
    bench.run(0.02)
    assert waypoints(bench) == [STOP]
    bench.sent("status")
    bench.run(1.0)
    assert bench.sent("status") == []


def test_speeds_and_distances_follow_the_parameters(bench: Bench) -> None:
    bench.set(max_vel="0.05", judge_radius="0.2")
    bench.send("min_path", plan((0, 0, 0), (1, 0, 0), (1, 0, 0)))
    for _ in range(5):
        step(bench, 0, 0, 0)
    assert waypoints(bench)[-1] == (iis.TravelMode.RUN_LINEFOLLOW, 0.05, 0.0)
    assert step(bench, 0.75, 0, 0) is iis.State.SPEED_DOWN
    assert step(bench, 0.85, 0, 0) is iis.State.STOPPING
    assert waypoints(bench) == [(iis.TravelMode.RUN_LINEFOLLOW, 0.05, 0.0)]


def test_deactivation_stops_the_base_and_forgets_the_path(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 1.0)))
    step(bench, 0, 0, 0)
    bench.deactivate()
    assert waypoints(bench) == [STOP]
    bench.activate()
    bench.sent("status")
    bench.run(1.0)
    # No FINISH before a path has been run.
    assert bench.sent("status") == []
    assert waypoints(bench) == []


@pytest.mark.parametrize(("off", "driven"), [(0.04, False), (0.06, True), (0.2, True)])
def test_a_waypoint_farther_than_5_cm_is_driven_to(
    bench: Bench, off: float, driven: bool
) -> None:
    bench.send("min_path", plan((0, 0, 0), (off, 0, 0), (5, 0, 0), (5, 0, 0)))
    for _ in range(5):
        state = step(bench, 0, 0, 0)
    assert (state is iis.State.SPEED_DOWN) == driven
    assert (FAST in waypoints(bench)) == driven


def drive(bench: Bench, *poses: tuple[float, float, float]) -> list[iis.State]:
    return [step(bench, *pose) for pose in poses]


def test_a_goal_passed_at_the_side_is_driven_to(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (1, 0, 0), (1, 0, 0)))
    drive(bench, *[(0, 0, 0)] * 5, (0.9, 0.2, 0), (1.01, 0.2, 0), (1.01, 0.2, 0))
    bench.sent("path")
    states = drive(bench, *[(1.01, 0.2, 0)] * 2)
    assert states[-1] is iis.State.TURNING
    spin = bench.sent("path")[-1]
    assert spin.type == iis.TravelMode.RUN_SPIN
    # Towards the goal, which is behind at the right.
    assert spin.theta == pytest.approx(-1.62, abs=0.01)
    there = (1.0, -0.01, -1.62)
    back = [(1.01, 0.2, -1.62)] * 6
    states = drive(bench, *back, (1.0, 0.01, -1.62), *[there] * 6)
    assert iis.State.FINISH not in states
    assert states[-1] is iis.State.TURNING2
    assert drive(bench, (1.0, 0.0, 0.0)) == [iis.State.FINISH]


def test_a_goal_that_the_path_does_not_lead_to_is_driven_to(bench: Bench) -> None:
    bench.send("min_path", plan((3, 0, 0)))
    states = drive(bench, *[(0, 0, 0)] * 9)
    assert iis.State.FINISH not in states
    assert states[-1] is iis.State.SPEED_DOWN
    [*_, straight] = bench.sent("path")
    assert (straight.x, straight.y, straight.theta) == (3, 0, 0)


def test_a_goal_that_is_not_reached_ends_with_a_reason(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (0, 0, 0)))
    goes_past = [(1.0, 0.3, 0.0), (-1.0, 0.3, 0.0)]
    for number in range(2000):
        if bench.state is LifeCycleState.ERROR_STATE:
            break
        here = goes_past[number // 4 % 2]
        goal = waypoint_heading(bench, here[2])
        bench.send("position", iis.TimedPose2D(data=pose(*here[:2], goal)))
        bench.run(0.02)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason == "the goal is 1.044 m away after 10 approaches"
    assert waypoints(bench)[-1] == STOP


def waypoint_heading(bench: Bench, otherwise: float) -> float:
    """Return the heading of the newest waypoint."""
    sent = bench.sent("path")
    for path in sent:
        bench.asked = path.theta  # type: ignore[attr-defined]
    return getattr(bench, "asked", otherwise)


def test_without_a_position_the_base_is_stopped(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (5, 0, 0), (5, 0, 0)))
    for _ in range(6):
        step(bench, 0, 0, 0)
    assert waypoints(bench)[-1] == FAST
    bench.run(0.4)
    assert set(waypoints(bench)) <= {FAST}
    bench.run(0.4)
    assert waypoints(bench)[-1] == STOP
    condition = bench.system.statistics("Navigation0").condition
    assert condition == "position: nothing newer than 0.5 s"
    step(bench, 0.1, 0, 0)
    bench.run(0.1)
    assert waypoints(bench)[-1] == FAST


def test_a_waypoint_is_sent_again_for_a_follower_that_comes_late(bench: Bench) -> None:
    bench.send("min_path", plan((0, 0, 0), (5, 0, 0), (5, 0, 0)))
    for _ in range(6):
        step(bench, 0, 0, 0)
    bench.sent("path")
    for _ in range(10):
        step(bench, 0, 0, 0)
    sent = bench.sent("path")
    assert len(sent) == 2
    assert {(path.type, path.x, path.v) for path in sent} == {
        (iis.TravelMode.RUN_LINEFOLLOW, 5.0, 0.3)
    }


@pytest.mark.parametrize("there", [(0.4, 0.0, 0.0), (0.0, 0.0, 0.7)])
def test_a_position_that_jumps_ends_the_travel(
    bench: Bench, there: tuple[float, float, float]
) -> None:
    bench.set(MaxJump="0.3")
    bench.send("min_path", plan((0, 0, 0), (5, 0, 0), (5, 0, 0)))
    for _ in range(6):
        step(bench, 0, 0, 0)
    bench.send("position", iis.TimedPose2D(data=pose(*there)))
    bench.run(0.02)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason.startswith("position: jumped from (0.00, 0.00, 0.00)")
    assert waypoints(bench)[-1] == STOP


def test_finish_waits_until_the_pose_has_settled(bench: Bench) -> None:
    bench.set(SettleTime="0.1")
    bench.send("min_path", plan((0, 0, 0), (0, 0, 0)))
    states = drive(bench, *[(0, 0, 0)] * 6)
    assert states[-1] is iis.State.TURNING2
    bench.sent("path")
    # It turns for a late correction of the localisation.
    assert drive(bench, (0, 0, 0.03)) == [iis.State.TURNING2]
    assert waypoints(bench)[-1] == SPIN
    assert iis.State.FINISH not in drive(bench, *[(0, 0, 0)] * 4)
    assert drive(bench, *[(0, 0, 0)] * 4)[-1] is iis.State.FINISH
