"""A map of the surroundings that a base draws as it drives, and the shortest way on it."""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heappop, heappush
from math import atan2, cos, floor, hypot, inf, sin, sqrt, tau

from refnav.free_way import Point
from refnav.geometry import Pose
from rtgen.runtime import SECOND

CELL = 0.1
"""Width of a cell [m]."""
RANGE = 6.0
"""Cells farther than this from the base are neither remembered nor driven through [m]."""
MEMORY = 60 * SECOND
"""Cells in which nothing was seen for this time are forgotten [ns]."""
BEAMS = 180
"""Directions in which the nearest point of a scan counts."""
SEEN_THROUGH = 0.3
"""A cell nearer than what a scan has hit by more than this is free [m]."""
BEYOND = 2.0
"""A way leads this far beyond the place where it begins, along the course [m]."""

Cell = tuple[int, int]

_STEPS = [
    (i, j, hypot(i, j)) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)
]


class LocalMap:
    """The cells in which obstacles were seen, in a frame that is at rest."""

    def __init__(self) -> None:
        self._seen: dict[Cell, int] = {}
        self._closed: dict[Cell, int] = {}
        self._scan: list[Point] = []
        self._base = Pose(0.0, 0.0, 0.0)

    def add(self, points: list[Point], base: Pose, now: int) -> None:
        """Enter the points of a scan, in the frame of the base [m], at the time `now` [ns]."""
        self._scan, self._base = points, base
        along, across = cos(base.theta), sin(base.theta)
        for x, y in points:
            place = (
                base.x + x * along - y * across,
                base.y + x * across + y * along,
            )
            self._seen[_cell(place)] = now

    def close(self, place: Point, now: int) -> None:
        """Treat a place as an obstacle that no scan shows, for as long as one is remembered."""
        self._closed[_cell(place)] = now

    def way(self, base: Pose, gate: Pose, radius: float, now: int) -> list[Point]:
        """Return the shortest way that leads `BEYOND` a place, in the direction of its heading.

        The centre of the body keeps `radius` [m] from all that was seen; where the base is nearer
        to it already, it only gets away. Empty if there is no way within `RANGE`.
        """
        self._forget(base, now)
        self._remove_seen_through()
        distances = self._distances(radius)
        start = _cell((base.x, base.y))
        ahead = (cos(gate.theta), sin(gate.theta))
        costs = {start: 0.0}
        before: dict[Cell, Cell] = {}
        queue = [(0.0, start)]
        while queue:
            cost, cell = heappop(queue)
            if cost > costs[cell]:
                continue
            x, y = _centre(cell)
            if (x - gate.x) * ahead[0] + (y - gate.y) * ahead[1] >= BEYOND:
                return [*_back(before, cell)]
            least = distances.get(cell, radius)
            for i, j, length in _STEPS:
                other = (cell[0] + i, cell[1] + j)
                if distances.get(other, radius) < least:
                    continue
                x, y = _centre(other)
                if hypot(x - base.x, y - base.y) > RANGE:
                    continue
                through = cost + length
                if through < costs.get(other, through + 1.0):
                    costs[other] = through
                    before[other] = cell
                    heappush(queue, (through, other))
        return []

    def _forget(self, base: Pose, now: int) -> None:
        most = (RANGE / CELL) ** 2
        here = _cell((base.x, base.y))
        self._seen, self._closed = (
            {
                cell: seen
                for cell, seen in cells.items()
                if now - seen <= MEMORY
                and (cell[0] - here[0]) ** 2 + (cell[1] - here[1]) ** 2 <= most
            }
            for cells in (self._seen, self._closed)
        )

    def _remove_seen_through(self) -> None:
        """Forget cells in front of what the latest scan has hit: obstacles move, and so do bases
        that somebody else drives.
        """
        hits = [inf] * BEAMS
        for x, y in self._scan:
            beam = _beam(x, y)
            hits[beam] = min(hits[beam], hypot(x, y))
        base = self._base
        along, across = cos(base.theta), sin(base.theta)
        for cell in [*self._seen]:
            east, north = _centre(cell)
            east, north = east - base.x, north - base.y
            x, y = east * along + north * across, north * along - east * across
            if hypot(x, y) + SEEN_THROUGH < hits[_beam(x, y)] < inf:
                del self._seen[cell]

    def _distances(self, radius: float) -> dict[Cell, float]:
        """Return the distance from what was seen of the cells nearer to it than `radius` [m]."""
        reach = radius / CELL
        most = floor(reach)
        around = [
            (i, j, CELL * sqrt(i * i + j * j))
            for i in range(-most, most + 1)
            for j in range(-most, most + 1)
            if i * i + j * j < reach * reach
        ]
        distances: dict[Cell, float] = {}
        for x, y in {**self._seen, **self._closed}:
            for i, j, distance in around:
                cell = (x + i, y + j)
                if distance < distances.get(cell, radius):
                    distances[cell] = distance
        return distances


def _beam(x: float, y: float) -> int:
    return floor(atan2(y, x) / tau * BEAMS) % BEAMS


def _cell(place: Point) -> Cell:
    return floor(place[0] / CELL), floor(place[1] / CELL)


def _centre(cell: Cell) -> Point:
    return (cell[0] + 0.5) * CELL, (cell[1] + 0.5) * CELL


def _back(before: dict[Cell, Cell], cell: Cell) -> Iterator[Point]:
    cells = [cell]
    while cell in before:
        cell = before[cell]
        cells.append(cell)
    return map(_centre, reversed(cells))
