"""Free distance of a round body along an arc until it touches an obstacle."""

from __future__ import annotations

from collections.abc import Iterable
from math import atan, copysign, inf, sqrt, tau

STRAIGHT = 1e-6
"""Arcs of less curvature are treated as straight [1/m]."""

Point = tuple[float, float]


def free_way(
    curvature: float, points: Iterable[Point], radius: float, horizon: float
) -> float:
    """Return the length of arc [m], at most `horizon`, that a body can drive forward untouched.

    The body is a circle of `radius` [m] round the origin, heading along x; `curvature` [1/m] is
    positive to the left. A point within the circle stops only a body that drives towards it.
    """
    if abs(curvature) < STRAIGHT:
        curvature = 0.0
    free = horizon
    for x, y in points:
        apart = 0.5 * (x * x + y * y - radius * radius)
        if apart > 0.0:
            free = min(free, _way_to(curvature, x, y, apart))
        elif x > 0.0:
            return 0.0
    return free


def _way_to(curvature: float, x: float, y: float, apart: float) -> float:
    """Return the length of arc until a point outside is touched; inf if the arc passes it."""
    # With s = 2 tan(way curvature / 2) / curvature, a touch means a s^2 - x s + apart = 0.
    a = 0.5 * (1.0 - y * curvature + 0.5 * apart * curvature * curvature)
    root = x * x - 4.0 * a * apart
    if root < 0.0:
        return inf
    sum_ = x + copysign(sqrt(root), x)
    ways = []
    if sum_:
        ways.append(_length(curvature, 2.0 * apart / sum_))
    ways.append(_length(curvature, 0.5 * sum_ / a if a else inf))
    return min(ways)


def _length(curvature: float, s: float) -> float:
    if not curvature:
        return s if s >= 0.0 else inf
    angle = 2.0 * atan(0.5 * s * abs(curvature))
    return (angle % tau) / abs(curvature)
