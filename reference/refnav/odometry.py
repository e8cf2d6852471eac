"""Odometry: the pose of the base from the angles of its wheels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, Protocol, TypeVar

from refnav.geometry import Pose, advance, wrap
from refnav.messages import pose_message, pose_of
from refnav.newest import Newest, all_in_time
from refrobots import checkpoints, iis, rtc
from refrobots.components.odometry import OdometryBase, OdometryConfiguration
from rtgen.runtime import RTC_OK, Component, InPort, OutPort, ReturnCode_t


class DeadReckoning:
    """Integrates the motion of a base with two driven wheels.

    Radii and axle in m; `left` and `right` are the indices of the wheels in the angles.
    """

    def __init__(
        self,
        start: Pose,
        radii: tuple[float, float],
        axle: float,
        wheels: tuple[int, int] = (0, 1),
    ) -> None:
        self.pose = Pose(start.x, start.y, wrap(start.theta))
        self._left_radius, self._right_radius = radii
        self._axle = axle
        self._left, self._right = wheels
        self.angles: tuple[float, float] | None = None
        """Angles of the left and the right wheel at the pose [rad]; None before the first ones."""

    def update(self, angles: Sequence[float]) -> Pose:
        """Return the pose after the wheels have turned to new absolute angles [rad].

        The first angles only set the origin. Raises IndexError if a wheel is missing.
        """
        left, right = angles[self._left], angles[self._right]
        if self.angles is not None:
            left_way = (left - self.angles[0]) * self._left_radius
            right_way = (right - self.angles[1]) * self._right_radius
            way = 0.5 * (left_way + right_way)
            turn = (right_way - left_way) / self._axle
            self.pose = Pose(*advance(*self.pose, way, turn))
        self.angles = (left, right)
        return self.pose


class OdometryParameters(Protocol):
    """The parameters of every odometry component [m]."""

    leftWheelID: int
    rightWheelID: int
    radiusOfLeftWheel: float
    radiusOfRightWheel: float
    lengthOfAxle: float
    WheelAngleTimeout: float


P = TypeVar("P", bound=OdometryParameters)


class Odometer(Component, Generic[P]):
    """Estimates the pose from the newest wheel angles, which are absolute.

    After a restart of its process it continues from the checkpoint, if the system keeps
    checkpoints.
    """

    config: P
    CurrentWheelAngle: InPort[rtc.TimedDoubleSeq]
    OdometryPosition: OutPort[iis.TimedPose2D]

    def _initial_pose(self) -> Pose:
        return Pose(0.0, 0.0, 0.0)

    def on_initialize(self) -> ReturnCode_t:
        """Watch the age of the wheel angles."""
        config = self.config
        self._wheels = Newest[rtc.TimedDoubleSeq](
            self.CurrentWheelAngle, lambda: config.WheelAngleTimeout
        )
        self._kept = self.add_checkpoint(checkpoints.Reckoning)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Read the parameters, and start from the initial pose."""
        config = self.config
        self._wheels.start(self.now())
        self._reckoning = DeadReckoning(
            self._initial_pose(),
            (config.radiusOfLeftWheel, config.radiusOfRightWheel),
            config.lengthOfAxle,
            (config.leftWheelID, config.rightWheelID),
        )
        if (kept := self._kept.restored()) is not None:
            self._reckoning.pose = pose_of(kept.pose)
            self._reckoning.angles = kept.left, kept.right
        self._stamp = (-1, 0)
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the pose for new wheel angles; angles that are not newer are ignored.

        Without wheel angles no pose is sent, so that components that need one stop.
        """
        now = self.now()
        sample = self._wheels.read_newest(now)
        all_in_time(self, now, *self._inputs)
        if sample is None or (sample.tm.sec, sample.tm.nsec) <= self._stamp:
            return RTC_OK
        self._stamp = (sample.tm.sec, sample.tm.nsec)
        try:
            pose = self._reckoning.update(sample.data)
        except IndexError:
            return self.fail(
                f"CurrentWheelAngle: {len(sample.data)} angles, a wheel is missing"
            )
        self._keep()
        if self._is_localized:
            found = iis.TimedPose2D(sample.tm, [], pose_message(pose), [])
            self.OdometryPosition.write(found)
        return RTC_OK

    def _keep(self) -> None:
        angles = self._reckoning.angles
        if self._kept.is_kept and self._is_localized and angles is not None:
            pose = pose_message(self._reckoning.pose)
            self._kept.save(checkpoints.Reckoning(pose, *angles))

    @property
    def _inputs(self) -> tuple[Newest[Any], ...]:
        """The inputs whose age is watched."""
        return (self._wheels,)

    @property
    def _is_localized(self) -> bool:
        """Whether there is a pose to integrate from."""
        return True


class Odometry(Odometer[OdometryConfiguration], OdometryBase):
    """Starts from the initial pose of the parameters."""

    def _initial_pose(self) -> Pose:
        config = self.config
        return Pose(
            config.initialPose_x, config.initialPose_y, config.initialPose_theta
        )
