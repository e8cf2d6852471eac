"""The limiter of speed and acceleration."""

from __future__ import annotations

from hypothesis import given
from hypothesis.strategies import floats

from refnav.limiter import limited

SPEED = floats(-10.0, 10.0)
BOUND = floats(0.0, 5.0)


@given(SPEED, SPEED, BOUND, BOUND)
def test_step_is_never_exceeded(
    value: float, target: float, most: float, step: float
) -> None:
    assert abs(limited(value, target, most, step) - value) <= step * (1 + 1e-12) + 1e-12


@given(floats(-1.0, 1.0), SPEED, BOUND)
def test_stays_within_its_bound(value: float, target: float, step: float) -> None:
    assert -1.0 <= limited(value, target, 1.0, step) <= 1.0


def test_reaches_a_target_within_one_step() -> None:
    assert limited(0.2, 0.25, 1.0, 0.1) == 0.25
    assert limited(0.2, -5.0, 1.0, 0.1) == 0.2 - 0.1
    assert limited(0.95, 5.0, 1.0, 0.1) == 1.0


def test_comes_back_step_by_step_when_the_bound_shrinks() -> None:
    assert limited(1.0, 1.0, 0.5, 0.1) == 1.0 - 0.1
