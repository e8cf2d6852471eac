"""The simulated base: exact arcs, limits of the wheels, encoders."""

from __future__ import annotations

from math import cos, hypot, isclose, pi, sin, tau

import pytest
from hypothesis import given
from hypothesis.strategies import floats

from refnav.geometry import Pose, advance, wrap
from refnav.kinematics import TwoWheels
from refnav.plant import Plant, counted

RADIUS = 0.1
TREAD = 0.5


@given(floats(-1e6, 1e6))
def test_wrapped_angles_are_the_same_direction(angle: float) -> None:
    wrapped = wrap(angle)
    assert -pi <= wrapped <= pi
    assert isclose(cos(wrapped), cos(angle), abs_tol=1e-9)
    assert isclose(sin(wrapped), sin(angle), abs_tol=1e-9)


@given(floats(-3.0, 3.0), floats(-2.0, 2.0), floats(-3.0, 3.0))
def test_one_arc_is_many_small_ones(theta: float, distance: float, turn: float) -> None:
    whole = advance(0.0, 0.0, theta, distance, turn)
    pose = (0.0, 0.0, theta)
    for _ in range(4096):
        pose = advance(*pose, distance / 4096, turn / 4096)
    assert hypot(pose[0] - whole[0], pose[1] - whole[1]) < 1e-9
    assert abs(wrap(pose[2] - whole[2])) < 1e-9


def test_a_full_circle_ends_where_it_began() -> None:
    x, y, theta = advance(1.0, 2.0, 0.5, tau * 0.7, tau)
    assert (x, y) == pytest.approx((1.0, 2.0))
    assert theta == pytest.approx(0.5)


def test_a_quarter_circle_to_the_left() -> None:
    assert advance(0.0, 0.0, 0.0, 0.5 * pi, 0.5 * pi) == pytest.approx(
        (1.0, 1.0, 0.5 * pi)
    )


def test_equal_wheels_drive_straight() -> None:
    base = Plant(TwoWheels(RADIUS, RADIUS, TREAD))
    base.place(Pose(1.0, 1.0, 0.5 * pi))
    base.drive((2.0, 2.0), 10.0, 10.0)
    for _ in range(1000):
        base.roll(0.001)
    assert base.pose == pytest.approx((1.0, 1.2, 0.5 * pi))
    assert tuple(base.angles) == pytest.approx((2.0, 2.0))


def test_opposite_wheels_turn_on_the_spot() -> None:
    base = Plant(TwoWheels(RADIUS, RADIUS, TREAD))
    base.drive((-1.0, 1.0), 10.0, 10.0)
    base.roll(1.0)
    assert base.pose == pytest.approx((0.0, 0.0, 2 * RADIUS / TREAD))


def test_each_wheel_keeps_its_limits() -> None:
    base = Plant(TwoWheels(RADIUS, RADIUS, TREAD))
    base.drive((5.0, -0.03), 1.0, 0.1)
    assert tuple(base.speeds) == (0.1, -0.03)
    for _ in range(100):
        base.drive((5.0, -0.03), 1.0, 0.1)
    assert tuple(base.speeds) == (1.0, -0.03)


def test_halted_wheels_hold_their_angles() -> None:
    base = Plant(TwoWheels(RADIUS, RADIUS, TREAD))
    base.drive((1.0, 1.0), 1.0, 1.0)
    base.roll(1.0)
    pose = base.pose
    base.halt()
    base.roll(1.0)
    assert base.pose == pose
    assert base.angles[0] == 1.0


@given(floats(-1e4, 1e4))
def test_the_encoder_is_off_by_less_than_one_count(angle: float) -> None:
    count = tau / (2000 * 74.91)
    measured = counted(angle, count)
    assert -1e-9 < angle - measured < count + 1e-9
    assert isclose(measured / count, round(measured / count), abs_tol=1e-6)
