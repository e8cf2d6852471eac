"""Poses in the plane: wrapped angles, motion along an arc.

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
    """The same angle within [-pi, pi] [rad]."""
    return remainder(angle, tau)


def advance(
    x: float, y: float, theta: float, distance: float, turn: float
) -> tuple[float, float, float]:
    """The pose (x, y, theta) after an arc of length `distance` [m] that turns by `turn` [rad].

    Exact for constant velocities: the chord of the arc lies at its mean heading. The heading
    comes back wrapped.
    """
    half = 0.5 * turn
    # Below 1 mrad the next term of the series is lost in rounding.
    if -1e-3 < half < 1e-3:
        chord = distance * (1.0 - half * half / 6.0)
    else:
        chord = distance * sin(half) / half
    mean = theta + half
    return x + chord * cos(mean), y + chord * sin(mean), remainder(theta + turn, tau)
