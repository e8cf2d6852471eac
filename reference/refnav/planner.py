"""Common base of planners: goals and paths of the operator, and one FINISH for each path.

A path whose state the navigation does not report is lost, and is planned and sent again.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from math import hypot
from typing import Generic, Protocol, TypeVar

from refnav.geometry import Pose
from refnav.messages import pose_message, pose_of
from refnav.newest import Newest, complaints
from refrobots import checkpoints, iis, rtc
from rtgen.runtime import RTC_OK, Component, InPort, OutPort, ReturnCode_t


class PlannerParameters(Protocol):
    """The parameters that all planners have [s, m]."""

    PositionTimeout: float
    StatusTimeout: float
    ArrivalRadius: float


P = TypeVar("P", bound=PlannerParameters)


class UnreachableError(Exception):
    """No way leads to the goal; the message says why."""


class Planner(Component, Generic[P]):
    """Plans for each goal, and for each path once its last waypoint has arrived.

    A goal is kept until its FINISH, also while the component is INACTIVE, and in a checkpoint while
    its process is restarted.
    """

    config: P
    current_position: InPort[iis.TimedPose2D]
    goal: InPort[iis.TimedPose2D]
    status_in: InPort[rtc.TimedState]
    min_path: OutPort[iis.TimedPath2DSeq]
    status_out: OutPort[rtc.TimedState]

    @abstractmethod
    def _plan(self, start: Pose, waypoints: Sequence[Pose]) -> iis.TimedPath2DSeq:
        """Return the path from where the base is through one or more waypoints.

        Raises UnreachableError.
        """

    def on_initialize(self) -> ReturnCode_t:
        """Start without a goal."""
        config = self.config
        self._position = Newest[iis.TimedPose2D](
            self.current_position, lambda: config.PositionTimeout
        )
        self._status = Newest[rtc.TimedState](
            self.status_in, lambda: config.StatusTimeout
        )
        self._wanted: list[Pose] = []
        self._kept = self.add_checkpoint(checkpoints.Goals)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without pose; a goal that was not reached is planned for again."""
        self._position.start(self.now())
        self._pose: Pose | None = None
        self._collected: list[Pose] = []
        self._silence = ""
        self._sent = self._under_way = False
        if (kept := self._kept.restored()) is not None:
            self._wanted = [*map(pose_of, kept.wanted)]
            self._collected = [*map(pose_of, kept.collected)]
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Read the pose and the goals, send a path for them, pass on its FINISH."""
        now = self.now()
        # States received until now belong to the path before the one sent in this execution.
        finish = self._follow_state(now)
        sample = self._position.read_newest(now)
        if sample is not None:
            self._pose = pose_of(sample.data)
        while self.goal.is_new() and (goal := self.goal.read()) is not None:
            if not self._collect(goal):
                return self.fail(f"goal: id {list(goal.id)} has no place in a path")
            self._keep()
        if finish is not None and self._sent and self._has_arrived:
            self.status_out.write(finish)
            self._wanted = []
            self._keep()
        if not self._wanted:
            self.report("")
            return RTC_OK
        if self._under_way:
            self._silence = ""
        silent = self._sent and self._status.is_late(now)
        if silent:
            # The navigation has no path, perhaps since it was restarted.
            self._silence = self._status.complaint
        if self._sent and not silent and finish is None:
            self.report(self._silence)
            return RTC_OK
        self._sent = False
        late = complaints(now, self._position)
        self.report(late or self._silence)
        if late or self._pose is None:
            return RTC_OK
        return self._send(self._pose, now)

    @property
    def _has_arrived(self) -> bool:
        """Whether the base is near enough to the goal for a FINISH."""
        here, goal = self._pose, self._wanted[-1]
        most = self.config.ArrivalRadius
        return here is not None and hypot(goal.x - here.x, goal.y - here.y) <= most

    def _send(self, here: Pose, now: int) -> ReturnCode_t:
        try:
            path = self._plan(here, self._wanted)
        except UnreachableError as error:
            self._wanted = []
            self._keep()
            return self.fail(str(error))
        self.stamp(path)
        self.min_path.write(path)
        self._status.start(now)
        self._sent = True
        self._under_way = False
        return RTC_OK

    def _follow_state(self, now: int) -> rtc.TimedState | None:
        """Return the FINISH of the sent path, if it has arrived."""
        finish = None
        while (state := self._status.read(now)) is not None:
            if state.data != iis.State.FINISH:
                self._under_way = self._sent
            elif self._sent and self._under_way:
                # A FINISH before any motion belongs to an earlier path.
                self._under_way = False
                finish = state
        return finish

    def _collect(self, goal: iis.TimedPose2D) -> bool:
        point = pose_of(goal.data)
        match list(goal.id):
            case []:
                self._want([point])
            case [iis.PATH_FIRST, *_]:
                self._collected = [point]
            case [iis.PATH_MIDDLE, *_] if self._collected:
                self._collected.append(point)
            case [iis.PATH_LAST, *_] if self._collected:
                self._want([*self._collected, point])
            case _:
                return False
        return True

    def _keep(self) -> None:
        self._kept.save(checkpoints.Goals(poses(self._wanted), poses(self._collected)))

    def _want(self, points: list[Pose]) -> None:
        self._wanted = points
        self._collected = []
        self._sent = False
        self._silence = ""


def poses(path: Sequence[Pose]) -> list[rtc.Pose2D]:
    """Return the poses of a path as messages."""
    return [pose_message(pose) for pose in path]
