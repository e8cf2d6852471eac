"""Two ways to follow a robot: along the track that it has left, or straight towards it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from math import atan2, cos, hypot, sin
from typing import NamedTuple, Protocol

from refnav.geometry import Pose, wrap

SPACING = 0.05
"""Distance of the points of a track [m]."""
LOOKAHEAD = 0.35
"""Distance of the point of the track for which a follower heads [m]."""
MAX_TRACK = 10_000
"""Maximum number of points of a track; the oldest are dropped."""
APPROACH = 1.5
"""Speed for each metre beyond the distance [1/s]."""
TURN = 2.0
"""Angular speed for each rad of deviation [1/s]."""


class Command(NamedTuple):
    """A velocity of the body [m/s, m/s, rad/s]."""

    vx: float
    vy: float
    va: float


REST = Command(0.0, 0.0, 0.0)


class FollowingParameters(Protocol):
    """How to follow [m, m/s, rad/s]."""

    distance: float
    max_v: float
    max_w: float


class Follower(Protocol):
    """A way of following."""

    def observe(self, leader: Pose) -> None:
        """Store the leader's position."""

    def command(
        self, here: Pose, parameters: FollowingParameters, *, sideways: bool
    ) -> Command:
        """Return the velocity that follows; `sideways`: whether the body can move sideways."""


class TrackFollower:
    """Follows the leader's track; keeps its distance along the track."""

    def __init__(self) -> None:
        self._track: deque[Pose] = deque()
        self._length = 0.0

    def observe(self, leader: Pose) -> None:
        """Append the leader's position to the track, if it moved."""
        track = self._track
        if track:
            step = _between(track[-1], leader)
            if step < SPACING:
                return
            if len(track) == MAX_TRACK:
                self._pass()
            self._length += step
        track.append(leader)

    def command(
        self, here: Pose, parameters: FollowingParameters, *, sideways: bool
    ) -> Command:
        """Return the velocity along the track, which keeps the distance from its end."""
        track = self._track
        while len(track) > 1 and _between(here, track[0]) < LOOKAHEAD:
            self._pass()
        if not track:
            return REST
        way = _between(here, track[0]) + self._length
        too_far = way - parameters.distance
        return _towards(track[0], here, too_far, parameters, sideways=sideways)

    def _pass(self) -> None:
        passed = self._track.popleft()
        self._length -= _between(passed, self._track[0])
        if len(self._track) == 1:
            self._length = 0.0  # rounding errors


class DistanceKeeper:
    """Heads for the leader's present position, and stops at the distance."""

    def __init__(self) -> None:
        self._leader: Pose | None = None

    def observe(self, leader: Pose) -> None:
        """Store the leader's position."""
        self._leader = leader

    def command(
        self, here: Pose, parameters: FollowingParameters, *, sideways: bool
    ) -> Command:
        """Return the velocity straight towards the leader, never backward."""
        if self._leader is None:
            return REST
        too_far = _between(here, self._leader) - parameters.distance
        return _towards(self._leader, here, too_far, parameters, sideways=sideways)


WAYS: dict[str, Callable[[], Follower]] = {
    "track": TrackFollower,
    "distance": DistanceKeeper,
}


def _towards(
    there: Pose,
    here: Pose,
    too_far: float,
    parameters: FollowingParameters,
    *,
    sideways: bool,
) -> Command:
    bearing = wrap(atan2(there.y - here.y, there.x - here.x) - here.theta)
    speed = min(max(APPROACH * too_far, 0.0), parameters.max_v)
    turn = min(max(TURN * bearing, -parameters.max_w), parameters.max_w)
    if speed == 0.0:
        return REST
    along = speed * cos(bearing)
    if sideways:
        return Command(along, speed * sin(bearing), turn)
    return Command(max(along, 0.0), 0.0, turn)


def _between(one: Pose, other: Pose) -> float:
    return hypot(other.x - one.x, other.y - one.y)
