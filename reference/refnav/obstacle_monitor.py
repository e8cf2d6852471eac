"""ObstacleMonitor: the distance of obstacles, and a picture of them."""

from __future__ import annotations

from collections import deque
from math import cos, hypot, sin

from refnav.geometry import Pose
from refnav.messages import pose_of
from refnav.newest import Newest, all_in_time
from refnav.picture import MAX_TRAIL, Picture, PictureError
from refnav.pose_history import PoseHistory
from refrobots import iis, rtc
from refrobots.components.obstacle_monitor import ObstacleMonitorBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class ObstacleMonitor(ObstacleMonitorBase):
    """Records all scans while it is active, and draws them on deactivation.

    Its observable `nearest` is the distance of the nearest point of the newest scan [m], empty
    before the first scan.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish the distance of the nearest obstacle."""
        config = self.config
        self._position = Newest[iis.TimedPose2D](
            self.position, lambda: config.PositionTimeout
        )
        self._scan = Newest[iis.TimedPoint2DSeq](
            self.obstacles, lambda: config.ObstaclesTimeout
        )
        self._nearest: tuple[float, ...] = ()
        self.observables["nearest"] = lambda: self._nearest
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start an empty picture."""
        config = self.config
        self._position.start(self.now())
        self._scan.start(self.now())
        self._nearest = ()
        self._poses = PoseHistory()
        self._trail: deque[Pose] = deque(maxlen=MAX_TRAIL)
        self._seen: deque[list[tuple[float, float]]] = deque(maxlen=config.scans)
        if config.picture:
            try:
                self._picture = Picture(self.folder / config.picture)
            except PictureError as error:
                return self.fail(f"picture: {error}")
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Process the received scans."""
        now = self.now()
        while self.position.is_new():
            if (pose := self._position.read(now)) is not None:
                self._poses.add(pose)
                self._trail.append(pose_of(pose.data))
        all_in_time(self, now, self._position, self._scan)
        placed = not self._poses or not self._position.is_late(now)
        while self.obstacles.is_new():
            if (scan := self._scan.read(now)) is not None:
                self._look(scan, draw=placed)
        return RTC_OK

    def _look(self, scan: iis.TimedPoint2DSeq, *, draw: bool) -> None:
        if draw:
            pose = self._poses.at(scan.tm) if self._poses else Pose(0.0, 0.0, 0.0)
            along, across = cos(pose.theta), sin(pose.theta)
            self._seen.append(
                [
                    (
                        pose.x + point.x * along - point.y * across,
                        pose.y + point.x * across + point.y * along,
                    )
                    for point in scan.data
                ]
            )
        if scan.data:
            distance = min(hypot(point.x, point.y) for point in scan.data)
            self._nearest = (distance,)
            self.nearest.write(rtc.TimedDouble(scan.tm, distance))

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Draw the picture."""
        if not self.config.picture:
            return RTC_OK
        picture = self._picture
        picture.points(
            [point for points in self._seen for point in points], "0.4", "obstacles"
        )
        picture.line([pose[:2] for pose in self._trail], "tab:blue", "trail")
        if self._trail:
            picture.arrow(self._trail[-1], "tab:red", "pose")
        try:
            picture.save(self.instance_name)
        except PictureError as error:
            return self.fail(str(error))
        return RTC_OK
