"""The travel modes: single steps by their formulas, and their long-term behaviour."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi, sqrt

import pytest

from refnav.geometry import Pose, advance, wrap
from refnav.limiter import limited
from refnav.line_following import (
    SLOWEST_SPIN,
    CircleFollow,
    Constant,
    LineFollow,
    Motion,
    Spin,
    ToPoint,
    regulate,
)

STEP = 0.001


@dataclass
class Parameters:
    control_cycle: float = STEP
    line_Dist: float = 0.05
    line_K1: float = 800.0
    line_K2: float = 300.0
    line_K3: float = 400.0
    max_acc_w: float = 0.1
    max_acc_v: float = 0.0003
    max_v: float = 1.0
    max_w: float = 0.3


def run(motion: Motion, start: Pose, seconds: float) -> list[tuple[Pose, float, float]]:
    """Return poses and velocities of an ideal base at 1000 Hz."""
    gains = Parameters()
    pose, v, w = start, 0.0, 0.0
    trace = []
    for _ in range(round(seconds / STEP)):
        motion.observe(pose)
        v_wanted, w_wanted = motion.reference(v, w, gains)
        v = limited(v, v_wanted, gains.max_v, gains.max_acc_v)
        w = limited(w, w_wanted, gains.max_w, gains.max_acc_w)
        pose = Pose(*advance(*pose, v * STEP, w * STEP))
        trace.append((pose, v, w))
    return trace


def test_the_law_is_an_angular_acceleration() -> None:
    gains = Parameters(control_cycle=0.02)
    assert regulate(0.01, 0.2, 0.3, 0.1, gains) == pytest.approx(
        0.1 - 0.02 * (800 * 0.01 + 300 * 0.2 + 400 * 0.1)
    )


def test_the_distance_is_clamped_and_turns_its_sign_when_driving_backward() -> None:
    gains = Parameters()
    assert regulate(3.0, 0.0, 0.0, 0.0, gains) == pytest.approx(-STEP * 800 * 0.05)
    assert regulate(-3.0, 0.0, 0.0, 0.0, gains) == pytest.approx(STEP * 800 * 0.05)
    assert regulate(0.01, 0.0, -0.1, 0.0, gains) == pytest.approx(STEP * 800 * 0.01)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("direction", [0.0, 1.0, pi / 2, 3.0, -2.5])
@pytest.mark.parametrize("offset", [-0.5, 0.02, 0.5])
def test_a_base_beside_the_line_comes_onto_it(direction: float, offset: float) -> None:
    line = LineFollow(1.0, -2.0, direction, 0.3)
    start = Pose(*advance(1.0, -2.0, direction + pi / 2, offset, 0.0)[:2], direction)
    end, v, w = run(line, start, 35.0)[-1]
    line.observe(end)
    assert abs(line.distance) < 0.001
    assert abs(wrap(end.theta - direction)) < 0.001
    assert v == pytest.approx(0.3)
    assert abs(w) < 0.001


def test_far_from_the_line_the_base_comes_in_at_a_bounded_angle() -> None:
    line = LineFollow(0.0, 0.0, 0.0, 0.3)
    angles = [pose.theta for pose, _, _ in run(line, Pose(0.0, 1.0, 0.0), 10.0)]
    assert min(angles) == pytest.approx(-800 * 0.05 / 300, abs=0.01)


def test_a_point_is_approached_more_slowly_and_not_passed() -> None:
    trace = run(ToPoint(2.0, 0.0, 0.0, 0.3), Pose(0.0, 0.01, 0.0), 30.0)
    end, v, _ = trace[-1]
    assert end.x == pytest.approx(2.0, abs=0.01)
    assert max(pose.x for pose, _, _ in trace) < 2.01
    assert v < 0.001


@pytest.mark.sampled(1)
@pytest.mark.parametrize("radius", [1.5, -1.5])
def test_a_circle_is_kept_in_its_direction(radius: float) -> None:
    start = Pose(1.4, 0.0, pi / 2 if radius > 0 else -pi / 2)
    trace = run(CircleFollow(0.0, 0.0, radius, 0.3), start, 40.0)
    for pose, _, w in trace[-10000:]:
        assert hypot(pose.x, pose.y) == pytest.approx(1.5, abs=0.01)
        assert w == pytest.approx(0.3 / radius, abs=0.01)


@pytest.mark.parametrize("heading", [0.3, -0.3, 2.0, -3.1])
def test_a_spin_ends_at_its_heading_and_stays_on_the_spot(heading: float) -> None:
    trace = run(Spin(heading, 1.0), Pose(0.5, 0.5, 0.0), 12.0)
    end, v, _ = trace[-1]
    assert abs(wrap(end.theta - heading)) < 0.005
    assert (end.x, end.y, v) == (0.5, 0.5, 0.0)
    assert max(abs(w) for _, _, w in trace) <= 0.3


def test_a_spin_takes_the_shorter_way_round() -> None:
    spin = Spin(-3.0, 1.0)
    spin.observe(Pose(0.0, 0.0, 3.0))
    assert spin.reference(0.0, 0.0, Parameters()) == (0.0, pytest.approx(1.0))


def test_a_spin_brakes_by_the_root_of_the_angle_but_never_creeps() -> None:
    gains = Parameters(control_cycle=0.02)
    spin = Spin(0.0, 1.0)
    spin.observe(Pose(0.0, 0.0, 0.04))
    assert spin.reference(0.0, 0.0, gains)[1] == pytest.approx(-sqrt(0.04))
    spin.observe(Pose(0.0, 0.0, 1e-6))
    assert spin.reference(0.0, 0.0, gains)[1] == -SLOWEST_SPIN


def test_a_constant_velocity_needs_no_pose() -> None:
    assert Constant(0.2, -0.1).reference(0.0, 0.0, Parameters()) == (0.2, -0.1)
