"""Simulation of a base: driven wheels with limits, their encoders, and the resulting pose."""

from __future__ import annotations

from collections.abc import Sequence

from refnav.geometry import Pose, advance
from refnav.kinematics import Kinematics
from refnav.limiter import limited
from refnav.room import Room


class Plant:
    """A base on driven wheels; its pose is that of the centre of the drive.

    `speeds` are those of the wheels [rad/s], `angles` their turns since the start [rad]; (x, y,
    theta) is the true pose [m, rad]. `kinematics` has the true sizes. A body of `radius` [m] that
    reaches something of the `room` stops there, and `touches` it.
    """

    __slots__ = (
        "_placed",
        "_space",
        "angles",
        "kinematics",
        "radius",
        "room",
        "speeds",
        "theta",
        "touches",
        "x",
        "y",
    )

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.angles = [0.0] * kinematics.wheels
        self.room = Room(())
        self.radius = 0.0
        self.touches = False
        self.place(Pose(0.0, 0.0, 0.0))
        self._placed = False

    @property
    def pose(self) -> Pose:
        """The true pose."""
        return Pose(self.x, self.y, self.theta)

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Forward and to the left [m/s], counter-clockwise [rad/s]."""
        return self.kinematics.motion(self.speeds)

    def place(self, pose: Pose) -> None:
        """Set the base down at a pose, at rest."""
        self.x, self.y, self.theta = pose
        self._placed = True
        self._space = 0.0
        self.halt()

    def restore(self, pose: Pose, angles: Sequence[float]) -> None:
        """Set the base down at rest, with the angles of its wheels."""
        self.place(pose)
        self.angles = list(angles)

    def start(self, pose: Pose) -> None:
        """Set the base down the first time; later calls do nothing."""
        if not self._placed:
            self.place(pose)

    def halt(self) -> None:
        """Stop all wheels at once."""
        self.speeds = [0.0] * self.kinematics.wheels

    def drive(self, targets: Sequence[float], most: float, step: float) -> None:
        """Accelerate each wheel towards its target speed [rad/s], within its limits.

        `most` is the greatest speed [rad/s], `step` the greatest change of it [rad/s].
        """
        speeds = self.speeds
        for i, target in enumerate(targets):
            if target == speeds[i] and -most <= target <= most:
                speeds[i] = target
            else:
                speeds[i] = limited(speeds[i], target, most, step)

    def roll(self, dt: float) -> None:
        """Move for `dt` [s] at the present wheel speeds."""
        self.turn([speed * dt for speed in self.speeds])

    def turn(self, turns: Sequence[float]) -> None:
        """Move by these turns of the wheels [rad]."""
        angles = self.angles
        for i, turn in enumerate(turns):
            angles[i] += turn
        forward, sideways, turned = self.kinematics.motion(turns)
        x, y, self.theta = advance(
            self.x, self.y, self.theta, forward, turned, sideways
        )
        way = abs(forward) + abs(sideways)
        self.touches = bool(self.room.things) and self._is_blocked(x, y, way)
        if self.touches:
            # Wheels of a blocked body slip: encoders count, the pose is unchanged.
            self.halt()
        else:
            self.x, self.y = x, y

    def _is_blocked(self, x: float, y: float, way: float) -> bool:
        """Return whether the body cannot reach a point, at most `way` [m] away."""
        # A way shorter than the clearance measured last is free.
        self._space -= way
        if self._space > 0.0:
            return False
        space = self.room.distance(x, y) - self.radius
        if space <= 0.0 and space < self.room.distance(self.x, self.y) - self.radius:
            return True
        self._space = space
        return False


def counted(angle: float, count: float) -> float:
    """Return the angle of a wheel quantized by an encoder with this resolution [rad]."""
    return angle // count * count
