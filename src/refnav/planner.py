"""What planners have in common: goals and paths of the operator, and one FINISH for each path."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from refnav.geometry import Pose
from refnav.messages import pose_message, pose_of
from refrobots import iis, rtc
from rtgen.runtime import RTC_OK, Component, InPort, OutPort, ReturnCode_t


class Planner(Component):
    """Plans for each goal, and for each path once its last waypoint has come."""

    current_position: InPort[iis.TimedPose2D]
    goal: InPort[iis.TimedPose2D]
    status_in: InPort[iis.TimedState]
    min_path: OutPort[iis.TimedPath2DSeq]
    status_out: OutPort[iis.TimedState]

    @abstractmethod
    def _plan(self, start: Pose, waypoints: Sequence[Pose]) -> iis.TimedPath2DSeq:
        """The path from where the base is through one or more waypoints."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without pose, goal and path."""
        self._pose: Pose | None = None
        self._collected: list[Pose] = []
        self._wanted: list[Pose] = []
        self._waiting_for_finish = False
        self._under_way = False
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Pass on FINISH, take the pose and the goals, and send the path for them."""
        # What has come until now belongs to the path before the one that this execution sends.
        self._follow_state()
        sample = self.current_position.read_newest()
        if sample is not None:
            self._pose = pose_of(sample.data)
        while self.goal.is_new() and (goal := self.goal.read()) is not None:
            if not self._collect(goal):
                return self.fail(f"goal: id {list(goal.id)} has no place in a path")
        if self._wanted and self._pose is not None:
            path = self._plan(self._pose, self._wanted)
            self.stamp(path)
            self.min_path.write(path)
            self._waiting_for_finish = True
            self._under_way = False
            self._wanted = []
        return RTC_OK

    def _follow_state(self) -> None:
        while self.status_in.is_new() and (state := self.status_in.read()) is not None:
            if state.data != iis.State.FINISH:
                self._under_way = self._waiting_for_finish
            elif self._under_way:
                # A FINISH before any motion is left over from an earlier path.
                self._waiting_for_finish = self._under_way = False
                self.status_out.write(state)

    def _collect(self, goal: iis.TimedPose2D) -> bool:
        point = pose_of(goal.data)
        match list(goal.id):
            case []:
                self._wanted = [point]
                self._collected = []
            case [iis.PATH_FIRST, *_]:
                self._collected = [point]
            case [iis.PATH_MIDDLE, *_] if self._collected:
                self._collected.append(point)
            case [iis.PATH_LAST, *_] if self._collected:
                self._wanted = [*self._collected, point]
                self._collected = []
            case _:
                return False
        return True


def poses(path: Sequence[Pose]) -> list[rtc.Pose2D]:
    """Poses as a path has them on its way."""
    return [pose_message(pose) for pose in path]
