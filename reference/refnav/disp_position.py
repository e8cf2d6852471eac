"""DispPosition: the pose of the base and its trail on the map of the planner."""

from __future__ import annotations

from collections import deque

from refnav.geometry import Pose
from refnav.map_text import MapError, text_of
from refnav.messages import pose_of
from refnav.picture import MAX_TRAIL, Picture, PictureError
from refnav.route_map import RouteMap, parse
from refrobots.components.disp_position import DispPositionBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class DispPosition(DispPositionBase):
    """Records the trail while it is active, and draws it on deactivation.

    Its observable `trail` is the newest pose (x, y, theta) [m, rad].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish the pose of the base."""
        self._trail: deque[Pose] = deque(maxlen=MAX_TRAIL)
        self.observables["trail"] = lambda: self._trail[-1] if self._trail else ()
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Load the map and start a new trail."""
        self._trail.clear()
        self._map: RouteMap | None = None
        name = self.config.map_file
        try:
            if name:
                self._map = parse(text_of(self.folder, name), name)
            if self.config.picture:
                self._picture = Picture(self.folder / self.config.picture)
        except MapError as error:
            return self.fail(f"map_file: {error}")
        except PictureError as error:
            return self.fail(f"picture: {error}")
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Add new poses to the trail."""
        sample = self.position.read_newest()
        if sample is not None:
            self._trail.append(pose_of(sample.data))
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Draw the trail."""
        if not self.config.picture:
            return RTC_OK
        picture = self._picture
        if self._map is not None:
            nodes = self._map.nodes
            for number, links in self._map.links.items():
                for other in links:
                    if number < other:
                        picture.line([nodes[number][:2], nodes[other][:2]], "0.7")
            for number, node in nodes.items():
                picture.label(node.x, node.y, str(number))
        picture.line([pose[:2] for pose in self._trail], "tab:blue", "trail")
        if self._trail:
            picture.arrow(self._trail[-1], "tab:red", "pose")
        try:
            picture.save(self.instance_name)
        except PictureError as error:
            return self.fail(str(error))
        return RTC_OK
