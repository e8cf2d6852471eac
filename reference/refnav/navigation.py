"""Navigation: sends the waypoints of a path one by one, as the base reaches them."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin

from refnav.geometry import Pose, wrap
from refnav.messages import pose_of
from refnav.newest import Newest, complaints
from refnav.pose_history import jumped
from refrobots import iis, rtc
from refrobots.components.navigation import NavigationBase
from rtgen.runtime import RTC_ERROR, RTC_OK, SECOND, ReturnCode_t

TURN_FIRST = pi / 6
"""Before driving, the base turns to a heading that is farther off than this [rad]."""
TURNED = pi / 20
"""At a waypoint, the heading is good enough to drive within this angle [rad]."""
TURNED_AT_GOAL = 0.02
"""At the goal, the heading is reached within this angle [rad]."""
REACHED = 0.05
"""A waypoint within this distance is reached without driving [m]."""
CRAWL_SPEED = 0.1
"""Speed just before a waypoint [m/s]."""
SPIN_SPEED = 1.0
"""Commanded turning speed; PathFollower limits it [rad/s]."""
REPEAT_INTERVAL = SECOND // 10
"""Interval of repeated waypoints, for a follower that was restarted [ns]."""
PROGRESS = 0.05
"""Smallest change of the distance from a waypoint that counts as progress [m, rad]."""
MAX_APPROACHES = 10
"""Maximum number of further approaches to a missed goal."""
STOP = rtc.Path(type=iis.TravelMode.RUN_STOP)


class Navigation(NavigationBase):
    """Decides the state of the travel, one step for each new pose.

    Without a path it sends no state: FINISH is only sent for a path that was run, and a planner
    that receives no state knows that its path was lost.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Watch the age of the position."""
        config = self.config
        self._position = Newest[iis.TimedPose2D](
            self.position, lambda: config.PositionTimeout
        )
        self._clear()
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without path."""
        self._position.start(self.now())
        self._clear()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Stop the base and forget the path."""
        self._halt()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Stop the base and forget the path."""
        self._halt()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Take a new path, or do one step along the path; send the state of the travel."""
        now = self.now()
        sample = self._position.read_newest(now)
        new_path = self.min_path.read_newest()
        if new_path is not None:
            self._start([pose_of(pose) for pose in new_path.pose])
        elif self._state is not iis.State.FINISH:
            if sample is not None and not self._step(pose_of(sample.data)):
                return RTC_ERROR
            late = complaints(now, self._position)
            self.report(late or self._stuck(now))
            if self._waypoint is not None and now - self._sent >= REPEAT_INTERVAL:
                # Without a position the arrival at the waypoint would go unnoticed.
                self._write(STOP if late else self._waypoint)
        if self._path:
            status = rtc.TimedState(data=self._state)
            self.stamp(status)
            self.status.write(status)
        return RTC_OK

    def _clear(self) -> None:
        self._path: list[Pose] = []
        self._index = 0
        self._here: Pose | None = None
        self._approaches = 0
        self._still_since: int | None = None
        self._stage: tuple[iis.State, int] | None = None
        self._least = 0.0
        self._nearer = 0
        self._waypoint: rtc.Path | None = None
        self._state = iis.State.FINISH

    def _start(self, path: list[Pose]) -> None:
        self._clear()
        if path:
            # The path starts at the base's pose, which the first step determines.
            self._path = path if len(path) > 1 else [path[0], *path]
            self._state = iis.State.ANGLE_CHECK
        else:
            self._send(iis.TravelMode.RUN_STOP, Pose(0.0, 0.0, 0.0))

    def _halt(self) -> None:
        if self._path:
            self._send(iis.TravelMode.RUN_STOP, self._path[-1])
        self._clear()

    def _stuck(self, now: int) -> str:
        """Return the condition to report while the base does not approach its waypoint."""
        here, target = self._here, self._path[self._index]
        if here is None:
            return ""
        turning = self._state in (iis.State.TURNING, iis.State.TURNING2)
        left = (
            _turn(here, target)
            if turning
            else hypot(target.x - here.x, target.y - here.y)
        )
        if (self._state, self._index) != self._stage or left < self._least - PROGRESS:
            self._stage = (self._state, self._index)
            self._least = left
            self._nearer = now
        if 0.0 < self.config.ProgressTimeout * SECOND < now - self._nearer:
            seconds = f"{self.config.ProgressTimeout:g} s"
            return f"no nearer to ({target.x:g}, {target.y:g}) for {seconds}"
        return ""

    def _step(self, here: Pose) -> bool:
        """Process a new pose; False if the travel cannot go on."""
        before, self._here = self._here, here
        if before is None:
            self._path[0] = here
        elif jump := jumped(before, here, self.config.MaxJump):
            self.fail(f"position: {jump}")
            return False
        target = self._path[self._index]
        last = self._index == len(self._path) - 1
        match self._state:
            case iis.State.ANGLE_CHECK:
                return self._check_angle(here, target, last)
            case iis.State.TURNING:
                if _turn(here, target) < TURNED:
                    self._state = iis.State.GOAL_CHECK
            case iis.State.TURNING2:
                return self._end(here, target)
            case iis.State.GOAL_CHECK:
                if self._has_missed(here, target):
                    self._send(
                        iis.TravelMode.RUN_LINEFOLLOW, target, v=self.config.max_vel
                    )
                    self._state = iis.State.SPEED_DOWN
                else:
                    self._pass(target)
            case iis.State.SPEED_DOWN:
                if _along(here, target) > -self.config.judge_radius:
                    crawl = min(CRAWL_SPEED, self.config.max_vel)
                    self._send(iis.TravelMode.RUN_LINEFOLLOW, target, v=crawl)
                    self._state = iis.State.STOPPING
            case iis.State.STOPPING:
                if _along(here, target) > 0.0:
                    self._pass(target)
            case iis.State.FINISH:
                pass
        return True

    def _end(self, here: Pose, goal: Pose) -> bool:
        """Turn to the heading of the goal, and finish once the pose has settled there."""
        if _turn(here, goal) >= TURNED_AT_GOAL:
            if self._still_since is not None:
                self._spin(goal)
            return True
        now = self.now()
        if self._still_since is None:
            self._still_since = now
            self._send(iis.TravelMode.RUN_STOP, goal)
        if now - self._still_since < self.config.SettleTime * SECOND:
            return True
        if self._has_missed(here, goal):
            return self._approach(here, goal)
        self._state = iis.State.FINISH
        return True

    def _spin(self, target: Pose) -> None:
        self._still_since = None
        self._send(iis.TravelMode.RUN_SPIN, target, w=SPIN_SPEED)

    def _has_missed(self, here: Pose, target: Pose) -> bool:
        """Return whether the base must drive to a target; the tolerance of the goal is smaller."""
        goal = self._path[-1]
        is_goal = target[:2] == goal[:2]
        near = min(REACHED, self.config.GoalTolerance) if is_goal else REACHED
        return hypot(target.x - here.x, target.y - here.y) > near

    def _approach(self, here: Pose, goal: Pose) -> bool:
        """Insert a turn and a straight to the goal before its last turn; False after too many."""
        if self._approaches == MAX_APPROACHES:
            off = hypot(goal.x - here.x, goal.y - here.y)
            self.fail(f"the goal is {off:.3f} m away after {MAX_APPROACHES} approaches")
            return False
        self._approaches += 1
        heading = atan2(goal.y - here.y, goal.x - here.x)
        self._path[-1:-1] = [
            Pose(here.x, here.y, heading),
            Pose(goal.x, goal.y, heading),
        ]
        self._state = iis.State.ANGLE_CHECK
        return True

    def _check_angle(self, here: Pose, target: Pose, last: bool) -> bool:
        if last and self._has_missed(here, target):
            return self._approach(here, target)
        if last:
            self._spin(target)
            self._state = iis.State.TURNING2
        elif _turn(here, target) > TURN_FIRST:
            self._spin(target)
            self._state = iis.State.TURNING
        else:
            self._state = iis.State.GOAL_CHECK
        return True

    def _pass(self, target: Pose) -> None:
        self._send(iis.TravelMode.RUN_STOP, target)
        self._index += 1
        self._state = iis.State.ANGLE_CHECK

    def _send(
        self, mode: iis.TravelMode, target: Pose, *, v: float = 0.0, w: float = 0.0
    ) -> None:
        self._waypoint = rtc.Path(
            type=mode, x=target.x, y=target.y, theta=target.theta, v=v, w=w
        )
        self._write(self._waypoint)

    def _write(self, path: rtc.Path) -> None:
        self._sent = self.now()
        self.stamp(path)
        self.path.write(path)


def _turn(here: Pose, target: Pose) -> float:
    """Return the deviation from the heading of a target [rad]."""
    return abs(wrap(target.theta - here.theta))


def _along(here: Pose, target: Pose) -> float:
    """Return the position along the heading of the target, 0 at the target [m]."""
    return (here.x - target.x) * cos(target.theta) + (here.y - target.y) * sin(
        target.theta
    )
