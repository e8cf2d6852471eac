"""Turn, straight, turn."""

from __future__ import annotations

from math import atan2, pi

import pytest

from refnav.geometry import Pose
from refnav.planning import turn_straight_turn


@pytest.mark.parametrize(
    ("x", "y", "direction"),
    [(1, 1, pi / 4), (-1, 1, 3 * pi / 4), (-1, -1, -3 * pi / 4), (1, -1, -pi / 4)],
)
def test_a_goal_makes_four_poses(x: float, y: float, direction: float) -> None:
    start, goal = Pose(0.5, -0.5, 2.0), Pose(0.5 + x, -0.5 + y, 0.3)
    assert turn_straight_turn(start, [goal]) == [
        start,
        Pose(0.5, -0.5, direction),
        Pose(goal.x, goal.y, direction),
        goal,
    ]


def test_only_the_last_waypoint_of_a_path_has_its_own_heading() -> None:
    points = [Pose(2.0, 0.0, 1.0), Pose(2.0, 2.0, 1.0), Pose(0.0, 3.0, 3.14)]
    poses = turn_straight_turn(Pose(0.0, 0.0, 0.0), points)
    last = atan2(1.0, -2.0)
    headings = [0.0, 0.0, 0.0, pi / 2, pi / 2, last, last, 3.14]
    assert [pose.theta for pose in poses] == pytest.approx(headings)
    assert [pose[:2] for pose in poses[2::2]] == [point[:2] for point in points]
    assert poses[-1] == points[-1]


def test_a_goal_on_the_spot_is_reached_by_turning_alone() -> None:
    start = Pose(1.0, 1.0, 0.7)
    assert [p.theta for p in turn_straight_turn(start, [Pose(1.0, 1.0, -2.0)])] == [
        0.7,
        0.7,
        0.7,
        -2.0,
    ]
