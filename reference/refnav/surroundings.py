"""Surroundings of the base: the points of the latest scan, moved as the base drives on."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, hypot, inf, sin

from refnav.free_way import Point
from refnav.geometry import advance
from refnav.newest import Newest
from refrobots import iis
from rtgen.runtime import SECOND, InPort


class Surroundings:
    """Points in the frame of the base [m], and the age of their scan.

    `limit` returns the greatest age [s] at which the points may be used; 0: any age.
    """

    def __init__(
        self, port: InPort[iis.TimedPoint2DSeq], limit: Callable[[], float]
    ) -> None:
        self.scan = Newest[iis.TimedPoint2DSeq](port, limit)
        """The input of scans."""
        self.start(0)

    def start(self, now: int) -> None:
        """Start at the time `now` [ns], without a scan."""
        self.scan.start(now)
        self.points: list[Point] = []
        self.scanned: list[Point] = []
        """The points of the latest scan when it arrived, far ones too."""
        self.seen = False
        """Whether there was a scan."""
        self._now = now

    def look(self, now: int, v: float, w: float, reach: float = inf) -> bool:
        """Move the points as the base has driven [m/s, rad/s]; return whether a new scan arrived.

        Points farther than `reach` [m] are left out.
        """
        self.points = _moved(self.points, (now - self._now) / SECOND, v, w)
        self._now = now
        scan = self.scan.read_newest(now)
        if scan is None:
            return False
        self.seen = True
        taken = scan.tm.sec * SECOND + scan.tm.nsec
        age = (now - taken) / SECOND if 0 < taken < now else 0.0
        points = [(p.x, p.y) for p in scan.data]
        self.scanned = _moved(points, age, v, w)
        self.points = [
            moved
            for point, moved in zip(points, self.scanned, strict=True)
            if hypot(*point) <= reach
        ]
        return True

    def is_known(self, now: int) -> bool:
        """Return whether there is a scan within the age limit."""
        return self.seen and not self.scan.is_late(now)


def _moved(points: list[Point], dt: float, v: float, w: float) -> list[Point]:
    """Return the points in the frame of a base that has driven for `dt` [s]."""
    if not points or (v, w) == (0.0, 0.0):
        return points
    x, y, theta = advance(0.0, 0.0, 0.0, v * dt, w * dt)
    along, across = cos(theta), sin(theta)
    return [
        ((px - x) * along + (py - y) * across, (py - y) * along - (px - x) * across)
        for px, py in points
    ]
