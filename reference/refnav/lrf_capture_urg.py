"""LRFCapture_URG: scans a room with a simulated range finder."""

from __future__ import annotations

from math import cos, inf, sin
from random import Random

from refnav.geometry import Pose
from refnav.map_text import MapError, text_of
from refnav.messages import pose_of
from refnav.room import parse
from refrobots import rtc
from refrobots.components.lrf_capture_urg import LRFCapture_URGBase
from rtgen.runtime import RTC_OK, ReturnCode_t

NO_HIT = 0.0
"""The range sent if nothing was hit."""


class LRFCapture_URG(LRFCapture_URGBase):
    """One scan for each execution, once the pose of the base is known."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Load the room."""
        config = self.config
        try:
            self._room = parse(text_of(self.folder, config.room), config.room)
        except MapError as error:
            return self.fail(f"room: {error}")
        self._chance = Random(config.seed)
        rays = round(2.0 * config.angle / config.resolution)
        self._angles = [config.resolution * (i - 0.5 * rays) for i in range(rays + 1)]
        self._scan = rtc.RangeData()
        settings = self._scan.config
        settings.minAngle, settings.maxAngle = self._angles[0], self._angles[-1]
        settings.angularRes = config.resolution
        settings.minRange, settings.maxRange = config.min_range, config.max_range
        settings.rangeRes = 0.001
        context = self.get_context(ec_id)
        assert context is not None, "the component takes part in it"
        settings.frequency = context.get_rate()
        self._scan.geometry.geometry.pose.position.x = config.offset_x
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send a scan."""
        sample = self.pose.read_newest()
        if sample is None:
            return RTC_OK
        config = self.config
        base = pose_of(sample.data)
        eye = Pose(
            base.x + config.offset_x * cos(base.theta),
            base.y + config.offset_x * sin(base.theta),
            base.theta,
        )
        scan = self._scan
        scan.tm = sample.tm
        scan.ranges = [
            self._measured(reach)
            for reach in self._room.ranges(eye, self._angles, config.max_range)
        ]
        self.range.write(scan)
        return RTC_OK

    def _measured(self, reach: float) -> float:
        config = self.config
        if reach == inf:
            return NO_HIT
        reach = round(self._chance.gauss(reach, config.noise), 3)
        return reach if config.min_range <= reach <= config.max_range else NO_HIT
