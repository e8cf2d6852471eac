"""Kinematics of a base: two driven wheels, or omni-wheels.

Velocities are in the frame of the body: forward, to the left, counter-clockwise. Odometry and the
simulated plant use the same equations, each with its own sizes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin, tau
from typing import Protocol


class Kinematics(Protocol):
    """The relation between the speeds of wheels and the velocity of a base."""

    @property
    def wheels(self) -> int:
        """Number of driven wheels."""

    def speeds(self, vx: float, vy: float, va: float) -> tuple[float, ...]:
        """Return the wheel speeds [rad/s] for a velocity of the body [m/s, m/s, rad/s]."""

    def motion(self, turns: Sequence[float]) -> tuple[float, float, float]:
        """Return the motion forward and to the left [m] and the turn [rad] of turning wheels [rad].

        Speeds [rad/s] give the velocity of the body.
        """


class TwoWheels:
    """A left and a right driven wheel; the base cannot move sideways. Radii and tread in m."""

    __slots__ = ("_left", "_right", "_tread")

    wheels = 2

    def __init__(self, left_radius: float, right_radius: float, tread: float) -> None:
        self._left = left_radius
        self._right = right_radius
        self._tread = tread

    def speeds(self, vx: float, vy: float, va: float) -> tuple[float, ...]:
        """Return the wheel speeds; `vy` is ignored."""
        side = 0.5 * va * self._tread
        return (vx - side) / self._left, (vx + side) / self._right

    def motion(self, turns: Sequence[float]) -> tuple[float, float, float]:
        """Return the motion, which is never sideways."""
        left = turns[0] * self._left
        right = turns[1] * self._right
        return 0.5 * (left + right), 0.0, (right - left) / self._tread


class OmniWheels:
    """Three or more omni-wheels, evenly on a circle round the centre, rolling along it.

    The first one is half a step to the left of the front. `radius` is that of a wheel, `distance`
    that of the circle [m].
    """

    __slots__ = ("_axes", "_distance", "_radius", "wheels")

    def __init__(self, wheels: int, radius: float, distance: float) -> None:
        self.wheels = wheels
        self._radius = radius
        self._distance = distance
        step = tau / wheels
        self._axes = [
            (-sin((i + 0.5) * step), cos((i + 0.5) * step)) for i in range(wheels)
        ]

    def speeds(self, vx: float, vy: float, va: float) -> tuple[float, ...]:
        """Return for each wheel the component of the velocity along its rolling direction."""
        round_ = va * self._distance
        return tuple((x * vx + y * vy + round_) / self._radius for x, y in self._axes)

    def motion(self, turns: Sequence[float]) -> tuple[float, float, float]:
        """Return the motion by least squares: four wheels and more may contradict each other."""
        forward = sideways = total = 0.0
        for turn, (x, y) in zip(turns, self._axes, strict=True):
            forward += x * turn
            sideways += y * turn
            total += turn
        size = 2.0 * self._radius / self.wheels
        return (
            size * forward,
            size * sideways,
            0.5 * size * total / self._distance,
        )
