"""Poses in the plane: normalised angles, motion along an arc.

Frames are right-handed, headings count counter-clockwise from the x axis. Units: m, rad.
"""

from __future__ import annotations

from math import cos, remainder, sin, tau
from typing import NamedTuple


class Pose(NamedTuple):
    """A pose in the plane [m, rad]."""

    x: float
    y: float
    theta: float


def wrap(angle: float) -> float:
    """Return the same angle within [-pi, pi] [rad]."""
    return remainder(angle, tau)


def wrap_positive(angle: float) -> float:
    """Return the same angle within [0, 2 pi) [rad], as in the interfaces of the third phase."""
    wrapped = angle % tau
    return wrapped if wrapped < tau else 0.0  # for an angle a little below 0


def advance(
    x: float,
    y: float,
    theta: float,
    distance: float,
    turn: float,
    sideways: float = 0.0,
) -> tuple[float, float, float]:
    """Return the pose (x, y, theta) after an arc of `distance` [m] and `turn` [rad].

    `sideways` [m] is the motion to the left of a base that can move so. Exact for constant
    velocities: the chord of the arc lies at its mean heading. The returned heading is normalised.
    """
    half = 0.5 * turn
    # Below 1 mrad, the next term of the series is smaller than rounding errors.
    if -1e-3 < half < 1e-3:
        near = 1.0 - half * half / 6.0
        chord, side = distance * near, sideways * near
    else:
        chord, side = distance * sin(half) / half, sideways * sin(half) / half
    mean = theta + half
    along, across = cos(mean), sin(mean)
    return (
        x + chord * along - side * across,
        y + chord * across + side * along,
        remainder(theta + turn, tau),
    )
