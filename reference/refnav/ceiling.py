"""The ceiling: lamps, camera pictures of them, and the pose computed from a picture.

A picture has one octet for each pixel, row by row; its upper edge is ahead of the base, its left
edge to the left.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import atan2, ceil, cos, fsum, hypot, sin, sqrt
from typing import NamedTuple

from refnav.geometry import Pose
from refnav.map_text import lines, map_error

BRIGHT = 255


class Lamp(NamedTuple):
    """A round lamp at a point of the ceiling [m]."""

    x: float
    y: float
    radius: float


class View(NamedTuple):
    """Columns and rows of a camera, the pixel straight above the base, the size of a pixel [m]."""

    width: int
    height: int
    column: int
    row: int
    pixel: float


class Blob(NamedTuple):
    """A bright spot: its centre (column, row), number of pixels, and bounding box."""

    column: float
    row: float
    pixels: int
    left: int
    right: int
    top: int
    bottom: int

    @property
    def coefficient(self) -> float:
        """The bright fraction of the bounding box, 0 to 1."""
        size = (self.right - self.left + 1) * (self.bottom - self.top + 1)
        return self.pixels / size


def parse(text: str, name: str) -> list[Lamp]:
    """Parse the lamps in a file's text, one or more; `name` is used in errors. Raises MapError."""
    lamps = []
    for line, _, values in lines(text, name, {"m": 3}):
        lamp = Lamp(*values)
        if lamp.radius <= 0.0:
            raise map_error(name, line, "a lamp has a radius above 0")
        lamps.append(lamp)
    if not lamps:
        raise map_error(name, 1, "no lamp")
    return lamps


def picture(lamps: Iterable[Lamp], pose: Pose, view: View) -> bytearray:
    """Return the lamps as seen by a camera at a pose."""
    image = bytearray(view.width * view.height)
    along, across = cos(pose.theta), sin(pose.theta)
    for lamp in lamps:
        dx, dy = lamp.x - pose.x, lamp.y - pose.y
        column = view.column - (dy * along - dx * across) / view.pixel
        row = view.row - (dx * along + dy * across) / view.pixel
        _draw(image, view, column, row, lamp.radius / view.pixel)
    return image


def _draw(
    image: bytearray, view: View, column: float, row: float, radius: float
) -> None:
    first, last = max(0, ceil(row - radius)), min(view.height - 1, int(row + radius))
    for y in range(first, last + 1):
        half = sqrt(max(0.0, radius * radius - (y - row) * (y - row)))
        left, right = max(0, ceil(column - half)), min(
            view.width - 1, int(column + half)
        )
        if left <= right and column + half >= 0.0:
            begin = y * view.width
            image[begin + left : begin + right + 1] = bytes([BRIGHT]) * (
                right - left + 1
            )


def blobs(image: bytes, view: View, brightness: int) -> list[Blob]:
    """Return the spots of at least that brightness, except those cut by an edge of the picture."""
    threshold = bytes(1 if value >= brightness else 0 for value in range(256))
    marks = image.translate(threshold)
    found: list[_Spot] = []
    above: list[tuple[int, int, _Spot]] = []
    row = -1
    here: list[tuple[int, int, _Spot]] = []
    for y, left, right in _runs(marks, view.width):
        if y != row:
            above = here if y == row + 1 else []
            here = []
            row = y
        touched = [spot for begin, end, spot in above if begin <= right and left <= end]
        if touched:
            spot = touched[0].root()
            for other in touched[1:]:
                spot.take_in(other.root())
        else:
            spot = _Spot()
            found.append(spot)
        spot.add(y, left, right)
        here.append((left, right, spot))
    return [
        spot.blob()
        for spot in found
        if spot.root() is spot and not spot.cut(view.width, view.height)
    ]


def _runs(marks: bytes, width: int) -> Iterator[tuple[int, int, int]]:
    """Yield row, first and last column of each run of ones."""
    place = marks.find(1)
    while place >= 0:
        row = place // width
        edge = (row + 1) * width
        end = marks.find(0, place, edge)
        end = edge if end < 0 else end
        yield row, place - row * width, end - 1 - row * width
        place = marks.find(1, end)


class _Spot:
    """A spot under construction."""

    def __init__(self) -> None:
        self._columns = self._rows = self._pixels = 0
        self._left = self._top = 1 << 30
        self._right = self._bottom = -1
        self._parent: _Spot | None = None

    def root(self) -> _Spot:
        spot = self
        while spot._parent is not None:
            spot = spot._parent
        return spot

    def add(self, row: int, left: int, right: int) -> None:
        pixels = right - left + 1
        self._pixels += pixels
        self._columns += (left + right) * pixels
        self._rows += row * pixels
        self._stretch(left, right, row, row)

    def take_in(self, other: _Spot) -> None:
        if other is self:
            return
        self._pixels += other._pixels
        self._columns += other._columns
        self._rows += other._rows
        self._stretch(other._left, other._right, other._top, other._bottom)
        other._parent = self

    def _stretch(self, left: int, right: int, top: int, bottom: int) -> None:
        self._left, self._right = min(self._left, left), max(self._right, right)
        self._top, self._bottom = min(self._top, top), max(self._bottom, bottom)

    def cut(self, width: int, height: int) -> bool:
        return (
            self._left == 0
            or self._top == 0
            or self._right == width - 1
            or self._bottom == height - 1
        )

    def blob(self) -> Blob:
        return Blob(
            0.5 * self._columns / self._pixels,
            self._rows / self._pixels,
            self._pixels,
            self._left,
            self._right,
            self._top,
            self._bottom,
        )


def in_body(blob: Blob, view: View) -> tuple[float, float]:
    """Return the position of a spot's centre relative to the base: ahead, to the left [m]."""
    return (view.row - blob.row) * view.pixel, (view.column - blob.column) * view.pixel


def recognised(
    seen: Sequence[tuple[float, float]],
    lamps: Sequence[Lamp],
    about: Pose,
    scope: float,
) -> list[tuple[tuple[float, float], Lamp]]:
    """Match spots with lamps: the nearest, within `scope` diameters of the expected spot."""
    along, across = cos(about.theta), sin(about.theta)
    pairs = []
    for ahead, left in seen:
        x = about.x + ahead * along - left * across
        y = about.y + ahead * across + left * along
        lamp = min(lamps, key=lambda lamp: hypot(lamp.x - x, lamp.y - y))
        if hypot(lamp.x - x, lamp.y - y) <= scope * 2.0 * lamp.radius:
            pairs.append(((ahead, left), lamp))
    return pairs


def fitted(pairs: Sequence[tuple[tuple[float, float], Lamp]]) -> Pose | None:
    """Return the pose that fits the lamps best, by least squares; None for less than two lamps."""
    count = len(pairs)
    if count < 2:
        return None
    ahead = fsum(spot[0] for spot, _ in pairs) / count
    left = fsum(spot[1] for spot, _ in pairs) / count
    x = fsum(lamp.x for _, lamp in pairs) / count
    y = fsum(lamp.y for _, lamp in pairs) / count
    same = turned = 0.0
    for spot, lamp in pairs:
        a, b = spot[0] - ahead, spot[1] - left
        same += a * (lamp.x - x) + b * (lamp.y - y)
        turned += a * (lamp.y - y) - b * (lamp.x - x)
    theta = atan2(turned, same)
    along, across = cos(theta), sin(theta)
    return Pose(
        x - ahead * along + left * across, y - ahead * across - left * along, theta
    )
