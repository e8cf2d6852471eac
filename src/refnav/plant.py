"""The simulated base: two driven wheels with limits, and their encoders."""

from __future__ import annotations

from refnav.geometry import Pose, advance
from refnav.limiter import limited


class DifferentialDrive:
    """A base with two driven wheels; its pose is that of the centre of the drive axle.

    `left` and `right` are wheel speeds [rad/s], `left_angle` and `right_angle` the angles the
    wheels have turned since the start [rad]; (x, y, theta) is the true pose [m, rad].
    """

    __slots__ = ("left", "left_angle", "right", "right_angle", "theta", "x", "y")

    def __init__(self) -> None:
        self.place(Pose(0.0, 0.0, 0.0))
        self.left_angle = 0.0
        self.right_angle = 0.0

    @property
    def pose(self) -> Pose:
        """The true pose."""
        return Pose(self.x, self.y, self.theta)

    def place(self, pose: Pose) -> None:
        """Set the base down at a pose, at rest."""
        self.x, self.y, self.theta = pose
        self.halt()

    def halt(self) -> None:
        """Hold both wheels at once."""
        self.left = 0.0
        self.right = 0.0

    def drive(self, left: float, right: float, most: float, step: float) -> None:
        """Bring each wheel nearer to its target speed [rad/s], within its limits.

        `most` is the greatest speed [rad/s], `step` the greatest change of it [rad/s].
        """
        self.left = limited(self.left, left, most, step)
        self.right = limited(self.right, right, most, step)

    def roll(
        self, dt: float, left_radius: float, right_radius: float, tread: float
    ) -> None:
        """Run for `dt` [s] at the present wheel speeds; wheel radii and tread in m."""
        self.turn(self.left * dt, self.right * dt, left_radius, right_radius, tread)

    def turn(
        self,
        left_turn: float,
        right_turn: float,
        left_radius: float,
        right_radius: float,
        tread: float,
    ) -> None:
        """Move as the wheels turn by these angles [rad]; wheel radii and tread in m."""
        self.left_angle += left_turn
        self.right_angle += right_turn
        left_way = left_turn * left_radius
        right_way = right_turn * right_radius
        self.x, self.y, self.theta = advance(
            self.x,
            self.y,
            self.theta,
            0.5 * (left_way + right_way),
            (right_way - left_way) / tread,
        )


def counted(angle: float, count: float) -> float:
    """What an encoder whose counts are so far apart makes of the angle of a wheel [rad]."""
    return angle // count * count
