"""CollisionDetection: stops the base before it hits an obstacle, and when data are missing."""

from __future__ import annotations

from math import inf

from refnav.free_way import free_way
from refnav.newest import Newest, complaints
from refnav.surroundings import Surroundings
from refrobots import iis
from refrobots.components.collision_detection import CollisionDetectionBase
from rtgen.runtime import RTC_OK, ReturnCode_t, ServiceError


class CollisionDetection(CollisionDetectionBase):
    """Stops the base while its free way is too short, or surroundings or velocity are unknown.

    Deactivation does not release a stopped base: it stays stopped until this component, or an
    operator, sends Go. The observable `stopped` is 1 while this component stops the base.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish whether the base is stopped."""
        config = self.config
        self._around = Surroundings(self.obstacles, lambda: config.ObstaclesTimeout)
        self._asked = Newest[iis.TimedVelocity2D](
            self.velocity, lambda: config.VelocityTimeout
        )
        self._stopped = False
        self.observables["stopped"] = lambda: (float(self._stopped),)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without data; a base that was stopped before stays stopped."""
        now = self.now()
        self._around.start(now)
        self._asked.start(now)
        self._velocity = (0.0, 0.0)
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Stop the base, because collisions are no longer detected."""
        self._call(stop=True)
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Stop the base before an obstacle, release it when the way is free."""
        now = self.now()
        v, w = (0.0, 0.0) if self._stopped else self._velocity
        fresh = self._around.look(now, v, w)
        asked = self._asked.read_newest(now)
        if asked is not None:
            self._velocity = (asked.data.vx, asked.data.va)
        late = complaints(now, self._around.scan, self._asked)
        hold = bool(late) or self._is_too_near()
        failure = ""
        # Repeat for each scan, and always without one: another client may have sent Go.
        if hold and (fresh or late or not self._stopped):
            failure = self._call(stop=True)
        elif self._stopped and not hold:
            failure = self._call(stop=False)
        self.report("; ".join(filter(None, (late, failure))))
        return RTC_OK

    def _is_too_near(self) -> bool:
        config = self.config
        v, w = self._velocity
        if v <= 0.0:
            return False
        if not self._around.seen:
            return True
        way = v * config.reaction + 0.5 * v * v / config.deceleration
        body = config.radiusOfBodyArea + config.margin
        return free_way(w / v, self._around.points, body, inf) < way

    def _call(self, *, stop: bool) -> str:
        """Stop or release the base; return why the call failed, which is then repeated."""
        bumper = self.BumpRefHard
        try:
            if stop:
                bumper.object.Stop()
            else:
                bumper.object.Go()
        except ServiceError as error:
            return f"BumpRefHard: {error}"
        self._stopped = stop
        return ""
