"""The two reference runs: their ends, states, and limits."""

from __future__ import annotations

from itertools import groupby, pairwise
from math import hypot

import pytest
from pipeline import Recording, truth

from refnav.geometry import Pose, wrap
from refnav.path_follower import PathFollower
from refrobots import iis
from rtgen.runtime import SECOND

State = iis.State
Mode = iis.TravelMode

FIRST = [State.ANGLE_CHECK, State.GOAL_CHECK]
"""Element 0 is the start pose of the base: checked and passed."""
TURN = [State.ANGLE_CHECK, State.TURNING, State.GOAL_CHECK]
GO_ON = [State.ANGLE_CHECK, State.GOAL_CHECK]
STRAIGHT = [State.ANGLE_CHECK, State.GOAL_CHECK, State.SPEED_DOWN, State.STOPPING]
LAST = [State.ANGLE_CHECK, State.TURNING2, State.FINISH]

RUNS = pytest.mark.parametrize("name", ["goal_run", "path_run"])


@pytest.fixture
def run(name: str, request: pytest.FixtureRequest) -> Recording:
    recording: Recording = request.getfixturevalue(name)
    return recording


def states(run: Recording) -> list[iis.State]:
    values = [State(sample.data) for _, sample in run.samples("Navigation0", "status")]
    return [state for state, _ in groupby(values)]


@pytest.mark.parametrize(
    ("name", "goal"), [("goal_run", (3.4, 7.7, -1.57)), ("path_run", (0.0, 2.0, 3.14))]
)
def test_the_base_ends_at_the_goal(
    run: Recording, goal: tuple[float, float, float]
) -> None:
    end = truth(run.system)
    assert hypot(end.x - goal[0], end.y - goal[1]) < 0.05
    assert abs(wrap(end.theta - goal[2])) < 0.03
    assert run.system.observable("PositionInput0.goal") == goal


@RUNS
def test_nothing_is_lost_and_the_end_has_a_reason(run: Recording) -> None:
    lost = {name: run.system.statistics(name).lost for name in run.system.instances}
    assert set(lost.values()) == {0}
    assert (
        run.system.statistics("PositionInput0").reason == "all commands are carried out"
    )


def test_the_states_of_a_goal(goal_run: Recording) -> None:
    assert states(goal_run) == [*FIRST, *TURN, *STRAIGHT, *LAST]


def test_the_states_of_a_path(path_run: Recording) -> None:
    legs = [*GO_ON, *STRAIGHT, *TURN, *STRAIGHT, *TURN, *STRAIGHT]
    assert states(path_run) == [*FIRST, *legs, *LAST]


@RUNS
def test_there_is_one_finish(run: Recording) -> None:
    finishes = run.samples("OmniTo2WD0", "status")
    assert [sample.data for _, sample in finishes] == [State.FINISH]
    assert len(run.samples("OmniTo2WD0", "min_path")) == 1


def legs(run: Recording) -> list[tuple[int, int, Pose, Pose]]:
    """Return each straight: begin and end [ns], planned start and end pose."""
    [(_, plan)] = run.samples("OmniTo2WD0", "min_path")
    points = [Pose(p.position.x, p.position.y, p.heading) for p in plan.pose]
    planned = [(a, b) for a, b in pairwise(points) if hypot(b.x - a.x, b.y - a.y) > 0.0]
    waypoints = run.samples("Navigation0", "path")
    modes = [(time, Mode(path.type)) for time, path in waypoints]
    begins = [
        b[0]
        for a, b in pairwise(modes)
        if b[1] is Mode.RUN_LINEFOLLOW and a[1] is not Mode.RUN_LINEFOLLOW
    ]
    ends = [
        b[0]
        for a, b in pairwise(modes)
        if a[1] is Mode.RUN_LINEFOLLOW and b[1] is Mode.RUN_STOP
    ]
    return [
        (begin, end, a, b)
        for begin, end, (a, b) in zip(begins, ends, planned, strict=True)
    ]


@RUNS
def test_waypoints_are_passed_in_order(run: Recording) -> None:
    for begin, end, start, target in legs(run):
        poses = run.between(begin, end)
        assert hypot(poses[0].x - start.x, poses[0].y - start.y) < 0.05
        assert hypot(poses[-1].x - target.x, poses[-1].y - target.y) < 0.05


@RUNS
def test_the_base_keeps_to_the_line_in_the_second_half_of_a_leg(run: Recording) -> None:
    looked_at = 0
    for begin, end, start, target in legs(run):
        length = hypot(target.x - start.x, target.y - start.y)
        if length < 2.0 - 1e-9:
            continue
        ux, uy = (target.x - start.x) / length, (target.y - start.y) / length
        for pose in run.between(begin, end):
            dx, dy = pose.x - start.x, pose.y - start.y
            if dx * ux + dy * uy >= 0.5 * length:
                looked_at += 1
                assert abs(dy * ux - dx * uy) < 0.03
    assert looked_at > 100


@RUNS
def test_every_velocity_keeps_its_limits(run: Recording) -> None:
    follower = run.system.component("PathFollower0")
    assert isinstance(follower, PathFollower)
    config = follower.config
    samples = [s.data for _, s in run.samples("PathFollower0", "velocity")]
    tiny = 1e-12
    assert max(abs(s.vx) for s in samples) <= config.max_v + tiny
    assert max(abs(s.va) for s in samples) <= config.max_w + tiny
    assert (
        max(abs(b.vx - a.vx) for a, b in pairwise(samples)) <= config.max_acc_v + tiny
    )
    assert (
        max(abs(b.va - a.va) for a, b in pairwise(samples)) <= config.max_acc_w + tiny
    )
    assert {s.vy for s in samples} == {0.0}
    # The limits are reached, not only kept.
    assert max(s.vx for s in samples) == pytest.approx(0.3, abs=1e-3)
    assert max(abs(s.va) for s in samples) == pytest.approx(config.max_w)


@RUNS
def test_velocities_carry_their_time_and_come_at_1000_hz(run: Recording) -> None:
    samples = run.samples("PathFollower0", "velocity")
    assert all(s.tm.sec * SECOND + s.tm.nsec == time for time, s in samples)
    assert {b - a for (a, _), (b, _) in pairwise(samples)} == {SECOND // 1000}
