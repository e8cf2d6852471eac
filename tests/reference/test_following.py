"""Two ways of following a robot."""

from __future__ import annotations

from dataclasses import dataclass
from math import dist, pi

import pytest

from refnav import following
from refnav.following import REST, DistanceKeeper, Follower, TrackFollower
from refnav.geometry import Pose, advance


@dataclass
class Parameters:
    """Parameters of following."""

    distance: float = 1.0
    max_v: float = 0.4
    max_w: float = 1.0


def pursue(
    follower: Follower, here: Pose, leaders: list[Pose], *, sideways: bool = False
) -> list[Pose]:
    """Return the poses of a robot that follows its commands, 50 times a second."""
    poses = [here]
    for leader in leaders:
        follower.observe(leader)
        vx, vy, va = follower.command(poses[-1], Parameters(), sideways=sideways)
        assert sideways or vy == 0.0
        moved = advance(*poses[-1], vx * 0.02, va * 0.02, vy * 0.02)
        poses.append(Pose(*moved))
    return poses


def corner() -> list[Pose]:
    """Return 2 m along x, 2 m along y, at 0.2 m/s; then rest."""
    way = [Pose(0.004 * i, 0.0, 0.0) for i in range(500)]
    way += [Pose(2.0, 0.004 * i, pi / 2) for i in range(501)]
    return way + [way[-1]] * 500


@pytest.mark.parametrize("sideways", [False, True])
def test_a_track_is_followed_round_a_corner(sideways: bool) -> None:
    poses = pursue(TrackFollower(), Pose(-1.0, 0.0, 0.0), corner(), sideways=sideways)
    end = poses[-1]
    assert (end.x, end.y) == pytest.approx((2.0, 1.0), abs=0.1)
    # In the corner of the track, the deviation is at most the lookahead.
    assert all(
        min(dist(pose[:2], (x, 0.0)) for x in (pose.x, 2.0)) < 0.3
        or abs(pose.x - 2.0) < 0.3
        for pose in poses
    )


def test_a_distance_is_kept_as_the_crow_flies() -> None:
    poses = pursue(DistanceKeeper(), Pose(-1.0, 0.0, 0.0), corner())
    assert dist(poses[-1][:2], (2.0, 2.0)) == pytest.approx(1.0, abs=0.01)
    # It cuts the corner of the track.
    assert min(dist(pose[:2], (2.0, 0.0)) for pose in poses) > 0.3


@pytest.mark.parametrize("make", [TrackFollower, DistanceKeeper])
def test_without_a_leader_a_follower_rests(make: type[Follower]) -> None:
    assert make().command(Pose(0, 0, 0), Parameters(), sideways=True) == REST


@pytest.mark.parametrize("make", [TrackFollower, DistanceKeeper])
def test_a_follower_that_is_near_enough_does_not_go_back(make: type[Follower]) -> None:
    follower = make()
    follower.observe(Pose(0.5, 0.0, 0.0))
    assert follower.command(Pose(0, 0, 0), Parameters(), sideways=False) == REST


@pytest.mark.parametrize("make", [TrackFollower, DistanceKeeper])
def test_a_follower_keeps_its_limits(make: type[Follower]) -> None:
    follower = make()
    follower.observe(Pose(-100.0, 1.0, 0.0))
    vx, vy, va = follower.command(Pose(0, 0, 0), Parameters(), sideways=False)
    assert (vx, vy) == (0.0, 0.0)  # the leader is behind: it turns first
    assert abs(va) == 1.0
    vx, vy, va = follower.command(Pose(0, 0, 0), Parameters(), sideways=True)
    assert vx == pytest.approx(-0.4, abs=0.01)
    assert abs(va) == 1.0


def test_a_track_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(following, "MAX_TRACK", 10)
    follower = TrackFollower()
    for i in range(100):
        follower.observe(Pose(0.1 * i, 0.0, 0.0))
    # The kept part begins at 9 m and ends at 9.9 m: 1.3 m from here.
    here = Pose(8.6, 0.0, 0.0)
    near = follower.command(here, Parameters(distance=1.31), sideways=False)
    assert near == REST
    vx, _, va = follower.command(here, Parameters(distance=1.2), sideways=False)
    assert vx == pytest.approx(0.15)
    assert va == pytest.approx(0.0)
