"""UcodeReader: the infra-red markers in view. Also for the small runtime."""

from math import atan2, pi, sqrt

from refnav.rays import nearest_wall, walls_of
from refnav.recent import entries, octets_of
from refrobots import ucode
from refrobots.components.ucode_reader import UcodeReaderBase
from rtgen.runtime import RTC_OK, ReturnCode_t

ON_THE_WALL = 0.01
"""A marker within this distance behind the surface of a wall is on the wall [m]."""
MAX_MARKERS = 8
"""Maximum number of reported markers; the farthest are left out."""


class UcodeReader(UcodeReaderBase):
    """Sends one reading for each execution that sees a marker."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Read the markers."""
        markers = []
        for words in entries(self.config.markers):
            if len(words) != 3:
                return self.fail("markers: " + " ".join(words) + " is not a marker")
            markers.append((octets_of(words[0]), float(words[1]), float(words[2])))
        self._markers = markers
        try:
            self._walls = walls_of(self.config.walls)
        except ValueError as error:
            return self.fail("walls: " + str(error))
        self._reading = ucode.TimedSightings()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send a reading."""
        sample = self.pose.read_newest()
        if sample is None:
            return RTC_OK
        here = sample.data
        seen = []
        for code, x, y in self._markers:
            dx, dy = x - here.position.x, y - here.position.y
            distance = sqrt(dx * dx + dy * dy)
            bearing = _wrapped(atan2(dy, dx) - here.heading)
            if distance > self.config.reach or abs(bearing) > self.config.angle:
                continue
            # A marker on a wall is visible in front of it.
            if distance == 0.0 or distance <= ON_THE_WALL + nearest_wall(
                self._walls,
                here.position.x,
                here.position.y,
                dx / distance,
                dy / distance,
            ):
                seen.append((distance, bearing, code))
        if not seen:
            return RTC_OK
        seen.sort()
        reading = self._reading
        reading.tm.sec = sample.tm.sec
        reading.tm.nsec = sample.tm.nsec
        reading.data.clear()
        for distance, bearing, code in seen[:MAX_MARKERS]:
            reading.data.append(ucode.Sighting(code, distance, bearing))
        self.sightings.write(reading)
        return RTC_OK


def _wrapped(angle: float) -> float:
    while angle > pi:
        angle -= 2.0 * pi
    while angle < -pi:
        angle += 2.0 * pi
    return angle
