"""Lays out boxes on a grid, and routes links through the channels between them.

`router` has the routes of links. A medium (CAN bus, TCP or serial line) is a trunk below all boxes
with risers in the channels. Lengths are in SVG units.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import fsum

from rtgen.compiler.backends.wiring.diagram import Box, Diagram, Link, Medium, Tab
from rtgen.compiler.backends.wiring.placement import Cell, folded, place
from rtgen.compiler.backends.wiring.router import Place, Router
from rtgen.facts.columns import columns

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

_SHARES = (0.0, 0.58, 1.0)
"""Width of a character by its columns, as a share of the size of the font."""
_LARGE = 5000
"""Height of a picture of MAX_WIDTH from which on it is drawn wider."""

_MIN_BOX = 130
_TRUNK = 34
_CHANNEL = 44
_GAP = 36
_STEP = 10
_CLEAR = 16


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

    `wires` are the corners of each link of the diagram. `trunks` have the line of each medium as
    (x1, x2, y), `risers` its lines from the trunk to the boxes.
    """

    width: float
    height: float
    frames: Mapping[Box, Frame]
    wires: Sequence[Sequence[Place]]
    trunks: Mapping[Medium, tuple[float, float, float]]
    risers: Mapping[Medium, Sequence[tuple[Place, Place]]]

    def anchor(self, tab: Tab) -> Place:
        """Return the middle of a tab, on the border of its box."""
        frame = self.frames[tab.box]
        x = frame.x if tab.is_left else frame.x + frame.width
        return x, frame.y + _depth(tab)

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
    return _SHARES[columns(character, on_terminal=False)]


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
    """Return the rates and the times at which a timeline connects it, for the tabs that have some.

    A rate is that of a periodic connection; the one of a writer is at its box.
    """
    times: dict[Tab, set[float]] = defaultdict(set)
    rates: dict[Tab, set[float]] = defaultdict(set)
    for link in diagram.links:
        if link.times:
            times[link.target] |= set(link.times)
        if link.rate is not None:
            rates[link.target].add(link.rate)
    parts: dict[Tab, list[str]] = defaultdict(list)
    for values, unit in ((rates, "Hz"), (times, "s")):
        for tab, numbers in values.items():
            parts[tab].append(f"{', '.join(f'{n:g}' for n in sorted(numbers))} {unit}")
    return {tab: " · ".join(texts) for tab, texts in parts.items()}


def subtitle(box: Box) -> str:
    """Return type and rate of a box."""
    return box.type if box.rate is None else f"{box.type} · {box.rate:g} Hz"


def lay_out(diagram: Diagram) -> Geometry:
    """Return the layout in at most MAX_WIDTH, if boxes in one column fit.

    That of a large system, which would be a strip, is about as wide as high.
    """
    cells = place(diagram)
    boxes = diagram.boxes
    most = max((column for column, _ in cells.values()), default=0) + 1
    width = fsum(box_width(box) for box in boxes) / max(1, len(boxes)) + 2 * _CHANNEL
    height = fsum(_height(box) + _GAP for box in boxes)
    columns = min(most, int(MAX_WIDTH // width) + 2)
    if height * width > _LARGE * MAX_WIDTH:
        columns = min(most, round((height / width) ** 0.5))
        return route(diagram, folded(diagram, cells, columns, dense=True))
    geometry = route(diagram, cells) if columns == most else None
    for number in range(columns, 0, -1):
        if geometry is not None and geometry.width <= MAX_WIDTH:
            break
        geometry = route(diagram, folded(diagram, cells, number))
    assert geometry is not None
    return geometry


def route(diagram: Diagram, cells: Mapping[Box, Cell]) -> Geometry:
    """Lay out the boxes in their cells and route every link."""
    return _Grid(diagram, cells).run()


class _Grid:
    """Columns and rows of boxes, with the channels between them."""

    def __init__(self, diagram: Diagram, cells: Mapping[Box, Cell]) -> None:
        self._diagram = diagram
        self._cells = cells
        self._columns = max((column for column, _ in cells.values()), default=-1) + 1
        self._rows = max((row for _, row in cells.values()), default=-1) + 1
        self._widths: dict[int, float] = defaultdict(float)
        self._tallest: dict[int, float] = defaultdict(float)
        for box, (column, row) in cells.items():
            self._widths[column] = max(self._widths[column], box_width(box))
            self._tallest[row] = max(self._tallest[row], _height(box))
        self._notes = self._note_widths()
        self._attached = self._media_by_column()
        depths = {tab: _depth(tab) for box in cells for tab in box.tabs}
        self._router = Router(diagram.links, cells, depths, self._tallest)
        self._first: dict[int, float] = {}

    def run(self) -> Geometry:
        rows, bottom = self._row_places()
        lanes = self._lane_heights(rows)
        self._xs, right = self._column_places(
            self._router.assign(dict(enumerate(rows)), lanes)
        )
        frames = {
            box: Frame(self._xs[column], rows[row], self._widths[column], _height(box))
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
        return replace(
            geometry,
            wires=[self._wire(link, geometry, lanes) for link in self._diagram.links],
            risers={medium: self._risers(medium, geometry) for medium in heights},
        )

    def _wire(
        self, link: Link, geometry: Geometry, lanes: Mapping[Tab, float]
    ) -> list[Place]:
        (x1, y1), (x2, y2) = geometry.anchor(link.source), geometry.anchor(link.target)
        ends = (x1 + TAB, y1), (x2 - TAB, y2)
        return self._router.path(link, ends, lanes, self._first, _STEP)

    def _note_widths(self) -> dict[int, float]:
        """Return the width of the longest note at a port, by column."""
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

    def _risers(self, medium: Medium, geometry: Geometry) -> list[tuple[Place, Place]]:
        """Return vertical lines for the columns with boxes on the medium, and stubs to them."""
        down = geometry.trunks[medium][2]
        tops: dict[float, float] = {}
        stubs = []
        for box, _ in medium.nodes:
            x = self._riser_x(medium, self._cells[box][0])
            index = [m for m, _ in box.media].index(medium)
            y = geometry.media_row(box, index)
            tops[x] = min(y, tops.get(x, y))
            stubs.append(((x, y), (geometry.frames[box].x, y)))
        return [*(((x, top), (x, down)) for x, top in sorted(tops.items())), *stubs]

    def _column_places(self, tracks: Mapping[int, int]) -> tuple[list[float], float]:
        """Return the left edge of each column, and the right edge of the picture."""
        places: list[float] = []
        x = float(MARGIN)
        for column in range(self._columns + 1):
            count = tracks.get(column, 0)
            outer = TAB if column else 0
            self._first[column] = x + outer + (_CLEAR if column else 0)
            needed = (count - 1) * _STEP + _CLEAR + (_CLEAR if column else 0)
            x += outer + (needed if count else 0)
            if column == self._columns:
                break
            x += self._inset(column) + TAB
            if column:
                x = max(x, places[-1] + self._widths[column - 1] + _CHANNEL)
            places.append(x)
            x += self._widths[column]
        return places, x + MARGIN

    def _row_places(self) -> tuple[list[float], float]:
        """Return the top of each row, and the bottom of the picture."""
        lanes = self._router.counts()
        places: list[float] = []
        y = float(MARGIN + TITLE)
        for row in range(self._rows):
            gap = lanes.get(row, 0) * _STEP
            y += gap + (_GAP if row else _CLEAR if gap else 0)
            places.append(y)
            y += self._tallest[row]
        gap = lanes.get(self._rows, 0) * _STEP
        return places, y + (gap + _CLEAR if gap else 0) + MARGIN

    def _lane_heights(self, rows: Sequence[float]) -> dict[Tab, float]:
        """Return the height of each lane; those of the topmost gap end above the boxes."""
        heights = {}
        counts = self._router.counts()
        for source, lane in self._router.lanes.items():
            gap = self._router.nets[source].gap
            if gap == 0:
                top = rows[0] - _CLEAR - (counts[0] - 1) * _STEP
            else:
                top = rows[gap - 1] + self._tallest[gap - 1] + _CLEAR
            heights[source] = top + lane * _STEP
        return heights


def _height(box: Box) -> float:
    rows = box.rows or (0 if box.media else 1)
    return HEADER + rows * ROW + len(box.media) * MEDIUM_ROW + 8


def _depth(tab: Tab) -> float:
    """Return the height of a tab within its box."""
    return HEADER + (tab.row + 0.5) * ROW
