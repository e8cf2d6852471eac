"""Wheels and the motion of the body: two driven wheels, omni-wheels."""

from __future__ import annotations

from math import pi

import pytest
from hypothesis import given
from hypothesis.strategies import floats, integers

from refnav.geometry import Pose, advance, wrap_positive
from refnav.kinematics import OmniWheels, TwoWheels
from refnav.plant import Plant

speeds = floats(-2.0, 2.0)


@given(speeds, speeds, speeds)
def test_two_wheels_turn_as_they_are_told_and_never_go_sideways(
    vx: float, vy: float, va: float
) -> None:
    wheels = TwoWheels(0.1, 0.12, 0.4)
    motion = wheels.motion(wheels.speeds(vx, vy, va))
    assert motion == pytest.approx((vx, 0.0, va), abs=1e-12)


@given(integers(3, 6), speeds, speeds, speeds)
def test_omni_wheels_go_wherever_they_are_told(
    count: int, vx: float, vy: float, va: float
) -> None:
    wheels = OmniWheels(count, 0.05, 0.2)
    driven = wheels.speeds(vx, vy, va)
    assert len(driven) == wheels.wheels == count
    assert wheels.motion(driven) == pytest.approx((vx, vy, va), abs=1e-12)


def test_the_plant_goes_sideways_in_the_frame_of_the_body() -> None:
    base = Plant(OmniWheels(4, 0.05, 0.2))
    base.place(Pose(1.0, 1.0, 0.5 * pi))
    base.drive(base.kinematics.speeds(0.0, 0.5, 0.0), 100.0, 100.0)
    assert base.velocity == pytest.approx((0.0, 0.5, 0.0))
    base.roll(2.0)
    assert base.pose == pytest.approx((0.0, 1.0, 0.5 * pi))


@given(floats(-3.0, 3.0), speeds, speeds, speeds)
def test_one_sideways_arc_is_many_small_ones(
    theta: float, forward: float, sideways: float, turn: float
) -> None:
    whole = advance(0.0, 0.0, theta, forward, turn, sideways)
    pose = (0.0, 0.0, theta)
    for _ in range(1024):
        pose = advance(*pose, forward / 1024, turn / 1024, sideways / 1024)
    assert pose[:2] == pytest.approx(whole[:2], abs=1e-9)


@given(floats(-1e6, 1e6))
def test_angles_of_the_third_phase_are_positive(angle: float) -> None:
    assert 0.0 <= wrap_positive(angle) < 2 * pi


def test_an_angle_just_below_zero_does_not_become_a_whole_turn() -> None:
    assert wrap_positive(-1e-20) == 0.0
