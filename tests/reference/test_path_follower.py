"""PathFollower alone: modes, limits, behaviour without pose or waypoint."""

from __future__ import annotations

from itertools import pairwise

import pytest
from component_bench import Bench

from refnav.path_follower import PathFollower
from refrobots import iis, rtc
from rtgen.runtime import LifeCycleState

Mode = iis.TravelMode


@pytest.fixture
def bench() -> Bench:
    bench = Bench(PathFollower("PathFollower0"), 1000.0)
    # One pose and one waypoint show the kind of motion.
    bench.set(control_cycle="0.001", PositionTimeout="0", TargetTimeout="0")
    bench.activate()
    bench.sent("velocity")
    return bench


def at(x: float, y: float, theta: float) -> iis.TimedPose2D:
    return iis.TimedPose2D(data=rtc.Pose2D(rtc.Point2D(x, y), theta))


def velocities(bench: Bench) -> list[tuple[float, float]]:
    samples = bench.sent("velocity")
    assert all(sample.data.vy == 0.0 for sample in samples)
    return [(sample.data.vx, sample.data.va) for sample in samples]


def test_a_velocity_goes_out_at_every_execution_with_its_time(bench: Bench) -> None:
    bench.run(0.1)
    samples = bench.sent("velocity")
    stamps = [sample.tm.sec * 1000 + sample.tm.nsec / 1e6 for sample in samples]
    assert stamps == [pytest.approx(k) for k in range(1, 101)]
    assert all((s.data.vx, s.data.va) == (0.0, 0.0) for s in samples)


def test_a_waypoint_waits_for_the_first_pose(bench: Bench) -> None:
    bench.send("target_path", rtc.Path(type=Mode.RUN_LINEFOLLOW, v=0.3))
    bench.run(0.1)
    assert set(velocities(bench)) == {(0.0, 0.0)}
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.run(0.1)
    assert velocities(bench)[-1] == (pytest.approx(0.03), 0.0)


def test_stop_brakes_within_the_limits(bench: Bench) -> None:
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.send("target_path", rtc.Path(type=Mode.RUN_VEL, v=0.3, w=0.2))
    bench.run(1.5)
    assert velocities(bench)[-1] == (0.3, 0.2)
    bench.send("target_path", rtc.Path(type=Mode.RUN_STOP))
    bench.run(1.5)
    braking = velocities(bench)
    assert braking[-1] == (0.0, 0.0)
    assert all(abs(b[0] - a[0]) < 0.0003 + 1e-9 for a, b in pairwise(braking))
    assert all(abs(b[1] - a[1]) < 0.1 + 1e-9 for a, b in pairwise(braking))


def test_limits_can_be_changed_while_active(bench: Bench) -> None:
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.send("target_path", rtc.Path(type=Mode.RUN_VEL, v=5.0, w=5.0))
    bench.run(5.0)
    assert velocities(bench)[-1] == (1.0, 0.3)
    bench.set(max_v="0.5", max_w="0.1", max_acc_v="0.01")
    bench.run(0.1)
    assert velocities(bench)[-1] == (0.5, 0.1)


def test_waypoints_are_read_one_by_one(bench: Bench) -> None:
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.send(
        "target_path",
        rtc.Path(type=Mode.RUN_VEL, w=0.1),
        rtc.Path(type=Mode.RUN_VEL, w=-0.1),
        rtc.Path(type=Mode.RUN_STOP),
    )
    bench.run(0.004)
    assert [w for _, w in velocities(bench)] == [
        pytest.approx(0.1),
        pytest.approx(0.0),
        0.0,
        0.0,
    ]


@pytest.mark.parametrize("mode", [Mode.RUN_FREE, Mode.RUN_WHEEL_VEL])
def test_what_a_velocity_cannot_tell_brings_the_base_to_rest(
    bench: Bench, mode: Mode
) -> None:
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.send("target_path", rtc.Path(type=Mode.RUN_VEL, v=0.03))
    bench.run(0.2)
    bench.send("target_path", rtc.Path(type=mode, v=1.0, w=1.0))
    bench.run(0.2)
    assert velocities(bench)[-1] == (0.0, 0.0)


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        (rtc.Path(type=8), "target_path: 8 is not a valid TravelMode"),
        (
            rtc.Path(type=Mode.RUN_CIRCLEFOLLOW, v=0.1),
            "target_path: a circle of radius 0",
        ),
    ],
)
def test_an_impossible_waypoint_is_an_error_and_halts_the_base(
    bench: Bench, path: rtc.Path, reason: str
) -> None:
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.send("target_path", rtc.Path(type=Mode.RUN_VEL, v=0.03))
    bench.run(0.2)
    bench.send("target_path", path)
    bench.run(0.01)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason == reason
    assert velocities(bench)[-1] == (0.0, 0.0)


def test_deactivation_halts_the_base_and_forgets_the_waypoint(bench: Bench) -> None:
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.send("target_path", rtc.Path(type=Mode.RUN_VEL, v=0.03))
    bench.run(0.2)
    bench.deactivate()
    assert velocities(bench)[-1] == (0.0, 0.0)
    bench.activate()
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.run(0.1)
    assert set(velocities(bench)) == {(0.0, 0.0)}


@pytest.mark.parametrize(
    "path",
    [
        rtc.Path(type=Mode.RUN_LINEFOLLOW, v=0.3),
        rtc.Path(type=Mode.RUN_TO_POINT, x=5.0, v=0.3),
        rtc.Path(type=Mode.RUN_CIRCLEFOLLOW, y=2.0, r=2.0, v=0.3),
    ],
)
def test_moving_modes_drive_forward(bench: Bench, path: rtc.Path) -> None:
    bench.send("position", at(0.0, 0.0, 0.0))
    bench.send("target_path", path)
    bench.run(0.1)
    assert velocities(bench)[-1][0] == pytest.approx(0.03)


@pytest.mark.parametrize("dead", ["position", "target_path"])
def test_it_stops_when_an_input_is_too_old_and_goes_on_with_a_new_one(
    bench: Bench, dead: str
) -> None:
    bench.set(PositionTimeout="0.5", TargetTimeout="0.3")
    age = {"position": 0.5, "target_path": 0.3}[dead]
    newest = {
        "position": at(0.0, 0.0, 0.0),
        "target_path": rtc.Path(type=Mode.RUN_VEL, v=0.1),
    }
    for port in newest:
        bench.send(port, newest[port])
    for _ in range(10):
        bench.run(0.1)
        for port in newest.keys() - {dead}:
            bench.send(port, newest[port])
    v = [v for v, _ in velocities(bench)]
    driven = max(number for number, speed in enumerate(v) if speed)
    assert driven * 0.001 == pytest.approx(age, abs=0.002)
    condition = bench.system.statistics("PathFollower0").condition
    assert condition == f"{dead}: nothing newer than {age:g} s"
    for port in newest:
        bench.send(port, newest[port])
    bench.run(0.1)
    assert velocities(bench)[-1][0] > 0.0
    assert bench.system.statistics("PathFollower0").condition == ""


def test_a_sample_that_waited_too_long_counts_as_none(bench: Bench) -> None:
    bench.set(PositionTimeout="0.5")
    bench.run(2.0)
    old = at(0.0, 0.0, 0.0)
    old.tm.sec = 1
    bench.send("target_path", rtc.Path(type=Mode.RUN_VEL, v=0.1))
    bench.send("position", old)
    bench.run(0.2)
    assert set(velocities(bench)) == {(0.0, 0.0)}
