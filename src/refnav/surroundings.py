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
        self.seen = False
        """Whether there was a scan."""
        self._now = now

    def look(self, now: int, v: float, w: float, reach: float = inf) -> bool:
        """Move the points as the base has driven [m/s, rad/s]; return whether a new scan arrived.

        Points farther than `reach` [m] are left out.
        """
        self._move((now - self._now) / SECOND, v, w)
        self._now = now
        scan = self.scan.read_newest(now)
        if scan is None:
            return False
        self.points = [(p.x, p.y) for p in scan.data if hypot(p.x, p.y) <= reach]
        self.seen = True
        taken = scan.tm.sec * SECOND + scan.tm.nsec
        if 0 < taken < now:
            self._move((now - taken) / SECOND, v, w)
        return True

    def is_known(self, now: int) -> bool:
        """Return whether there is a scan within the age limit."""
        return self.seen and not self.scan.is_late(now)

    def _move(self, dt: float, v: float, w: float) -> None:
        if not self.points or (v, w) == (0.0, 0.0):
            return
        x, y, theta = advance(0.0, 0.0, 0.0, v * dt, w * dt)
        along, across = cos(theta), sin(theta)
        self.points = [
            (
                (px - x) * along + (py - y) * across,
                (py - y) * along - (px - x) * across,
            )
            for px, py in self.points
        ]
