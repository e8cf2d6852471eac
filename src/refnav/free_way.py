"""How far a round body gets along an arc before it touches something."""

from __future__ import annotations

from collections.abc import Iterable
from math import acos, atan2, hypot, sqrt, tau

STRAIGHT = 1e-6
"""Arcs of less curvature are straight [1/m]."""

Point = tuple[float, float]


def free_way(
    curvature: float, points: Iterable[Point], radius: float, horizon: float
) -> float:
    """The length of arc [m], at most `horizon`, that a body drives forward untouched.

    The body is a circle of `radius` [m] round the origin, heading along x; `curvature` [1/m] is
    positive to the left. A point within the circle stops only a body that drives towards it.
    """
    free = horizon
    if -STRAIGHT < curvature < STRAIGHT:
        for x, y in points:
            room = radius * radius - y * y
            if x > 0.0 and room > 0.0:
                free = min(free, max(0.0, x - sqrt(room)))
        return free
    side = 1.0 if curvature > 0.0 else -1.0
    turn = 1.0 / abs(curvature)
    for x, y in points:
        if hypot(x, y) > free + radius:
            continue
        # From the middle of the arc; `behind` is how far round it the point lies.
        left = side * y - turn
        distance = hypot(x, left)
        if abs(distance - turn) >= radius:
            continue
        if x * x + y * y <= radius * radius:
            if x > 0.0:
                return 0.0
            continue
        behind = atan2(x, -left) % tau
        near = (turn * turn + distance * distance - radius * radius) / (
            2.0 * turn * distance
        )
        way = turn * ((behind - acos(min(1.0, max(-1.0, near)))) % tau)
        free = min(free, way)
    return free
