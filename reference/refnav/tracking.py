"""Control law of PathTracking: follows a path of waypoints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, pi
from typing import Protocol

from refnav.geometry import Pose, wrap

PASSED = 0.05
"""Distance along the leg at which a waypoint before the last one counts as passed [m]."""
APPROACH = 1.0
"""Greatest speed for each metre to the last waypoint [1/s]."""
SLOWEST = 0.02
"""Least speed of the approach to the last waypoint [m/s]."""
TURN = 2.0
"""Angular speed for each rad of deviation [1/s]."""
SLOWEST_TURN = 0.05
"""Least angular speed of the turn to the last heading [rad/s]."""
MIN_MOTION = 1e-4
"""A robot that moved less than this between two positions has stopped [m, rad]."""


class TrackingParameters(Protocol):
    """The parameters of the law; units as in PathTracking's definition."""

    max_v: float
    max_w: float
    lookahead: float
    near: float
    turned: float


@dataclass(frozen=True, slots=True)
class Progress:
    """The waypoint reached last, and whether the robot has stopped."""

    number: int
    stopped: bool
    waypoint: Pose


class Tracker:
    """Leads a robot along one path, leg by leg, and turns it at the end.

    `speeds` are those of the legs; leg i ends at waypoint i: negative backward, 0 as fast as
    allowed. Less than two waypoints mean no motion.
    """

    def __init__(self, path: Sequence[Pose], speeds: Sequence[float]) -> None:
        self._path = list(path)
        self._speeds = list(speeds)
        self._target = 1
        self._resting = len(path) < 2
        self._reported = not path
        self._before: Pose | None = None

    @property
    def is_under_way(self) -> bool:
        """Whether some of the path is left."""
        return not self._resting

    def interrupted(self) -> Progress:
        """Return the progress of a path that is given up: the waypoint reached last, stopped."""
        self._resting = self._reported = True
        return self._progress(stopped=True)

    def stop(self) -> None:
        """Stop at the present place."""
        self._resting = True

    def step(self, here: Pose, parameters: TrackingParameters) -> Iterator[Progress]:
        """Process a new position; yield changes of the progress."""
        while not self._resting and self._reaches(here, parameters):
            self._target += 1
            yield self._progress(stopped=False)
        if not self._resting and self._target == len(self._path):
            off = wrap(self._path[-1].theta - here.theta)
            self._resting = abs(off) < parameters.turned
        if self._resting and not self._reported and self._is_still(here):
            self._reported = True
            yield self._progress(stopped=True)
        self._before = here

    def command(
        self, here: Pose, parameters: TrackingParameters
    ) -> tuple[float, float]:
        """Return speed and angular speed [m/s, rad/s]."""
        if self._resting:
            return 0.0, 0.0
        if self._target == len(self._path):
            off = wrap(self._path[-1].theta - here.theta)
            size = min(max(TURN * abs(off), SLOWEST_TURN), parameters.max_w)
            return 0.0, size if off > 0.0 else -size
        wanted = self._speeds[self._target] or parameters.max_v
        speed = min(abs(wanted), parameters.max_v)
        if self._last_leg:
            speed = min(speed, max(APPROACH * self._left(here), SLOWEST))
        ahead = self._ahead(here, parameters.lookahead)
        way = atan2(ahead.y - here.y, ahead.x - here.x)
        bearing = wrap(way - here.theta - (pi if wanted < 0.0 else 0.0))
        speed *= max(cos(bearing), 0.0)
        turn = min(max(TURN * bearing, -parameters.max_w), parameters.max_w)
        return (-speed if wanted < 0.0 else speed), turn

    @property
    def _last_leg(self) -> bool:
        return self._target == len(self._path) - 1

    def _progress(self, *, stopped: bool) -> Progress:
        number = self._target - 1
        return Progress(number, stopped, self._path[number])

    def _reaches(self, here: Pose, parameters: TrackingParameters) -> bool:
        """Return whether the end of the present leg is reached; False without a leg."""
        if self._target == len(self._path):
            return False
        return self._left(here) < (parameters.near if self._last_leg else PASSED)

    def _direction(self) -> tuple[float, float, float]:
        """Return the direction of the present leg as a unit vector, and its length [m]."""
        begin, end = self._path[self._target - 1], self._path[self._target]
        length = hypot(end.x - begin.x, end.y - begin.y)
        if length == 0.0:
            return 0.0, 0.0, 0.0
        return (end.x - begin.x) / length, (end.y - begin.y) / length, length

    def _left(self, here: Pose) -> float:
        """Return the remaining length of the current leg [m]; negative beyond its end."""
        x, y, _ = self._direction()
        end = self._path[self._target]
        return (end.x - here.x) * x + (end.y - here.y) * y

    def _ahead(self, here: Pose, lookahead: float) -> Pose:
        """Return the point of the present leg for which the robot heads."""
        x, y, length = self._direction()
        begin = self._path[self._target - 1]
        along = (here.x - begin.x) * x + (here.y - begin.y) * y + lookahead
        # The last leg is extended as a line beyond its end: a reached point has no direction.
        most = along if self._last_leg else length
        along = min(max(along, 0.0), most)
        return Pose(begin.x + along * x, begin.y + along * y, 0.0)

    def _is_still(self, here: Pose) -> bool:
        before = self._before
        return before is not None and (
            hypot(here.x - before.x, here.y - before.y) < MIN_MOTION
            and abs(wrap(here.theta - before.theta)) < MIN_MOTION
        )
