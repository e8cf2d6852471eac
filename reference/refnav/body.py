"""The body of a robot: simulated wheels, and odometry from their encoders."""

from __future__ import annotations

from math import tau
from typing import Protocol

from refnav.geometry import Pose, advance
from refnav.kinematics import Kinematics, OmniWheels, TwoWheels
from refnav.plant import Plant, counted

_STILL = (0.0, 0.0, 0.0)


class WheelLimits(Protocol):
    """Limits of all wheels of a robot [rad/s, rad/s^2], and counts of their encoders per turn."""

    max_wheel_speed: float
    max_wheel_acceleration: float
    EncoderCount: int


class TwoWheelSizes(WheelLimits, Protocol):
    """The parameters of a robot on two driven wheels [m]."""

    WheelRadius: float
    WheelTread: float


class OmniWheelSizes(WheelLimits, Protocol):
    """The parameters of a robot on omni-wheels [m]."""

    Wheels: int
    WheelRadius: float
    WheelDistance: float


class Body:
    """A body moved by driven wheels.

    `odometry` is the pose computed from the encoders. `goes_sideways`: the body can move sideways.
    """

    def __init__(
        self, kinematics: Kinematics, limits: WheelLimits, *, goes_sideways: bool
    ) -> None:
        self.plant = Plant(kinematics)
        self.goes_sideways = goes_sideways
        self.odometry = self.plant.pose
        self._limits = limits
        self._angles = [0.0] * kinematics.wheels

    def place(self, pose: Pose) -> None:
        """Set the body down at a pose, at rest."""
        self.plant.place(pose)
        self.odometry = pose

    def halt(self) -> None:
        """Stop all wheels at once."""
        self.plant.halt()

    def roll(self, dt: float) -> tuple[float, float, float]:
        """Move for `dt` [s] at the present wheel speeds.

        Returns the motion by the encoders: forward and to the left [m], turned [rad].
        """
        if not any(self.plant.speeds):
            return _STILL
        self.plant.roll(dt)
        count = tau / self._limits.EncoderCount
        angles = [counted(angle, count) for angle in self.plant.angles]
        turns = [new - old for new, old in zip(angles, self._angles, strict=True)]
        self._angles = angles
        forward, sideways, turn = motion = self.plant.kinematics.motion(turns)
        self.odometry = Pose(*advance(*self.odometry, forward, turn, sideways))
        return motion

    def drive(self, vx: float, vy: float, va: float, dt: float) -> None:
        """Accelerate the wheels for `dt` [s] towards a velocity of the body [m/s, m/s, rad/s]."""
        limits = self._limits
        self.plant.drive(
            self.plant.kinematics.speeds(vx, vy, va),
            limits.max_wheel_speed,
            limits.max_wheel_acceleration * dt,
        )


def on_two_wheels(sizes: TwoWheelSizes) -> Body:
    """Return the body of Ref-Hard and of the Segways."""
    wheels = TwoWheels(sizes.WheelRadius, sizes.WheelRadius, sizes.WheelTread)
    return Body(wheels, sizes, goes_sideways=False)


def on_omni_wheels(sizes: OmniWheelSizes) -> Body:
    """Return the body of Omni-Wheel."""
    wheels = OmniWheels(sizes.Wheels, sizes.WheelRadius, sizes.WheelDistance)
    return Body(wheels, sizes, goes_sideways=True)
