"""TravelOdometry: the position of a robot from its travel information."""

from __future__ import annotations

from refnav.geometry import Pose, advance
from refnav.messages import pose_2d
from refrobots import iis
from refrobots.components.travel_odometry import TravelOdometryBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t


class TravelOdometry(TravelOdometryBase):
    """Integrates all samples; each velocity holds since the sample before."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start from the pose of the parameters."""
        config = self.config
        self._pose = Pose(config.start_x, config.start_y, config.start_theta)
        self._time = self.now()
        self._has_input = False
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the position for new information; samples that are not newer are ignored."""
        newest = None
        while self.information.is_new() and (sample := self.information.read()):
            time = sample.tm.sec * SECOND + sample.tm.nsec
            if time <= self._time:
                continue
            dt = (time - self._time) / SECOND
            self._time = time
            if 0.0 < self.config.InformationTimeout < dt:
                if self._has_input:
                    return self.fail(
                        f"information: none for {dt:.3f} s; where the robot is by now"
                        " is not known"
                    )
                dt = 0.0
            self._has_input = True
            data = sample.data
            moved = advance(*self._pose, data.vx * dt, data.va * dt, data.vy * dt)
            self._pose = Pose(*moved)
            newest = sample
        if newest is not None:
            self.position.write(iis.TimedPose2D(newest.tm, [], pose_2d(self._pose), []))
        return RTC_OK
