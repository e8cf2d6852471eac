"""Navigation: gives out the waypoints of a path one by one, as the base reaches them."""

from __future__ import annotations

from math import cos, hypot, pi, sin

from refnav.geometry import Pose, wrap
from refrobots import iis
from refrobots.components.navigation import NavigationBase
from rtgen.runtime import RTC_OK, ReturnCode_t

TURN_FIRST = pi / 6
"""A heading farther off than this is turned to before the base drives [rad]."""
TURNED = pi / 20
"""At a waypoint, a heading this near is good enough to drive [rad]."""
TURNED_AT_GOAL = 0.02
"""At the goal, a heading this near is reached [rad]."""
THERE = 0.05
"""A waypoint this near is reached without driving [m]."""
CRAWL = 0.1
"""Speed just before a waypoint [m/s]."""
SPIN_SPEED = 1.0
"""Turning speed asked for; PathFollower limits it [rad/s]."""


class Navigation(NavigationBase):
    """Decides the state of the travel, one step for each new pose."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without path."""
        self._clear()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Forget the path."""
        self._clear()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Take a new path, or one step along the path; send the state in any case."""
        sample = self.position.read_newest()
        new_path = self.min_path.read_newest()
        if new_path is not None:
            self._start(
                [Pose(p.position.x, p.position.y, p.heading) for p in new_path.pose]
            )
        elif sample is not None and self._state is not iis.State.FINISH:
            data = sample.data
            self._step(Pose(data.position.x, data.position.y, data.heading))
        status = iis.TimedState(data=self._state)
        self.stamp(status)
        self.status.write(status)
        return RTC_OK

    def _clear(self) -> None:
        self._path: list[Pose] = []
        self._index = 0
        self._begun = False
        self._state = iis.State.FINISH

    def _start(self, path: list[Pose]) -> None:
        self._clear()
        if path:
            self._path = path
            self._state = iis.State.ANGLE_CHECK
        else:
            self._send(iis.TravelMode.RUN_STOP, Pose(0.0, 0.0, 0.0))

    def _step(self, here: Pose) -> None:
        if not self._begun:
            # The path starts where the base is by now, not where it was planned from.
            self._path[0] = here
            self._begun = True
        target = self._path[self._index]
        last = self._index == len(self._path) - 1
        match self._state:
            case iis.State.ANGLE_CHECK:
                self._check_angle(here, target, last)
            case iis.State.TURNING:
                if _turn(here, target) < TURNED:
                    self._state = iis.State.GOAL_CHECK
            case iis.State.TURNING2:
                if _turn(here, target) < TURNED_AT_GOAL:
                    self._send(iis.TravelMode.RUN_STOP, target)
                    self._state = iis.State.FINISH
            case iis.State.GOAL_CHECK:
                if hypot(target.x - here.x, target.y - here.y) > THERE:
                    self._send(
                        iis.TravelMode.RUN_LINEFOLLOW, target, v=self.config.max_vel
                    )
                    self._state = iis.State.SPEED_DOWN
                else:
                    self._pass(target)
            case iis.State.SPEED_DOWN:
                if _along(here, target) > -self.config.judge_radius:
                    crawl = min(CRAWL, self.config.max_vel)
                    self._send(iis.TravelMode.RUN_LINEFOLLOW, target, v=crawl)
                    self._state = iis.State.STOPPING
            case iis.State.STOPPING:
                if _along(here, target) > 0.0:
                    self._pass(target)
            case iis.State.FINISH:
                pass

    def _check_angle(self, here: Pose, target: Pose, last: bool) -> None:
        if last:
            self._send(iis.TravelMode.RUN_SPIN, target, w=SPIN_SPEED)
            self._state = iis.State.TURNING2
        elif _turn(here, target) > TURN_FIRST:
            self._send(iis.TravelMode.RUN_SPIN, target, w=SPIN_SPEED)
            self._state = iis.State.TURNING
        else:
            self._state = iis.State.GOAL_CHECK

    def _pass(self, target: Pose) -> None:
        self._send(iis.TravelMode.RUN_STOP, target)
        self._index += 1
        self._state = iis.State.ANGLE_CHECK

    def _send(
        self, mode: iis.TravelMode, target: Pose, *, v: float = 0.0, w: float = 0.0
    ) -> None:
        path = iis.Path(type=mode, x=target.x, y=target.y, theta=target.theta, v=v, w=w)
        self.stamp(path)
        self.path.write(path)


def _turn(here: Pose, target: Pose) -> float:
    """How far the heading is off [rad]."""
    return abs(wrap(target.theta - here.theta))


def _along(here: Pose, target: Pose) -> float:
    """Position along the heading of the target, 0 at the target [m]."""
    return (here.x - target.x) * cos(target.theta) + (here.y - target.y) * sin(
        target.theta
    )
