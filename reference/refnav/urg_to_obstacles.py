"""Urg_to_Obstacles: converts scans to points, in the frame of the base."""

from __future__ import annotations

from math import cos, hypot, sin

from refrobots import iis, rtc
from refrobots.components.urg_to_obstacles import Urg_to_ObstaclesBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class Urg_to_Obstacles(Urg_to_ObstaclesBase):
    """Sends one list of points for each scan, which may be empty."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Convert the received scans."""
        while self.range.is_new() and (scan := self.range.read()) is not None:
            points = points_of(scan, self.config.spacing)
            self.obstacles.write(iis.TimedPoint2DSeq(scan.tm, [], points, []))
        return RTC_OK


def points_of(scan: rtc.RangeData, spacing: float) -> list[rtc.Point2D]:
    """Return the points of a scan, in the frame of the base [m], at least `spacing` apart.

    A range of 0 is not a point, whatever the least range: nothing was hit.
    """
    place = scan.geometry.geometry.pose
    settings = scan.config
    points: list[rtc.Point2D] = []
    for i, reach in enumerate(scan.ranges):
        if reach <= 0.0 or not settings.minRange <= reach <= settings.maxRange:
            continue
        angle = place.orientation.y + settings.minAngle + i * settings.angularRes
        x = place.position.x + reach * cos(angle)
        y = place.position.y + reach * sin(angle)
        if not points or hypot(points[-1].x - x, points[-1].y - y) >= spacing:
            points.append(rtc.Point2D(x, y))
    return points
