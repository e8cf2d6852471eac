"""OmniTo2WD alone: goals, paths, and the one FINISH for each."""

from __future__ import annotations

import pytest
from component_bench import Bench

from refnav.omni_to2_wd import OmniTo2WD
from refrobots import iis, rtc
from rtgen.runtime import LifeCycleState


def pose(x: float, y: float, theta: float, *place: int) -> iis.TimedPose2D:
    return iis.TimedPose2D(id=list(place), data=rtc.Pose2D(rtc.Point2D(x, y), theta))


def state(value: int) -> rtc.TimedState:
    return rtc.TimedState(data=value)


@pytest.fixture
def bench() -> Bench:
    bench = Bench(OmniTo2WD("OmniTo2WD0"), 50.0)
    bench.activate()
    return bench


def path(bench: Bench) -> list[tuple[float, float]]:
    [sample] = bench.sent("min_path")
    return [(p.position.x, p.position.y) for p in sample.pose]


def test_a_goal_is_held_until_there_is_a_pose(bench: Bench) -> None:
    bench.send("goal", pose(1.0, 0.0, 0.0))
    bench.run(0.1)
    assert bench.sent("min_path") == []
    bench.send("current_position", pose(0.5, 0.5, 0.0))
    bench.run(0.02)
    assert path(bench) == [(0.5, 0.5), (0.5, 0.5), (1.0, 0.0), (1.0, 0.0)]
    bench.run(1.0)
    assert bench.sent("min_path") == []


def test_a_path_starts_with_its_last_waypoint(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("goal", pose(1.0, 0.0, 0.0, 100), pose(1.0, 1.0, 0.0, 101))
    bench.run(0.1)
    assert bench.sent("min_path") == []
    bench.send("goal", pose(0.0, 1.0, 0.0, 102))
    bench.run(0.02)
    assert path(bench)[2::2] == [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def test_a_new_first_waypoint_discards_the_path_before(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("goal", pose(9.0, 9.0, 0.0, 100), pose(1.0, 0.0, 0.0, 100))
    bench.send("goal", pose(2.0, 0.0, 0.0, 102))
    bench.run(0.02)
    assert path(bench)[2::2] == [(1.0, 0.0), (2.0, 0.0)]


@pytest.mark.parametrize("place", [101, 102, 7])
def test_a_waypoint_out_of_place_is_an_error(bench: Bench, place: int) -> None:
    bench.send("goal", pose(1.0, 0.0, 0.0, place))
    bench.run(0.02)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason == f"goal: id [{place}] has no place in a path"


def test_finish_is_passed_on_once_for_each_path(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    for _ in range(2):
        bench.send("goal", pose(1.0, 0.0, 0.0))
        bench.run(0.02)
        bench.send("current_position", pose(1.0, 0.0, 0.0))
        bench.send("status", state(iis.State.TURNING), state(iis.State.FINISH))
        bench.send("status", state(iis.State.FINISH))
        bench.run(0.1)
        assert [s.data for s in bench.sent("status")] == [iis.State.FINISH]


def test_a_stale_finish_is_not_taken_for_the_new_path(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("status", state(iis.State.FINISH))
    bench.send("goal", pose(1.0, 0.0, 0.0))
    bench.run(0.02)
    bench.send("status", state(iis.State.FINISH))
    bench.run(0.02)
    assert bench.sent("status") == []
    bench.send("status", state(iis.State.ANGLE_CHECK))
    bench.run(0.02)
    assert bench.sent("status") == []
    bench.send("current_position", pose(1.0, 0.0, 0.0))
    bench.send("status", state(iis.State.FINISH))
    bench.run(0.02)
    assert len(bench.sent("status")) == 1


def test_only_finish_is_passed_on(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("goal", pose(1.0, 0.0, 0.0))
    bench.run(0.02)
    bench.send("status", *(state(value) for value in range(1, 7)))
    bench.run(0.1)
    assert bench.sent("status") == []


def test_a_finish_away_from_the_goal_is_not_believed(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("goal", pose(1.0, 0.0, 0.0))
    bench.run(0.02)
    assert len(bench.sent("min_path")) == 1
    bench.send("current_position", pose(0.5, 0.3, 0.0))
    bench.send("status", state(iis.State.SPEED_DOWN), state(iis.State.FINISH))
    bench.run(0.02)
    assert bench.sent("status") == []
    assert path(bench)[0] == (0.5, 0.3)


def test_a_path_that_the_navigation_does_not_have_is_sent_again(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("goal", pose(1.0, 0.0, 0.0))
    bench.run(0.5)
    bench.send("status", state(iis.State.SPEED_DOWN))
    bench.run(0.9)
    assert len(bench.sent("min_path")) == 1
    bench.run(0.2)
    # A path begins at the present pose of the base.
    assert bench.sent("min_path") == []
    bench.send("current_position", pose(0.4, 0.0, 0.0))
    bench.run(0.1)
    assert path(bench)[0] == (0.4, 0.0)


def test_a_goal_that_was_not_reached_outlives_a_restart(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.send("goal", pose(1.0, 0.0, 0.0))
    bench.run(0.02)
    bench.deactivate()
    bench.activate()
    bench.sent("min_path")
    bench.send("current_position", pose(0.4, 0.0, 0.0))
    bench.run(0.02)
    assert path(bench)[-1] == (1.0, 0.0)
    bench.send("current_position", pose(1.0, 0.0, 0.0))
    bench.send("status", state(iis.State.TURNING), state(iis.State.FINISH))
    bench.run(0.02)
    assert len(bench.sent("status")) == 1
    bench.deactivate()
    bench.activate()
    bench.send("current_position", pose(1.0, 0.0, 0.0))
    bench.run(0.02)
    assert bench.sent("min_path") == []


def test_no_path_is_planned_from_an_old_position(bench: Bench) -> None:
    bench.send("current_position", pose(0.0, 0.0, 0.0))
    bench.run(0.6)
    bench.send("goal", pose(1.0, 0.0, 0.0))
    bench.run(0.1)
    assert bench.sent("min_path") == []
    condition = bench.system.statistics(bench.component.instance_name).condition
    assert condition == "current_position: nothing newer than 0.5 s"
    bench.send("current_position", pose(0.2, 0.0, 0.0))
    bench.run(0.02)
    assert path(bench)[0] == (0.2, 0.0)
