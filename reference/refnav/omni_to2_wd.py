"""OmniTo2WD: plans a path for a base with two driven wheels."""

from __future__ import annotations

from collections.abc import Sequence

from refnav.geometry import Pose
from refnav.planner import Planner, poses
from refnav.planning import turn_straight_turn
from refrobots import iis
from refrobots.components.omni_to2_wd import OmniTo2WDBase, OmniTo2WDConfiguration


class OmniTo2WD(Planner[OmniTo2WDConfiguration], OmniTo2WDBase):
    """Plans turn, straight, turn; passes on one FINISH for each path."""

    def _plan(self, start: Pose, waypoints: Sequence[Pose]) -> iis.TimedPath2DSeq:
        return iis.TimedPath2DSeq(pose=poses(turn_straight_turn(start, waypoints)))
