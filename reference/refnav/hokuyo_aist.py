"""HokuyoAist: a range finder on a small board. Also for the small runtime."""

from math import cos, sin

from refnav.rays import nearest_wall, walls_of
from refrobots import rtc
from refrobots.components.hokuyo_aist import HokuyoAistBase
from rtgen.runtime import RTC_OK, ReturnCode_t

NO_HIT = 0.0
"""The range sent if nothing was hit."""


class HokuyoAist(HokuyoAistBase):
    """One scan for each execution, once the pose of the range finder is known."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Read the room and the angles; the message is created once."""
        config = self.config
        if config.end_angle <= config.start_angle:
            return self.fail("end_angle is not above start_angle")
        try:
            self._walls = walls_of(config.walls)
        except ValueError as error:
            return self.fail("walls: " + str(error))
        self._scan = rtc.RangeData()
        settings = self._scan.config
        settings.minAngle = config.start_angle
        settings.maxAngle = config.end_angle
        settings.angularRes = (config.end_angle - config.start_angle) / (
            config.rays - 1
        )
        settings.minRange = config.min_range
        settings.maxRange = config.max_range
        settings.rangeRes = 0.001
        settings.frequency = 10.0
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send a scan."""
        sample = self.pose.read_newest()
        if sample is None:
            return RTC_OK
        scan = self._scan
        scan.tm.sec = sample.tm.sec
        scan.tm.nsec = sample.tm.nsec
        x, y = sample.data.position.x, sample.data.position.y
        ranges = scan.ranges
        ranges.clear()
        for i in range(self.config.rays):
            angle = (
                sample.data.heading + scan.config.minAngle + i * scan.config.angularRes
            )
            ranges.append(self._reach(x, y, cos(angle), sin(angle)))
        self.range.write(scan)
        return RTC_OK

    def _reach(self, x: float, y: float, dx: float, dy: float) -> float:
        nearest = nearest_wall(self._walls, x, y, dx, dy)
        config = self.config
        return nearest if config.min_range <= nearest <= config.max_range else NO_HIT
