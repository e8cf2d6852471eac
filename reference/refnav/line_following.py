"""Travel modes: from the pose of the base to the velocity that it should have.

Each class is one travel mode. `observe` takes a new pose of the base; `reference` returns the
wanted speed [m/s] and angular speed [rad/s] for one execution, from the velocity (v, w) commanded
last. The caller limits the result (`refnav.limiter`).

The law is that of the University of Tsukuba's locomotion commands: an angular acceleration against
the distance from the line, the angle to it and the angular velocity (Yuta and Kanayama 1985; Iida
and Yuta 1991), as the PathFollower of the RH2 modules applies it.
"""

from __future__ import annotations

from math import atan2, copysign, cos, hypot, pi, remainder, sin, sqrt, tau
from typing import Protocol

from refnav.geometry import Pose


class Gains(Protocol):
    """The parameters of the control laws; units as in PathFollower's definition."""

    control_cycle: float
    line_Dist: float
    line_K1: float
    line_K2: float
    line_K3: float
    max_acc_w: float


class Motion(Protocol):
    """A travel mode."""

    def observe(self, pose: Pose) -> None:
        """Store the newest pose of the base."""

    def reference(self, v: float, w: float, gains: Gains) -> tuple[float, float]:
        """Return the wanted (v, w) [m/s, rad/s]; the arguments are those commanded last."""


def regulate(distance: float, angle: float, v: float, w: float, gains: Gains) -> float:
    """Return the next angular speed on a line [rad/s].

    `distance` is that of the base from the line, positive to its left [m], `angle` the heading of
    the base against the line [rad]. `w` is the angular speed relative to that of the line [rad/s].
    """
    most = gains.line_Dist
    if distance > most:
        distance = most
    elif distance < -most:
        distance = -most
    if v < 0.0:
        distance = -distance
    return w - gains.control_cycle * (
        gains.line_K1 * distance + gains.line_K2 * angle + gains.line_K3 * w
    )


class Constant:
    """RUN_VEL, and RUN_STOP with both speeds 0."""

    __slots__ = ("_reference",)

    def __init__(self, v: float, w: float) -> None:
        self._reference = (v, w)

    def observe(self, pose: Pose) -> None:
        """Ignore the pose."""

    def reference(self, v: float, w: float, gains: Gains) -> tuple[float, float]:
        """Return the commanded speeds."""
        return self._reference


class LineFollow:
    """RUN_LINEFOLLOW: along the line through (x, y) with direction theta, at a speed.

    `distance` is that of the base, positive to the left of the line [m].
    """

    __slots__ = ("_angle", "_cos", "_heading", "_sin", "_speed", "_x", "_y", "distance")

    def __init__(self, x: float, y: float, theta: float, speed: float) -> None:
        self._x = x
        self._y = y
        self._heading = theta
        self._cos = cos(theta)
        self._sin = sin(theta)
        self._speed = speed
        self.distance = 0.0
        self._angle = 0.0

    def observe(self, pose: Pose) -> None:
        """Compute the distance from the line, and the angle to it."""
        x, y, theta = pose
        self.distance = (y - self._y) * self._cos - (x - self._x) * self._sin
        self._angle = remainder(theta - self._heading, tau)

    def reference(self, v: float, w: float, gains: Gains) -> tuple[float, float]:
        """Return the commanded speed, with a correction towards the line."""
        return self._speed, regulate(self.distance, self._angle, v, w, gains)


class ToPoint(LineFollow):
    """RUN_TO_POINT: along the same line, to rest at (x, y)."""

    __slots__ = ("_remaining",)

    def __init__(self, x: float, y: float, theta: float, speed: float) -> None:
        super().__init__(x, y, theta, speed)
        self._remaining = 0.0

    def observe(self, pose: Pose) -> None:
        """Compute also the remaining distance along the line."""
        super().observe(pose)
        self._remaining = (self._x - pose.x) * self._cos + (
            self._y - pose.y
        ) * self._sin

    def reference(self, v: float, w: float, gains: Gains) -> tuple[float, float]:
        """Return at most the speed that covers the rest in one second; 0 beyond the point."""
        speed = max(0.0, min(self._speed, self._remaining))
        return speed, regulate(self.distance, self._angle, v, w, gains)


class CircleFollow:
    """RUN_CIRCLEFOLLOW: around (x, y) at a radius, counter-clockwise if that is positive.

    The control law is the line's, with the angular speed of the circle as feed-forward: otherwise
    the base would settle outside the circle.
    """

    __slots__ = ("_angle", "_distance", "_radius", "_side", "_speed", "_x", "_y")

    def __init__(self, x: float, y: float, radius: float, speed: float) -> None:
        self._x = x
        self._y = y
        self._radius = radius
        self._side = copysign(1.0, radius)
        self._speed = speed
        self._distance = 0.0
        self._angle = 0.0

    def observe(self, pose: Pose) -> None:
        """Compute angle and distance from the circle, the distance positive to the left."""
        x, y, theta = pose
        along = x - self._x
        across = y - self._y
        self._distance = self._side * (abs(self._radius) - hypot(along, across))
        tangent = atan2(across, along) + self._side * 0.5 * pi
        self._angle = remainder(theta - tangent, tau)

    def reference(self, v: float, w: float, gains: Gains) -> tuple[float, float]:
        """Return the commanded speed, with a correction towards the circle."""
        turn = self._speed / self._radius
        return self._speed, turn + regulate(
            self._distance, self._angle, v, w - turn, gains
        )


SLOWEST_SPIN = pi / 90.0
"""A braking spin is not slower than 2 degrees a second [rad/s]."""


class Spin:
    """RUN_SPIN: turn on the spot to a heading, braking in time."""

    __slots__ = ("_angle", "_heading", "_speed")

    def __init__(self, theta: float, speed: float) -> None:
        self._heading = theta
        self._speed = speed
        self._angle = 0.0

    def observe(self, pose: Pose) -> None:
        """Compute the remaining angle."""
        self._angle = remainder(self._heading - pose.theta, tau)

    def reference(self, v: float, w: float, gains: Gains) -> tuple[float, float]:
        """Return the commanded speed, or that from which a tenth of `max_acc_w` still brakes."""
        angle = self._angle
        braking = sqrt(0.2 * gains.max_acc_w * abs(angle) / gains.control_cycle)
        speed = self._speed if self._speed < braking else max(braking, SLOWEST_SPIN)
        return 0.0, speed if angle >= 0.0 else -speed
