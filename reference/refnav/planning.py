"""Plans paths for a base that can only drive forward and turn on the spot."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot

from refnav.geometry import Pose

SAME_PLACE = 1e-3
"""Points closer than this have no direction between them [m]."""


def turn_straight_turn(start: Pose, waypoints: Sequence[Pose]) -> list[Pose]:
    """Return the path from `start` through the waypoints, one or more of them.

    The base turns to each waypoint and drives straight forward; the heading of a waypoint is that
    of the straight, but after the last one the base turns to the requested heading. For n waypoints
    this gives 2 n + 2 poses, `start` the first.
    """
    path = [start]
    here = start
    for point in waypoints:
        heading = here.theta
        if hypot(point.x - here.x, point.y - here.y) > SAME_PLACE:
            heading = atan2(point.y - here.y, point.x - here.x)
        path.append(Pose(here.x, here.y, heading))
        here = Pose(point.x, point.y, heading)
        path.append(here)
    path.append(waypoints[-1])
    return path
