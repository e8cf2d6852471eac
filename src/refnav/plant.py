"""The simulated base: driven wheels with limits, their encoders, and where they carry the body."""

from __future__ import annotations

from collections.abc import Sequence

from refnav.geometry import Pose, advance
from refnav.kinematics import Kinematics
from refnav.limiter import limited


class Plant:
    """A base on driven wheels; its pose is that of the centre of the drive.

    `speeds` are those of the wheels [rad/s], `angles` what they have turned since the start [rad];
    (x, y, theta) is the true pose [m, rad]. `kinematics` has the true sizes.
    """

    __slots__ = ("_placed", "angles", "kinematics", "speeds", "theta", "x", "y")

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.angles = [0.0] * kinematics.wheels
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
        self.halt()

    def start(self, pose: Pose) -> None:
        """Set the base down, unless it was before: then it stays where it is."""
        if not self._placed:
            self.place(pose)

    def halt(self) -> None:
        """Hold all wheels at once."""
        self.speeds = [0.0] * self.kinematics.wheels

    def drive(self, targets: Sequence[float], most: float, step: float) -> None:
        """Bring each wheel nearer to its target speed [rad/s], within its limits.

        `most` is the greatest speed [rad/s], `step` the greatest change of it [rad/s].
        """
        speeds = self.speeds
        for i, target in enumerate(targets):
            speeds[i] = limited(speeds[i], target, most, step)

    def roll(self, dt: float) -> None:
        """Run for `dt` [s] at the present wheel speeds."""
        self.turn([speed * dt for speed in self.speeds])

    def turn(self, turns: Sequence[float]) -> None:
        """Move as the wheels turn by these angles [rad]."""
        angles = self.angles
        for i, turn in enumerate(turns):
            angles[i] += turn
        forward, sideways, turned = self.kinematics.motion(turns)
        self.x, self.y, self.theta = advance(
            self.x, self.y, self.theta, forward, turned, sideways
        )


def counted(angle: float, count: float) -> float:
    """What an encoder whose counts are so far apart makes of the angle of a wheel [rad]."""
    return angle // count * count
