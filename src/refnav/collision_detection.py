"""CollisionDetection: stops the base before it hits something."""

from __future__ import annotations

from math import inf

from refnav.free_way import Point, free_way
from refrobots.components.collision_detection import CollisionDetectionBase
from rtgen.runtime import RTC_OK, ReturnCode_t, ServiceError


class CollisionDetection(CollisionDetectionBase):
    """Its observable `stopped` is 1 while it holds the base."""

    def on_initialize(self) -> ReturnCode_t:
        """Show whether the base is held."""
        self._stopped = False
        self.observables["stopped"] = lambda: (float(self._stopped),)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without knowledge."""
        self._points: list[Point] = []
        self._velocity = (0.0, 0.0)
        self._stopped = False
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Let go of the base."""
        return self._let_go()

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Stop the base when its way is too short, release it when it is not any more."""
        scan = self.obstacles.read_newest()
        if scan is not None:
            self._points = [(point.x, point.y) for point in scan.data]
        asked = self.velocity.read_newest()
        if asked is not None:
            self._velocity = (asked.data.vx, asked.data.va)
        if scan is None and asked is None:
            return RTC_OK
        if not self._too_near():
            return self._let_go()
        # With each scan anew: somebody else may have said Go.
        return self._stop() if scan is not None or not self._stopped else RTC_OK

    def _too_near(self) -> bool:
        config = self.config
        v, w = self._velocity
        if v <= 0.0:
            return False
        way = v * config.reaction + 0.5 * v * v / config.deceleration
        body = config.radiusOfBodyArea + config.margin
        return free_way(w / v, self._points, body, inf) < way

    def _stop(self) -> ReturnCode_t:
        try:
            self.BumpRefHard.object.Stop()
        except ServiceError as error:
            return self.fail(f"BumpRefHard: {error}")
        self._stopped = True
        return RTC_OK

    def _let_go(self) -> ReturnCode_t:
        if not self._stopped:
            return RTC_OK
        try:
            self.BumpRefHard.object.Go()
        except ServiceError as error:
            return self.fail(f"BumpRefHard: {error}")
        self._stopped = False
        return RTC_OK
