"""LocalizeCenter: the weighted mean of the poses from odometry and ceiling."""

from __future__ import annotations

from refnav.geometry import Pose, wrap
from refnav.messages import pose_message, pose_of
from refnav.newest import Newest, all_in_time
from refnav.pose_history import PoseHistory
from refrobots import iis
from refrobots.components.localize_center import LocalizeCenterBase
from rtgen.runtime import RTC_OK, ReturnCode_t

ANNOUNCEMENTS = 20
"""Number of executions that send the start pose."""
CEILING = 1.0 / 20.0
"""Weight of the ceiling: odometry has 19 times as much."""


class LocalizeCenter(LocalizeCenterBase):
    """Moves the pose of odometry a twentieth of the way to that of the ceiling.

    After another activation, it does not reset a running odometry to the start pose.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Watch the age of both inputs."""
        config = self.config
        self._odometry = Newest[iis.TimedPose2D](
            self.dp_odmIn, lambda: config.PositionTimeout
        )
        self._ceiling = Newest[iis.TimedPose2D](
            self.dp_ceilIn, lambda: config.CeilingTimeout
        )
        self._announced = False
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start at the start pose."""
        self._odometry.start(self.now())
        self._ceiling.start(self.now())
        self._executions = 0
        self._silent = 0
        self._history = PoseHistory()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the start pose at first, later the mean for each pose of the ceiling."""
        now = self.now()
        self._remember(now)
        ceiling = self._ceiling.read_newest(now)
        in_time = all_in_time(self, now, self._odometry, self._ceiling)
        if self._announced and self._executions == 0 and self._history:
            self._executions = ANNOUNCEMENTS
        self._executions += 1
        if self._executions <= ANNOUNCEMENTS:
            self._announced = True
            config = self.config
            self._send(Pose(config.startX, config.startY, config.startTheta))
            self._history.clear()
            return RTC_OK
        if not self._history:
            return RTC_OK
        if ceiling is not None and in_time:
            self._correct(ceiling)
        else:
            self._silent += 1
            if self._silent < self.config.cycle:
                return RTC_OK
        self._silent = 0
        self._send(self._history.newest)
        return RTC_OK

    def _remember(self, now: int) -> None:
        while self.dp_odmIn.is_new():
            sample = self._odometry.read(now)
            if sample is not None:
                self._history.add(sample)

    def _correct(self, ceiling: iis.TimedPose2D) -> None:
        seen = pose_of(ceiling.data)
        then = self._history.at(ceiling.tm)
        # All stored poses are corrected, so that the next picture is compared with corrected ones.
        self._history.move(
            CEILING * (seen.x - then.x),
            CEILING * (seen.y - then.y),
            CEILING * wrap(seen.theta - then.theta),
        )

    def _send(self, pose: Pose) -> None:
        sample = iis.TimedPose2D(data=pose_message(pose))
        self.stamp(sample)
        self.dp_out0.write(sample)
