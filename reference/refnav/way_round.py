"""The way round obstacles that no single arc passes: out of a dead end, past the other side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, pi, sin

from refnav.free_way import Point
from refnav.geometry import Pose, advance, wrap
from refnav.local_map import BEYOND, CELL, LocalMap
from rtgen.runtime import SECOND

COURSE_MEMORY = 0.5
"""Distance over which a base that is free takes its heading as the course [m]."""
LOOKAHEAD = 0.4
"""Distance of the point for which the base heads [m]."""
MAX_BEARING = 0.5
"""The base turns on the spot towards a point in a direction farther from its own [rad]."""
RETRY = SECOND
"""Time between two searches without a result [ns]."""
SAME_PLACE = 0.5
"""A dead end nearer than this to one that was left is the same one [m]."""
GONE = 1.0
"""Distance between two turns on the spot that are two attempts to leave a dead end [m]."""
MAX_ATTEMPTS = 6
"""Number of them: this is three times round."""
FORGET = 120 * SECOND
"""Time after which a dead end that was left is left again [ns]."""


@dataclass(slots=True)
class _Attempts:
    """The turns on the spot since the base came to a dead end."""

    gate: Pose
    """The place of the first one, with the course as its heading."""
    place: Pose
    """That of the last one."""
    time: int
    number: int = 1

    def go_on(self, base: Pose, course: float, now: int) -> bool:
        """Return whether a base is still in the dead end, which leads past its gate."""
        gate = self.gate
        x, y = base.x - gate.x, base.y - gate.y
        ahead = x * cos(gate.theta) + y * sin(gate.theta)
        same = abs(wrap(gate.theta - course)) < pi / 2
        return same and ahead < BEYOND and now - self.time <= FORGET


class WayRound:
    """Reckons where the base is by its velocities, and finds a way on the map of its scans.

    `free_way` returns the free length [m] of an arc of a curvature [1/m].
    """

    def __init__(self, now: int, free_way: Callable[[float], float]) -> None:
        self._free_way = free_way
        self._pose = Pose(0.0, 0.0, 0.0)
        self._course = 0.0
        self._now = now
        self._map = LocalMap()
        self._searched = now - RETRY
        self._left: list[tuple[int, Pose]] = []
        self._attempts: _Attempts | None = None
        self.leave()

    def leave(self) -> None:
        """End the way: the base is free, or has passed."""
        self._gate: Pose | None = None
        self._way: list[Point] = []
        self._turn = 0.0

    @property
    def is_taken(self) -> bool:
        """Whether the base is on a way round."""
        return self._gate is not None

    def move(self, now: int, v: float, w: float, *, free: bool) -> None:
        """Move the base until `now` [ns]; the course of a `free` one becomes its heading."""
        dt = (now - self._now) / SECOND
        self._now = now
        self._pose = Pose(*advance(*self._pose, v * dt, w * dt))
        if free:
            # A base that turns on the spot has a new course at once.
            share = min(1.0, v * dt / COURSE_MEMORY) if v > 0.0 else 1.0
            self._course += share * wrap(self._pose.theta - self._course)

    def look(self, points: list[Point], radius: float) -> None:
        """Enter a scan into the map; a way that is taken is searched anew."""
        self._map.add(points, self._pose, self._now)
        if self._gate is not None:
            self._search(self._gate, radius)

    def take(self, radius: float) -> bool:
        """Return whether there is a way past this place, along the course; the base is on it then.

        It keeps `radius` [m] from obstacles. A dead end is left only once.
        """
        if self._now - self._searched < RETRY:
            return False
        here = self._pose
        self._left = [one for one in self._left if self._now - one[0] <= FORGET]
        if any(
            hypot(gate.x - here.x, gate.y - here.y) < SAME_PLACE
            for _, gate in self._left
        ):
            return False
        gate = Pose(here.x, here.y, self._course)
        self._search(gate, radius)
        if self.is_taken:
            self._left.append((self._now, gate))
        return self.is_taken

    def turn(self) -> bool:
        """Return whether a turn on the spot may help here: it begins then.

        It does not if `MAX_ATTEMPTS` have not led past the place of the first one.
        """
        here, attempts = self._pose, self._attempts
        if attempts is None or not attempts.go_on(here, self._course, self._now):
            gate = Pose(here.x, here.y, self._course)
            self._attempts = _Attempts(gate, here, self._now)
            return True
        attempts.time = self._now
        if attempts.number > MAX_ATTEMPTS:
            return False
        if hypot(here.x - attempts.place.x, here.y - attempts.place.y) > GONE:
            attempts.place = here
            attempts.number += 1
        return attempts.number <= MAX_ATTEMPTS

    def curvature(self) -> tuple[float, float]:
        """Return the curvature [1/m] to drive, and a turn on the spot, which is 0 to drive.

        The turn is 1 to the left and -1 to the right.
        """
        here = self._pose
        x, y = next(
            (p for p in self._way if hypot(p[0] - here.x, p[1] - here.y) >= LOOKAHEAD),
            self._way[-1],
        )
        bearing = wrap(atan2(y - here.y, x - here.x) - here.theta)
        curvature = 2.0 * sin(bearing) / max(hypot(x - here.x, y - here.y), CELL)
        if abs(bearing) > MAX_BEARING:
            # The side is kept: a base before a way straight behind it would turn to and fro.
            self._turn = self._turn or copysign(1.0, bearing)
        else:
            self._turn = 0.0
            if self._free_way(curvature) == 0.0:
                # The gap is too narrow, seen from here.
                self._map.close((x, y), self._now)
        return curvature, self._turn

    def _search(self, gate: Pose, radius: float) -> None:
        self._searched = self._now
        # Cells are coarse: a gap that is just wide enough is found with the lesser radius.
        self._way = self._map.way(
            self._pose, gate, radius + 0.5 * CELL, self._now
        ) or self._map.way(self._pose, gate, radius - CELL, self._now)
        if len(self._way) > 1:
            self._gate = gate
        else:
            self.leave()
