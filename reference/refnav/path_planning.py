"""PathPlanning: plans along the links of a map."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot

from refnav.geometry import Pose
from refnav.map_text import MapError, text_of
from refnav.planner import Planner, UnreachableError, poses
from refnav.planning import SAME_PLACE
from refnav.route_map import RouteMap, parse
from refrobots import iis, rtc
from refrobots.components.path_planning import (
    PathPlanningBase,
    PathPlanningConfiguration,
)
from rtgen.runtime import RTC_OK, ReturnCode_t

SPEED = 1.0
"""Commanded forward speed of every path element; the navigation has its own limit [m/s]."""
OFF_THE_MAP = 0.3
"""A base farther than this from its first node drives to that node first [m]."""


class PathPlanning(Planner[PathPlanningConfiguration], PathPlanningBase):
    """Plans the cheapest path from the node nearest to the base to that nearest to the goal."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Load the map."""
        name = self.config.map_file
        try:
            self._map: RouteMap | None = parse(text_of(self.folder, name), name)
        except MapError as error:
            return self.fail(f"map_file: {error}")
        return super().on_activated(ec_id)

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Delete the map."""
        self._map = None
        return RTC_OK

    def _plan(self, start: Pose, waypoints: Sequence[Pose]) -> iis.TimedPath2DSeq:
        route = self._map
        assert route is not None, "loaded on activation"
        here = route.nearest(start.x, start.y)
        numbers = [here]
        for point in waypoints:
            there = route.nearest(point.x, point.y)
            way = route.cheapest(here, there)
            if not way:
                raise UnreachableError(
                    f"{self.config.map_file}: no way from node {here} to node {there}"
                )
            numbers += way[1:]
            here = there
        path = [*along(route, numbers, start), waypoints[-1]]
        ahead = [rtc.Velocity2D(SPEED, 0.0, 0.0) for _ in path]
        return iis.TimedPath2DSeq(pose=poses(path), velocity=ahead)


def along(route: RouteMap, numbers: Sequence[int], start: Pose) -> list[Pose]:
    """Return the nodes with the direction of arrival as heading.

    The heading of the first is 0, unless `start` is away from it: then the path begins at `start`.
    """
    first = route.nodes[numbers[0]]
    path: list[Pose] = []
    if hypot(first.x - start.x, first.y - start.y) > OFF_THE_MAP:
        path.append(start)
    for number in numbers:
        x, y, _ = route.nodes[number]
        heading = 0.0
        if path:
            before = path[-1]
            heading = before.theta
            if hypot(x - before.x, y - before.y) > SAME_PLACE:
                heading = atan2(y - before.y, x - before.x)
        path.append(Pose(x, y, heading))
    return path
