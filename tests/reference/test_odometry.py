"""Odometry alone: integration, activation, refused samples."""

from __future__ import annotations

from math import pi

import pytest
from component_bench import Bench
from hypothesis import given
from hypothesis.strategies import floats, lists, tuples

from refnav.geometry import Pose
from refnav.kinematics import TwoWheels
from refnav.odometry import DeadReckoning, Odometry
from refnav.plant import Plant
from refrobots import rtc
from rtgen.runtime import LifeCycleState

RADIUS, AXLE = 0.0995, 0.464


def angles(milliseconds: int, left: float, right: float) -> rtc.TimedDoubleSeq:
    return rtc.TimedDoubleSeq(rtc.Time(0, milliseconds * 1_000_000), [left, right])


def poses(bench: Bench) -> list[tuple[float, float, float]]:
    return [
        (p.data.position.x, p.data.position.y, p.data.heading)
        for p in bench.sent("OdometryPosition")
    ]


@given(lists(tuples(floats(-5.0, 5.0), floats(-5.0, 5.0)), min_size=1, max_size=50))
def test_the_reckoning_follows_the_plant(speeds: list[tuple[float, float]]) -> None:
    base = Plant(TwoWheels(RADIUS, RADIUS, AXLE))
    start = Pose(1.0, -2.0, 0.5)
    base.place(start)
    reckoning = DeadReckoning(start, (RADIUS, RADIUS), AXLE)
    reckoning.update([0.0, 0.0])
    for left, right in speeds:
        base.drive((left, right), 10.0, 10.0)
        base.roll(0.01)
        pose = reckoning.update(list(base.angles))
        assert pose == pytest.approx(base.pose, abs=1e-9)


def test_the_first_angles_only_tell_where_to_count_from() -> None:
    bench = Bench(Odometry("Odometry0"), 100.0)
    bench.set(initialPose_x="1.0", initialPose_y="2.0", initialPose_theta="0.5")
    bench.activate()
    bench.send("CurrentWheelAngle", angles(1, 70.0, 80.0))
    bench.run(0.01)
    assert poses(bench) == [(1.0, 2.0, 0.5)]


def test_samples_that_are_not_newer_are_refused() -> None:
    bench = Bench(Odometry("Odometry0"), 100.0)
    bench.activate()
    for sample in (angles(5, 0.0, 0.0), angles(5, 1.0, 1.0), angles(4, 2.0, 2.0)):
        bench.send("CurrentWheelAngle", sample)
        bench.run(0.01)
    assert poses(bench) == [(0.0, 0.0, 0.0)]
    bench.send("CurrentWheelAngle", angles(6, 1.0, 1.0))
    bench.run(0.01)
    assert poses(bench) == [pytest.approx((RADIUS, 0.0, 0.0))]


def test_the_pose_carries_the_time_of_the_wheel_angles() -> None:
    bench = Bench(Odometry("Odometry0"), 100.0)
    bench.activate()
    bench.send("CurrentWheelAngle", angles(3, 0.0, 0.0))
    bench.run(0.01)
    [pose] = bench.sent("OdometryPosition")
    assert pose.tm == rtc.Time(0, 3_000_000)
    assert (pose.id, pose.error) == ([], [])


def test_parameters_take_effect_with_the_next_activation() -> None:
    bench = Bench(Odometry("Odometry0"), 100.0)
    bench.activate()
    bench.send("CurrentWheelAngle", angles(1, 0.0, 0.0))
    bench.run(0.01)
    bench.set(
        radiusOfLeftWheel="1.0", radiusOfRightWheel="1.0", initialPose_theta=str(pi / 2)
    )
    bench.run(0.01)
    bench.send("CurrentWheelAngle", angles(2, 1.0, 1.0))
    bench.run(0.01)
    assert poses(bench)[-1] == pytest.approx((RADIUS, 0.0, 0.0))
    bench.deactivate()
    bench.activate()
    bench.send("CurrentWheelAngle", angles(3, 1.0, 1.0))
    bench.run(0.01)
    bench.send("CurrentWheelAngle", angles(4, 2.0, 2.0))
    bench.run(0.01)
    assert poses(bench) == [
        pytest.approx((0.0, 0.0, pi / 2)),
        pytest.approx((0.0, 1.0, pi / 2)),
    ]


def test_a_missing_wheel_is_an_error_with_a_reason() -> None:
    bench = Bench(Odometry("Odometry0"), 100.0)
    bench.set(rightWheelID="2")
    bench.activate()
    bench.send("CurrentWheelAngle", angles(1, 0.0, 0.0))
    bench.run(0.01)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason == "CurrentWheelAngle: 2 angles, a wheel is missing"
