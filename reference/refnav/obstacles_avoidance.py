"""ObstaclesAvoidance: changes the velocity so that the base passes obstacles."""

from __future__ import annotations

from math import copysign, cos, pi, sin, sqrt

from refnav.free_way import STRAIGHT, free_way
from refnav.newest import complaints
from refnav.surroundings import Surroundings
from refnav.way_round import WayRound
from refrobots import iis, rtc
from refrobots.components.obstacles_avoidance import ObstaclesAvoidanceBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t

SIDE_STEPS = 10
"""Number of arcs tried on either side."""
DETOUR_COST = 0.1
"""Cost of leaving the commanded arc, per 1/m; progress by the horizon is worth 1."""
CHANGE_COST = 0.05
"""Cost of leaving the current arc, per 1/m."""

MIN_WAY = 0.3
"""A free way shorter than this is left, if the base can turn to a longer one [m]."""
TURN_STEP = pi / 12
"""Angle between directions in which a way is searched [rad]."""
MAX_TURNS = 8
"""Number of these directions on either side: no scan covers what is behind the base."""
STUCK = SECOND // 2
"""Time without any way after which the base is stuck, and it is not the noise of a scan [ns]."""


class ObstaclesAvoidance(ObstaclesAvoidanceBase):
    """Plans with each scan; between scans the points are moved by the commanded velocity.

    If no arc makes progress, the base turns on the spot towards a direction that does; if there is
    none, or turning led back to the same place before, it takes the shortest way round on the map
    that it has drawn, back out of a dead end and past the other side. If that is not there either,
    or led back, too, it stands. Its observable `free` is the free way ahead [m].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish the free way."""
        config = self.config
        self._around = Surroundings(self.obstacles, lambda: config.ObstaclesTimeout)
        self._free: tuple[float, ...] = ()
        self.observables["free"] = lambda: self._free
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without a scan: nothing is known to be free."""
        now = self.now()
        self._around.start(now)
        self._driven = (0.0, 0.0)
        self._round = WayRound(now, self._way)
        self._follow()
        self._free = ()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Stop the base."""
        self._send(iis.TimedVelocity2D())
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Stop the base."""
        self._send(iis.TimedVelocity2D())
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the velocity to drive, for each new commanded one."""
        config = self.config
        now = self.now()
        reach = config.horizon + config.radiusOfBodyArea + config.clearance
        fresh = self._around.look(now, *self._driven, reach)
        self._round.move(now, *self._driven, free=self._detour is None)
        if fresh:
            self._round.look(self._around.scanned, self._radius)
        asked = self.velocity_in.read_newest()
        if asked is None:
            return RTC_OK
        sideways = asked.data.vy
        if self._around.is_known(now):
            v, w = self._allowed(asked.data.vx, asked.data.va, fresh=fresh)
        else:
            v, sideways, w = 0.0, 0.0, 0.0
            self.report(complaints(now, self._around.scan))
        self._driven = (v, w)
        self._send(
            iis.TimedVelocity2D(
                id=asked.id, data=rtc.Velocity2D(v, sideways, w), error=asked.error
            )
        )
        return RTC_OK

    def _send(self, sample: iis.TimedVelocity2D) -> None:
        self.stamp(sample)
        self.velocity_out.write(sample)

    def _follow(self) -> None:
        """Pass the commanded velocity on, because it is free of obstacles."""
        self._detour: float | None = None
        self._turning = 0.0
        self._led_back = False
        self._stuck_since: int | None = None
        self._round.leave()
        self.report("")

    def _allowed(self, v: float, w: float, *, fresh: bool) -> tuple[float, float]:
        config = self.config
        if v <= 0.0:
            # Turning does not move a circle; what is behind the base is not scanned.
            self._follow()
            return v, w
        if self._round.is_taken:
            return self._drive_round(v)
        asked = w / v
        free = self._way(asked)
        if free >= config.horizon:
            self._follow()
            self._free = (free,)
            return v, w
        if fresh or self._detour is None:
            self._detour = self._plan(asked)
            free = self._way(self._detour)
            # The base turns until the way ahead is long enough.
            if free < MIN_WAY and (self._turning or self._led_back or free == 0.0):
                self._turn_on_the_spot()
            else:
                self._turning = 0.0
                self._led_back = False
        free = self._way(self._detour)
        stuck = self._led_back or (free == 0.0 and not self._turning)
        if self._is_stuck(stuck) and self._round.take(self._radius):
            return self._drive_round(v)
        self.report("no way ahead, and none to turn to" if stuck else "")
        if self._turning or self._led_back:
            return 0.0, self._turning
        return self._drive(self._detour, v)

    def _is_stuck(self, stuck: bool) -> bool:
        """Return whether the base has been stuck for long enough to take a way round."""
        now = self.now()
        if not stuck:
            self._stuck_since = None
        elif self._stuck_since is None:
            self._stuck_since = now
        waited = self._stuck_since is not None and now - self._stuck_since >= STUCK
        return waited or self._led_back

    def _drive_round(self, v: float) -> tuple[float, float]:
        self._detour = 0.0
        self._turning = 0.0
        self._led_back = False
        self._stuck_since = None
        self.report("")
        curvature, turn = self._round.curvature()
        if turn:
            return 0.0, turn * self.config.max_w
        return self._drive(curvature, v)

    def _drive(self, curvature: float, v: float) -> tuple[float, float]:
        """Return the velocity along an arc, at most `v` [m/s, rad/s]: slower the less is free."""
        config = self.config
        free = self._way(curvature)
        self._free = (free,)
        speed = min(v, sqrt(2.0 * config.deceleration * free))
        if abs(curvature) > STRAIGHT:
            speed = min(speed, config.max_w / abs(curvature))
        return speed, speed * curvature

    def _plan(self, asked: float) -> float:
        """Return the curvature with the best progress minus the cost of detours [1/m]."""
        config = self.config
        most = 1.0 / config.min_radius
        before = asked if self._detour is None else self._detour
        tried = [most * i / SIDE_STEPS for i in range(-SIDE_STEPS, SIDE_STEPS + 1)]
        tried.append(min(most, max(-most, asked)))

        def worth(curvature: float) -> float:
            return (
                _ahead(self._way(curvature), curvature) / config.horizon
                - DETOUR_COST * abs(curvature - asked)
                - CHANGE_COST * abs(curvature - before)
            )

        return max(tried, key=worth)

    def _turn_on_the_spot(self) -> None:
        """Go on with a turn, or begin one, unless turning has led back to this place before."""
        turn = self._direction(self._turning)
        if turn and not self._turning:
            self._led_back = not self._round.turn()
        self._turning = 0.0 if self._led_back else turn

    def _direction(self, turn: float) -> float:
        """Return the angular speed that turns to the nearest way; 0 if there is none to turn to.

        The direction of a turn is kept until it ends: otherwise the base would oscillate.
        """
        radius, points = self._radius, self._around.points
        for step in range(1, MAX_TURNS + 1):
            for side in (1.0, -1.0) if turn >= 0.0 else (-1.0, 1.0):
                if turn and side != copysign(1.0, turn):
                    continue
                along, across = cos(step * TURN_STEP), side * sin(step * TURN_STEP)
                turned = [
                    (x * along + y * across, y * along - x * across) for x, y in points
                ]
                if free_way(0.0, turned, radius, self.config.horizon) >= MIN_WAY:
                    return side * self.config.max_w
        return 0.0

    @property
    def _radius(self) -> float:
        return self.config.radiusOfBodyArea + self.config.clearance

    def _way(self, curvature: float) -> float:
        return free_way(
            curvature, self._around.points, self._radius, self.config.horizon
        )


def _ahead(way: float, curvature: float) -> float:
    """Return the progress of an arc in the forward direction [m]; none beyond a quarter turn."""
    if abs(curvature) < STRAIGHT:
        return way
    return sin(min(way * abs(curvature), pi / 2)) / abs(curvature)
