"""ObstaclesAvoidance: changes the velocity so that the base passes what stands in its way."""

from __future__ import annotations

from math import cos, hypot, pi, sin, sqrt

from refnav.free_way import STRAIGHT, Point, free_way
from refnav.geometry import advance
from refrobots import iis, rtc
from refrobots.components.obstacles_avoidance import ObstaclesAvoidanceBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t

SIDE_STEPS = 10
"""So many arcs are tried to either side."""
DETOUR = 0.1
"""What it costs to leave the arc asked for, per 1/m, where getting on by the horizon is worth 1."""
CHANGE = 0.05
"""What it costs to leave the arc driven so far, per 1/m."""


class ObstaclesAvoidance(ObstaclesAvoidanceBase):
    """Plans with each scan; between two scans the points move as the base was told to.

    Its observable `free` is the free way ahead [m].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Show the free way."""
        self._free: tuple[float, ...] = ()
        self.observables["free"] = lambda: self._free
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Wait for a scan: nothing is known to be free before."""
        self._points: list[Point] = []
        self._heard: int | None = None
        self._now = self.now()
        self._driven = (0.0, 0.0)
        self._detour: float | None = None
        self._free = ()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send what is to be driven, for a new velocity."""
        now = self.now()
        self._move((now - self._now) / SECOND)
        self._now = now
        fresh = self._look(now)
        asked = self.velocity_in.read_newest()
        if asked is None:
            return RTC_OK
        v, w = self._allowed(asked.data.vx, asked.data.va, fresh)
        sideways = asked.data.vy
        if not self._known(now):
            v, sideways, w = 0.0, 0.0, 0.0
        self._driven = (v, w)
        sample = iis.TimedVelocity2D(
            id=asked.id, data=rtc.Velocity2D(v, sideways, w), error=asked.error
        )
        self.stamp(sample)
        self.velocity_out.write(sample)
        return RTC_OK

    def _known(self, now: int) -> bool:
        limit = self.config.ObstaclesTimeout
        return self._heard is not None and (
            limit <= 0.0 or now - self._heard <= limit * SECOND
        )

    def _look(self, now: int) -> bool:
        scan = self.obstacles.read_newest()
        if scan is None:
            return False
        config = self.config
        reach = config.horizon + config.radiusOfBodyArea + config.clearance
        self._points = [(p.x, p.y) for p in scan.data if hypot(p.x, p.y) <= reach]
        self._heard = now
        return True

    def _move(self, dt: float) -> None:
        v, w = self._driven
        if not self._points or (v, w) == (0.0, 0.0):
            return
        x, y, theta = advance(0.0, 0.0, 0.0, v * dt, w * dt)
        along, across = cos(theta), sin(theta)
        self._points = [
            (
                (px - x) * along + (py - y) * across,
                (py - y) * along - (px - x) * across,
            )
            for px, py in self._points
        ]

    def _allowed(self, v: float, w: float, fresh: bool) -> tuple[float, float]:
        config = self.config
        if v <= 0.0:
            # Turning does not move a circle, and backwards nothing is seen.
            self._detour = None
            return v, w
        asked = w / v
        free = self._way(asked)
        if free >= config.horizon:
            self._detour = None
            self._free = (free,)
            return v, w
        if fresh or self._detour is None:
            self._detour = self._plan(asked)
        curvature = self._detour
        free = self._way(curvature)
        self._free = (free,)
        speed = min(v, sqrt(2.0 * config.deceleration * free))
        if abs(curvature) > STRAIGHT:
            speed = min(speed, config.max_w / abs(curvature))
        return speed, speed * curvature

    def _plan(self, asked: float) -> float:
        """The curvature that gets on best, detours counted against it [1/m]."""
        config = self.config
        most = 1.0 / config.min_radius
        before = asked if self._detour is None else self._detour
        tried = [most * i / SIDE_STEPS for i in range(-SIDE_STEPS, SIDE_STEPS + 1)]
        tried.append(min(most, max(-most, asked)))

        def worth(curvature: float) -> float:
            return (
                _ahead(self._way(curvature), curvature) / config.horizon
                - DETOUR * abs(curvature - asked)
                - CHANGE * abs(curvature - before)
            )

        return max(tried, key=worth)

    def _way(self, curvature: float) -> float:
        config = self.config
        radius = config.radiusOfBodyArea + config.clearance
        return free_way(curvature, self._points, radius, config.horizon)


def _ahead(way: float, curvature: float) -> float:
    """How far an arc leads ahead [m]; a base that turns round gets on no further."""
    if abs(curvature) < STRAIGHT:
        return way
    return sin(min(way * abs(curvature), pi / 2)) / abs(curvature)
