"""Lays out boxes on a grid, and routes links through the channels between them.

A link to the next column is one curve. Any other runs along a lane in the gap above or below a
row, so that no link passes behind a box. Links from one port share their lane. A medium (CAN bus,
TCP or serial line) is a trunk below all boxes with risers in the channels. Lengths are in SVG
units.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import fsum
from typing import TypeAlias

from rtgen.compiler.backends.wiring.diagram import Box, Diagram, Link, Medium, Tab
from rtgen.compiler.backends.wiring.placement import Cell, folded, place

HEADER = 46
ROW = 34
MEDIUM_ROW = 24
TAB = 10
MARGIN = 20
TITLE = 28

TITLE_SIZE = 16
NAME_SIZE = 14
TEXT_SIZE = 12
"""Font sizes: of the title, of instance names, of all other text."""

README_WIDTH = 830
"""Width in px of the column in which a code host shows a picture of a page."""

_MIN_TEXT = 9
"""Minimum size of text in px that a picture must have in that column."""

MAX_WIDTH = README_WIDTH * TEXT_SIZE // _MIN_TEXT

_MIN_BOX = 130
_TRUNK = 34
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
    """The finished layout.

    `paths` are SVG path data, one for each link of the diagram. `trunks` have the line of each
    medium as (x1, x2, y), `risers` its path from the trunk to the boxes.
    """

    width: float
    height: float
    frames: Mapping[Box, Frame]
    paths: Sequence[str]
    trunks: Mapping[Medium, tuple[float, float, float]]
    risers: Mapping[Medium, str]

    def anchor(self, tab: Tab) -> Point:
        """Return the middle of a tab, on the border of its box."""
        frame = self.frames[tab.box]
        x = frame.x if tab.is_left else frame.x + frame.width
        return x, frame.y + HEADER + (tab.row + 0.5) * ROW

    def media_row(self, box: Box, index: int) -> float:
        """Return the height of the row for a box's medium."""
        return self.frames[box].y + HEADER + box.rows * ROW + (index + 0.5) * MEDIUM_ROW


def text_width(text: str, size: float) -> float:
    """Approximate the width of a text in a usual sans-serif font."""
    # The result of `sum` depends on the version of Python.
    return size * fsum(_share(character) for character in text)


def _share(character: str) -> float:
    if character in "iljtf.,:;'|!()[] ":
        return 0.33
    if character.isupper() or character in "mw_@%":
        return 0.72
    return 0.58 if ord(character) < 0x2E80 else 1.0


def box_width(box: Box) -> float:
    """Return the width at which title and ports of a box do not overlap."""
    header = (
        text_width(box.instance, NAME_SIZE),
        text_width(subtitle(box), TEXT_SIZE),
        *(text_width(node, TEXT_SIZE) for _, node in box.media),
    )
    title = max(header) + 24
    sides: dict[tuple[int, bool], float] = defaultdict(float)
    for tab in box.tabs:
        sides[tab.row, tab.is_left] = max(
            text_width(text, TEXT_SIZE) for text in (tab.view.name, tab.type_label)
        )
    ports = max(
        (sides[row, True] + sides[row, False] for row in range(box.rows)), default=0
    )
    return max(_MIN_BOX, title, ports + 2 * TAB + 16)


def notes(diagram: Diagram) -> dict[Tab, str]:
    """Return the times at which a timeline connects each port."""
    times: dict[Tab, set[float]] = defaultdict(set)
    for link in diagram.links:
        if link.times:
            times[link.target] |= set(link.times)
    return {
        tab: ", ".join(f"{time:g}" for time in sorted(times_of_tab)) + " s"
        for tab, times_of_tab in times.items()
    }


def subtitle(box: Box) -> str:
    """Return type and rate of a box."""
    return box.type if box.rate is None else f"{box.type} · {box.rate:g} Hz"


def lay_out(diagram: Diagram) -> Geometry:
    """Return the layout in at most MAX_WIDTH, if boxes in one column fit."""
    cells = place(diagram)
    most = max((column for column, _ in cells.values()), default=0) + 1
    geometry = route(diagram, cells)
    for columns in range(most, 0, -1):
        if geometry.width <= MAX_WIDTH:
            break
        geometry = route(diagram, folded(diagram, cells, columns))
    return geometry


def route(diagram: Diagram, cells: Mapping[Box, Cell]) -> Geometry:
    """Lay out the boxes in their cells and route every link."""
    return _Router(diagram, cells).run()


@dataclass(frozen=True, slots=True)
class _Detour:
    """A link through a lane; the keys identify the links with which it shares lane and tracks."""

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
        self._widths = self._column_widths()
        self._tallest: dict[int, float] = defaultdict(float)
        for box, (_, row) in cells.items():
            self._tallest[row] = max(self._tallest[row], self._height(box))
        self._detours = {
            link: _Detour(link, self._gap_for(link))
            for link in diagram.links
            if not self._is_direct(link)
        }
        self._lanes = self._assign_lanes()
        self._leaving = self._assign_tracks(d.net for d in self._detours.values())
        self._landing = self._assign_tracks(d.landing for d in self._detours.values())
        self._notes = self._note_widths()
        self._attached = self._media_by_column()

    def run(self) -> Geometry:
        self._xs, right = self._column_places()
        self._ys, bottom = self._row_places()
        frames = {
            box: Frame(
                self._xs[column], self._ys[row], self._widths[column], self._height(box)
            )
            for box, (column, row) in self._cells.items()
        }
        first = bottom - MARGIN + _TRUNK
        heights = {m: first + m.number * _TRUNK for m in self._diagram.media}
        if heights:
            bottom = max(heights.values()) + _TRUNK
        trunks = {
            medium: (
                min(xs := self._riser_places(medium)),
                max(*xs, min(xs) + text_width(medium.label, TEXT_SIZE) + _CLEAR),
                y,
            )
            for medium, y in heights.items()
        }
        right = max(right, *(x + MARGIN for _, x, _ in trunks.values()), 0)
        geometry = Geometry(right, bottom, frames, (), trunks, {})
        return Geometry(
            right,
            bottom,
            frames,
            [self._path(link, geometry) for link in self._diagram.links],
            trunks,
            {medium: self._risers(medium, geometry) for medium in heights},
        )

    def _note_widths(self) -> dict[int, float]:
        """Return the width of the longest note of times at a port, by column."""
        widths: dict[int, float] = defaultdict(float)
        for tab, note in notes(self._diagram).items():
            column = self._cells[tab.box][0]
            widths[column] = max(widths[column], text_width(note, TEXT_SIZE) + TAB)
        return widths

    def _media_by_column(self) -> dict[int, list[Medium]]:
        attached: dict[int, list[Medium]] = defaultdict(list)
        for medium in self._diagram.media:
            for column in sorted({self._cells[box][0] for box, _ in medium.nodes}):
                attached[column].append(medium)
        return attached

    def _inset(self, column: int) -> float:
        """Return the part of a channel next to the boxes, which notes and risers need."""
        risers = len(self._attached[column])
        return self._notes[column] + (risers * _STEP + _CLEAR / 2 if risers else 0)

    def _riser_x(self, medium: Medium, column: int) -> float:
        place = self._attached[column].index(medium)
        return self._xs[column] - TAB - _CLEAR / 2 - place * _STEP

    def _riser_places(self, medium: Medium) -> list[float]:
        columns = {self._cells[box][0] for box, _ in medium.nodes}
        return [self._riser_x(medium, column) for column in sorted(columns)]

    def _risers(self, medium: Medium, geometry: Geometry) -> str:
        """Return vertical lines for the columns with boxes on the medium, and stubs to them."""
        down = geometry.trunks[medium][2]
        tops: dict[float, float] = {}
        stubs = []
        for box, _ in medium.nodes:
            x = self._riser_x(medium, self._cells[box][0])
            index = [m for m, _ in box.media].index(medium)
            y = geometry.media_row(box, index)
            tops[x] = min(y, tops.get(x, y))
            stubs.append(f"M{_n(x)},{_n(y)} H{_n(geometry.frames[box].x)}")
        lines = [f"M{_n(x)},{_n(top)} V{_n(down)}" for x, top in sorted(tops.items())]
        return " ".join((*lines, *stubs))

    def _is_direct(self, link: Link) -> bool:
        """Return whether the line between the two boxes in the source's row is free."""
        column, row = self._cells[link.source.box]
        target = self._cells[link.target.box][0]
        between = range(column + 1, target)
        return target > column and not any((c, row) in self._taken for c in between)

    def _gap_for(self, link: Link) -> int:
        """Return the gap with the smallest detour, counted from 0 above the first row."""
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
        """Return the height of a tab within its row, from 0 to 1."""
        row = self._cells[tab.box][1]
        return (HEADER + (tab.row + 0.5) * ROW) / self._tallest[row]

    def _assign_lanes(self) -> dict[tuple[Tab, int], int]:
        """Assign each net a lane of its gap: short ones inside, without overlaps."""
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
        """Assign each end a vertical track before its box, inner ones for ends near the gap."""
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
        rows = box.rows or (0 if box.media else 1)
        return HEADER + rows * ROW + len(box.media) * MEDIUM_ROW + 8

    def _column_widths(self) -> list[float]:
        return [
            max(
                (box_width(box) for box, (c, _) in self._cells.items() if c == column),
                default=0,
            )
            for column in range(self._columns)
        ]

    def _column_places(self) -> tuple[list[float], float]:
        """Return the left edge of each column, and the right edge of the picture."""
        leaving = self._track_counts(self._leaving)
        landing = self._track_counts(self._landing)
        places: list[float] = []
        x = float(MARGIN)
        for column in range(self._columns):
            tracks = leaving[column - 1] + landing[column]
            inner = _CHANNEL if column else TAB
            x += inner + (tracks * _STEP + _CLEAR if tracks else 0)
            x += self._inset(column)
            places.append(x)
            x += self._widths[column]
        tracks = leaving[self._columns - 1]
        return places, x + TAB + (tracks * _STEP + _CLEAR if tracks else 0) + MARGIN

    def _track_counts(self, tracks: Mapping[tuple[Tab, int], int]) -> dict[int, int]:
        counts: dict[int, int] = defaultdict(int)
        for (tab, _), track in tracks.items():
            column = self._cells[tab.box][0]
            counts[column] = max(counts[column], track + 1)
        return counts

    def _row_places(self) -> tuple[list[float], float]:
        """Return the top of each row, and the bottom of the picture."""
        lanes: dict[int, int] = defaultdict(int)
        for (_, gap), lane in self._lanes.items():
            lanes[gap] = max(lanes[gap], lane + 1)
        places: list[float] = []
        y = float(MARGIN + TITLE)
        for row in range(self._rows):
            gap = lanes[row] * _STEP
            y += gap + (_GAP if row else _CLEAR if gap else 0)
            places.append(y)
            y += self._tallest[row]
        gap = lanes[self._rows] * _STEP
        return places, y + (gap + _CLEAR if gap else 0) + MARGIN

    def _lane_y(self, net: tuple[Tab, int], geometry: Geometry) -> float:
        """Return the height of a lane; in the topmost gap the first lane is the lowest."""
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
        back -= self._inset(self._cells[link.target.box][0])
        return _rounded(
            [(x1, y1), (out, y1), (out, lane), (back, lane), (back, y2), (x2, y2)]
        )

    def _direct(self, link: Link, start: Point, end: Point) -> str:
        """Return a straight line along the source's row, then a curve through the last channel."""
        column = self._cells[link.target.box][0]
        previous = column - 1
        turn = max(start[0], self._xs[previous] + self._widths[previous] + TAB)
        if previous == self._cells[link.source.box][0]:
            turn = start[0]
        last = end[0] - self._inset(column)
        middle = (turn + last) / 2
        line = f"M{_n(start[0])},{_n(start[1])}"
        if turn > start[0]:
            line += f" H{_n(turn)}"
        points = f"{_n(middle)},{_n(start[1])} {_n(middle)},{_n(end[1])} {_n(last)},{_n(end[1])}"
        straight = f" H{_n(end[0])}" if last < end[0] else ""
        return f"{line} C{points}{straight}"


def _rounded(points: Sequence[Point]) -> str:
    """Return an orthogonal line with rounded corners."""
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
    """Return the point at a distance from `start` on an axis-parallel line to `end`."""
    whole = _distance(start, end)
    share = length / whole if whole else 0.0
    return (
        start[0] + (end[0] - start[0]) * share,
        start[1] + (end[1] - start[1]) * share,
    )


def _n(value: float) -> str:
    """Return a length with at most one decimal."""
    return f"{value:.1f}".removesuffix(".0")
