"""PlanningManager: plans the path to a target, and watches the travel."""

from __future__ import annotations

from refnav.geometry import Pose
from refnav.messages import pose_2d, pose_of
from refnav.newest import Newest, all_in_time
from refrobots import iis, rtc
from refrobots.components.planning_manager import PlanningManagerBase
from rtgen.runtime import RTC_OK, ReturnCode_t

ARRIVED = 1
"""Number of the last waypoint of a path from start to target."""


class PlanningManager(PlanningManagerBase):
    """Goes straight to the target; plans again if the robot was stopped on its way.

    Its observables are `goal`, the present target (x, y, theta) [m, rad], empty without one, and
    `travel`, the waypoint reached last and 1 when stopped, empty before the first report.
    """

    _here: Pose | None
    _goal: Pose | None
    _wanted: Pose | None
    _travel: tuple[float, ...]
    _reached = False

    def on_initialize(self) -> ReturnCode_t:
        """Publish target and progress."""
        config = self.config
        self._position = Newest[iis.TimedPose2D](
            self.position, lambda: config.PositionTimeout
        )
        self._goal = None
        self._forget()
        self.observables["goal"] = lambda: self._goal or ()
        self.observables["travel"] = lambda: self._travel
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without position; a target that was not reached is planned for again."""
        self._position.start(self.now())
        self._forget()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Read a new target list, plan for it, and record the state of the travel."""
        now = self.now()
        sample = self._position.read_newest(now)
        if sample is not None:
            self._here = pose_of(sample.data)
        targets = self.targets.read_newest()
        if targets is not None:
            self._take(targets)
        if self._wanted is None:
            self.report("")
        elif all_in_time(self, now, self._position) and self._here is not None:
            self._send([self._here, self._wanted])
            self._wanted = None
        while self.state.is_new() and (state := self.state.read()) is not None:
            if len(state.id) < 2:
                return self.fail(f"state: id {list(state.id)} has no waypoint and flag")
            number, stopped = state.id[:2]
            self._travel = (float(number), float(stopped))
            if stopped and number < ARRIVED:
                self._wanted = self._goal
            elif stopped:
                self._reached = True
        return RTC_OK

    def _forget(self) -> None:
        self._here = None
        self._wanted = None if self._reached else self._goal
        self._travel = ()

    def _take(self, targets: iis.TimedPose2DSeq) -> None:
        if targets.data:
            self._goal = self._wanted = pose_of(targets.data[0])
            self._reached = False
        else:
            self._goal = self._wanted = None
            self._send([])

    def _send(self, poses: list[Pose]) -> None:
        path = iis.TimedPath2DSeq(
            pose=[pose_2d(pose) for pose in poses],
            velocity=[rtc.Velocity2D(self.config.speed, 0.0, 0.0) for _ in poses],
        )
        self.stamp(path)
        self.path.write(path)
