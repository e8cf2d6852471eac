"""PathFollower: computes the velocity of the base that follows the waypoint."""

from __future__ import annotations

from refnav.geometry import Pose
from refnav.limiter import limited
from refnav.line_following import (
    CircleFollow,
    Constant,
    LineFollow,
    Motion,
    Spin,
    ToPoint,
)
from refnav.messages import pose_of
from refnav.newest import Newest, all_in_time
from refrobots import iis, rtc
from refrobots.components.path_follower import PathFollowerBase
from rtgen.runtime import RTC_OK, ReturnCode_t

STOP = Constant(0.0, 0.0)


def motion(path: rtc.Path) -> Motion:
    """Return the controller for a waypoint's mode of travel.

    RUN_FREE and RUN_WHEEL_VEL cannot be expressed by a velocity of the base, which stops, as in
    RUN_STOP. Raises ValueError for an unknown mode and for a circle of radius 0.
    """
    match iis.TravelMode(path.type):
        case iis.TravelMode.RUN_LINEFOLLOW:
            return LineFollow(path.x, path.y, path.theta, path.v)
        case iis.TravelMode.RUN_SPIN:
            return Spin(path.theta, path.w)
        case iis.TravelMode.RUN_TO_POINT:
            return ToPoint(path.x, path.y, path.theta, path.v)
        case iis.TravelMode.RUN_CIRCLEFOLLOW:
            if path.r == 0.0:
                raise ValueError("a circle of radius 0")
            return CircleFollow(path.x, path.y, path.r, path.v)
        case iis.TravelMode.RUN_VEL:
            return Constant(path.v, path.w)
        case _:
            return STOP


class PathFollower(PathFollowerBase):
    """Follows one waypoint after the other, and rests until the first one arrives.

    It stops, and reports it, while position or waypoint are older than their limits.
    """

    _v: float
    _w: float
    _pose: Pose | None
    _motion: Motion
    _target: Motion

    def on_initialize(self) -> ReturnCode_t:
        """Create the message, which is reused."""
        self._command = iis.TimedVelocity2D()
        config = self.config
        self._position = Newest[iis.TimedPose2D](
            self.position, lambda: config.PositionTimeout
        )
        self._waypoint = Newest[rtc.Path](
            self.target_path, lambda: config.TargetTimeout
        )
        self._rest()
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start at rest, with neither pose nor waypoint."""
        now = self.now()
        self._position.start(now)
        self._waypoint.start(now)
        self._rest()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Stop the base."""
        self._halt()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Stop the base."""
        self._halt()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Take one waypoint and the newest pose, and send the next velocity."""
        config = self.config
        now = self.now()
        if (path := self._waypoint.read(now)) is not None:
            try:
                self._target = motion(path)
            except ValueError as error:
                return self.fail(f"target_path: {error}")
            if self._pose is not None:
                self._target.observe(self._pose)
                self._motion = self._target
        if (sample := self._position.read_newest(now)) is not None:
            self._pose = pose_of(sample.data)
            self._target.observe(self._pose)
            self._motion = self._target
        if not self._sees(now):
            self._v = self._w = 0.0
            self._send(0.0, 0.0)
            return RTC_OK
        v, w = self._motion.reference(self._v, self._w, config)
        self._v = v = limited(self._v, v, config.max_v, config.max_acc_v)
        self._w = w = limited(self._w, w, config.max_w, config.max_acc_w)
        self._send(v, w)
        return RTC_OK

    def _sees(self, now: int) -> bool:
        """Return whether pose and waypoint are within their age limits; at rest none is needed."""
        if self._target is not STOP:
            return all_in_time(self, now, self._position, self._waypoint)
        # A stop is sent once, and executed with the position watched.
        if self._v or self._w:
            return all_in_time(self, now, self._position)
        self.report("")
        return True

    def _send(self, v: float, w: float) -> None:
        command = self._command
        command.data.vx = v
        command.data.va = w
        self.stamp(command)
        self.velocity.write(command)

    def _rest(self) -> None:
        self._v = 0.0
        self._w = 0.0
        self._pose = None
        # Without a pose the waypoint waits and the base rests.
        self._motion = STOP
        self._target = STOP

    def _halt(self) -> None:
        self._rest()
        self._send(0.0, 0.0)
