"""Where everything lies: boxes on a grid, and links through the channels between them.

A link to the next column is one curve. Any other runs along a lane in the gap above or below a row,
so that no link hides behind a box. Links from one port share their lane. Lengths are in SVG units.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import fsum
from typing import TypeAlias

from rtgen.backends.wiring.diagram import Box, Diagram, Link, Tab
from rtgen.backends.wiring.placement import Cell

HEADER = 44
ROW = 32
TAB = 10
MARGIN = 20
TITLE = 28

_MIN_BOX = 130
_CHANNEL = 44
_GAP = 36
_STEP = 10
_CLEAR = 16
_RADIUS = 9

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Frame:
    """A rectangle."""

    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Geometry:
    """The finished layout; `paths` are SVG path data, one for each link of the diagram."""

    width: float
    height: float
    frames: Mapping[Box, Frame]
    paths: Sequence[str]

    def anchor(self, tab: Tab) -> Point:
        """The middle of a tab, on the border of its box."""
        frame = self.frames[tab.box]
        x = frame.x if tab.is_left else frame.x + frame.width
        return x, frame.y + HEADER + (tab.row + 0.5) * ROW


def text_width(text: str, size: float) -> float:
    """About how wide a text is in a usual sans-serif font."""
    # What `sum` gives depends on the version of Python.
    return size * fsum(_share(character) for character in text)


def _share(character: str) -> float:
    if character in "iljtf.,:;'|!()[] ":
        return 0.33
    if character.isupper() or character in "mw_@%":
        return 0.72
    return 0.58 if ord(character) < 0x2E80 else 1.0


def box_width(box: Box) -> float:
    """The width at which title and ports of a box do not run into each other."""
    title = max(text_width(box.instance, 14), text_width(subtitle(box), 11)) + 24
    sides: dict[tuple[int, bool], float] = defaultdict(float)
    for tab in box.tabs:
        name, type_ = text_width(tab.view.name, 12), text_width(tab.type_label, 10)
        sides[tab.row, tab.is_left] = max(name, type_)
    ports = max(
        (sides[row, True] + sides[row, False] for row in range(box.rows)), default=0
    )
    return max(_MIN_BOX, title, ports + 2 * TAB + 16)


def subtitle(box: Box) -> str:
    """Type and rate of a box."""
    return box.type if box.rate is None else f"{box.type} · {box.rate:g} Hz"


def route(diagram: Diagram, cells: Mapping[Box, Cell]) -> Geometry:
    """Lay out the boxes in their cells and route every link."""
    return _Router(diagram, cells).run()


@dataclass(frozen=True, slots=True)
class _Detour:
    """A link by way of a lane; the keys say with which others it shares lane and tracks."""

    link: Link
    gap: int

    @property
    def net(self) -> tuple[Tab, int]:
        return self.link.source, self.gap

    @property
    def landing(self) -> tuple[Tab, int]:
        return self.link.target, self.gap


class _Router:
    def __init__(self, diagram: Diagram, cells: Mapping[Box, Cell]) -> None:
        self._diagram = diagram
        self._cells = cells
        self._columns = max((column for column, _ in cells.values()), default=-1) + 1
        self._rows = max((row for _, row in cells.values()), default=-1) + 1
        self._taken = set(cells.values())
        self._detours = {
            link: _Detour(link, self._gap_for(link))
            for link in diagram.links
            if not self._is_direct(link)
        }
        self._lanes = self._assign_lanes()
        self._leaving = self._assign_tracks(d.net for d in self._detours.values())
        self._landing = self._assign_tracks(d.landing for d in self._detours.values())

    def run(self) -> Geometry:
        self._xs, right = self._column_places()
        self._ys, bottom = self._row_places()
        widths = self._column_widths()
        frames = {
            box: Frame(
                self._xs[column], self._ys[row], widths[column], self._height(box)
            )
            for box, (column, row) in self._cells.items()
        }
        geometry = Geometry(right, bottom, frames, ())
        paths = [self._path(link, geometry) for link in self._diagram.links]
        return Geometry(right, bottom, frames, paths)

    def _is_direct(self, link: Link) -> bool:
        """Whether nothing stands between the two boxes, seen from the source's row."""
        column, row = self._cells[link.source.box]
        target = self._cells[link.target.box][0]
        between = range(column + 1, target)
        return target > column and not any((c, row) in self._taken for c in between)

    def _gap_for(self, link: Link) -> int:
        """The gap that is least out of the way: 0 above the first row, and so on down."""
        ends = [
            self._cells[tab.box][1] + self._depth(tab)
            for tab in (link.source, link.target)
        ]
        forward = self._cells[link.source.box][0] < self._cells[link.target.box][0]
        return min(
            range(self._rows + 1),
            key=lambda gap: (
                fsum(abs(gap - end) for end in ends),
                gap if forward else -gap,
            ),
        )

    def _depth(self, tab: Tab) -> float:
        """How far down its row a tab is, from 0 to 1."""
        row = self._cells[tab.box][1]
        tallest = max(
            self._height(box) for box, cell in self._cells.items() if cell[1] == row
        )
        return (HEADER + (tab.row + 0.5) * ROW) / tallest

    def _assign_lanes(self) -> dict[tuple[Tab, int], int]:
        """A lane of its gap for each net: short ones inside, none overlapping."""
        reach: dict[tuple[Tab, int], set[int]] = defaultdict(set)
        for detour in self._detours.values():
            start = self._cells[detour.link.source.box][0] + 1
            reach[detour.net] |= {start, self._cells[detour.link.target.box][0]}
        lanes: dict[tuple[Tab, int], int] = {}
        used: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
        for net in sorted(reach, key=lambda n: max(reach[n]) - min(reach[n])):
            low, high = min(reach[net]), max(reach[net])
            lane = 0
            while any(a <= high and low <= b for a, b in used[net[1], lane]):
                lane += 1
            used[net[1], lane].append((low, high))
            lanes[net] = lane
        return lanes

    def _assign_tracks(
        self, ends: Iterable[tuple[Tab, int]]
    ) -> dict[tuple[Tab, int], int]:
        """A vertical track in front of its box for each end: near ones to the gap inside."""
        columns: dict[int, dict[tuple[Tab, int], float]] = defaultdict(dict)
        for tab, gap in ends:
            column, row = self._cells[tab.box]
            columns[column][tab, gap] = abs(gap - row - self._depth(tab))
        return {
            end: track
            for distances in columns.values()
            for track, end in enumerate(sorted(distances, key=distances.__getitem__))
        }

    def _height(self, box: Box) -> float:
        return HEADER + max(box.rows, 1) * ROW + 8

    def _column_widths(self) -> list[float]:
        return [
            max(
                (box_width(box) for box, (c, _) in self._cells.items() if c == column),
                default=0,
            )
            for column in range(self._columns)
        ]

    def _column_places(self) -> tuple[list[float], float]:
        """The left edge of each column, and the right edge of the picture."""
        leaving = self._track_counts(self._leaving)
        landing = self._track_counts(self._landing)
        widths = self._column_widths()
        places: list[float] = []
        x = float(MARGIN)
        for column in range(self._columns):
            tracks = leaving[column - 1] + landing[column]
            inner = _CHANNEL if column else TAB
            x += inner + (tracks * _STEP + _CLEAR if tracks else 0)
            places.append(x)
            x += widths[column]
        tracks = leaving[self._columns - 1]
        return places, x + TAB + (tracks * _STEP + _CLEAR if tracks else 0) + MARGIN

    def _track_counts(self, tracks: Mapping[tuple[Tab, int], int]) -> dict[int, int]:
        counts: dict[int, int] = defaultdict(int)
        for (tab, _), track in tracks.items():
            column = self._cells[tab.box][0]
            counts[column] = max(counts[column], track + 1)
        return counts

    def _row_places(self) -> tuple[list[float], float]:
        """The top of each row, and the bottom of the picture."""
        lanes: dict[int, int] = defaultdict(int)
        for (_, gap), lane in self._lanes.items():
            lanes[gap] = max(lanes[gap], lane + 1)
        places: list[float] = []
        y = float(MARGIN + TITLE)
        for row in range(self._rows):
            gap = lanes[row] * _STEP
            y += gap + (_GAP if row else _CLEAR if gap else 0)
            places.append(y)
            y += max(
                self._height(box) for box, cell in self._cells.items() if cell[1] == row
            )
        gap = lanes[self._rows] * _STEP
        return places, y + (gap + _CLEAR if gap else 0) + MARGIN

    def _lane_y(self, net: tuple[Tab, int], geometry: Geometry) -> float:
        """The height of a lane; in the topmost gap the first lane is the lowest."""
        gap, lane = net[1], self._lanes[net]
        if gap == 0:
            return self._ys[0] - _CLEAR - lane * _STEP
        above = [
            geometry.frames[box]
            for box, cell in self._cells.items()
            if cell[1] == gap - 1
        ]
        return max(frame.y + frame.height for frame in above) + _CLEAR + lane * _STEP

    def _path(self, link: Link, geometry: Geometry) -> str:
        (x1, y1), (x2, y2) = geometry.anchor(link.source), geometry.anchor(link.target)
        x1, x2 = x1 + TAB, x2 - TAB
        detour = self._detours.get(link)
        if detour is None:
            return self._direct(link, (x1, y1), (x2, y2))
        lane = self._lane_y(detour.net, geometry)
        out = x1 + _CLEAR / 2 + self._leaving[detour.net] * _STEP
        back = x2 - _CLEAR / 2 - self._landing[detour.landing] * _STEP
        return _rounded(
            [(x1, y1), (out, y1), (out, lane), (back, lane), (back, y2), (x2, y2)]
        )

    def _direct(self, link: Link, start: Point, end: Point) -> str:
        """Straight along the source's row, then one curve through the last channel."""
        column = self._cells[link.target.box][0]
        previous = column - 1
        turn = max(start[0], self._xs[previous] + self._column_widths()[previous] + TAB)
        if previous == self._cells[link.source.box][0]:
            turn = start[0]
        middle = (turn + end[0]) / 2
        line = f"M{_n(start[0])},{_n(start[1])}"
        if turn > start[0]:
            line += f" H{_n(turn)}"
        points = f"{_n(middle)},{_n(start[1])} {_n(middle)},{_n(end[1])} {_n(end[0])},{_n(end[1])}"
        return f"{line} C{points}"


def _rounded(points: Sequence[Point]) -> str:
    """An orthogonal line with rounded corners."""
    path = f"M{_n(points[0][0])},{_n(points[0][1])}"
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        radius = min(
            _RADIUS, _distance(before, corner) / 2, _distance(corner, after) / 2
        )
        start, end = _towards(corner, before, radius), _towards(corner, after, radius)
        path += f" L{_n(start[0])},{_n(start[1])}"
        path += f" Q{_n(corner[0])},{_n(corner[1])} {_n(end[0])},{_n(end[1])}"
    return path + f" L{_n(points[-1][0])},{_n(points[-1][1])}"


def _distance(a: Point, b: Point) -> float:
    return abs(a[0] - b[0]) + abs(a[1] - b[1])


def _towards(start: Point, end: Point, length: float) -> Point:
    """The point at that distance from `start` on an axis-parallel line to `end`."""
    whole = _distance(start, end)
    share = length / whole if whole else 0.0
    return (
        start[0] + (end[0] - start[0]) * share,
        start[1] + (end[1] - start[1]) * share,
    )


def _n(value: float) -> str:
    """A length with at most one decimal."""
    return f"{value:.1f}".removesuffix(".0")
