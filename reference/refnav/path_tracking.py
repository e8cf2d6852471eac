"""PathTracking: sends the travel commands that keep a robot on its path."""

from __future__ import annotations

from refnav.geometry import Pose
from refnav.messages import pose_2d, pose_of
from refnav.newest import Newest, all_in_time
from refnav.pose_history import jumped
from refnav.tracking import Progress, Tracker
from refrobots import iis
from refrobots.components.path_tracking import PathTrackingBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class PathTracking(PathTrackingBase):
    """Follows the newest path; rests without a path, and while the position is too old."""

    def on_initialize(self) -> ReturnCode_t:
        """Watch the age of the position."""
        config = self.config
        self._position = Newest[iis.TimedPose2D](
            self.position, lambda: config.PositionTimeout
        )
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without path."""
        self._position.start(self.now())
        self._tracker = Tracker([], [])
        self._here: Pose | None = None
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Stop the robot."""
        self._halt()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Stop the robot."""
        self._halt()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Read a new path and the newest position, and send command and state."""
        path = self.path.read_newest()
        if path is not None:
            if path.velocity and len(path.velocity) != len(path.pose):
                return self.fail(
                    f"path: {len(path.velocity)} velocities for {len(path.pose)}"
                    " waypoints"
                )
            self._take(path)
        now = self.now()
        sample = self._position.read_newest(now)
        in_time = all_in_time(self, now, self._position)
        if sample is not None:
            before, self._here = self._here, pose_of(sample.data)
            if before and self._tracker.is_under_way:
                jump = jumped(before, self._here, self.config.MaxJump)
                if jump:
                    return self.fail(f"position: {jump}")
            for progress in self._tracker.step(self._here, self.config):
                self._report_progress(progress)
        if self._here is not None and in_time:
            self._send(*self._tracker.command(self._here, self.config))
        else:
            self._send(0.0, 0.0)
        return RTC_OK

    def _halt(self) -> None:
        self._send(0.0, 0.0)
        if self._tracker.is_under_way:
            self._report_progress(self._tracker.interrupted())

    def _take(self, path: iis.TimedPath2DSeq) -> None:
        if path.pose:
            speeds = [velocity.vx for velocity in path.velocity]
            self._tracker = Tracker(
                [pose_of(pose) for pose in path.pose], speeds or [0.0] * len(path.pose)
            )
        else:
            self._tracker.stop()

    def _send(self, v: float, w: float) -> None:
        command = iis.TimedVelocity2D()
        command.data.vx = v
        command.data.va = w
        self.stamp(command)
        self.command.write(command)

    def _report_progress(self, progress: Progress) -> None:
        ids = [progress.number, int(progress.stopped)]
        state = iis.TimedPose2D(id=ids, data=pose_2d(progress.waypoint))
        self.stamp(state)
        self.state.write(state)
