"""Routes wires through the channels between columns and rows of boxes.

Each wire has horizontal and vertical parts only, and no part lies behind a box. It leaves its
OutPort to the right and comes to its InPort from the left: with one turn in the channel before
the target, if the row of the source is free up to there; else by a lane between two rows. All
wires of a source have one lane.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import fsum

from rtgen.compiler.backends.wiring.channels import (
    Pair,
    Stretch,
    cyclic,
    precedences,
    tracks,
)
from rtgen.compiler.backends.wiring.diagram import Box, Link, Tab
from rtgen.compiler.backends.wiring.placement import Cell

Place = tuple[float, float]


@dataclass(slots=True, eq=False)
class Net:
    """The wires of a source.

    `column` is the channel of the source. `direct` are the links with a turn in each channel,
    `landing` those that come to it by the lane in `gap`.
    """

    source: Tab
    column: int
    direct: dict[int, list[Link]] = field(default_factory=dict)
    landing: dict[int, list[Link]] = field(default_factory=dict)
    gap: int = -1

    @property
    def reach(self) -> tuple[int, int]:
        """The first and the last channel of the lane."""
        channels = (self.column, *self.landing)
        return min(channels), max(channels)


class Router:
    """The routes of all links between boxes in cells.

    `depths` has the height of each tab within its row, in SVG units, and `tallest` the height of
    each row: ports of one row and depth are at one height.
    """

    def __init__(
        self,
        links: Sequence[Link],
        cells: Mapping[Box, Cell],
        depths: Mapping[Tab, float],
        tallest: Mapping[int, float],
    ) -> None:
        self._cells = cells
        self._depths = depths
        self._tallest = tallest
        self._rows = max((row for _, row in cells.values()), default=-1) + 1
        self._taken: dict[int, list[int]] = defaultdict(list)
        for column, row in cells.values():
            self._taken[row].append(column)
        self.nets: dict[Tab, Net] = {}
        for link in links:
            self._add(link)
        self._divert()
        for net in self.nets.values():
            if net.landing:
                net.gap = self._gap(net)
        self.lanes = self._lanes()
        self._turns: dict[tuple[Tab, int], Stretch] = {}
        self._landings: dict[tuple[Tab, int], Stretch] = {}
        self._tracks: dict[Stretch, int] = {}

    def _add(self, link: Link) -> None:
        column, row = self._cells[link.source.box]
        target = self._cells[link.target.box][0]
        net = self.nets.setdefault(link.source, Net(link.source, column + 1))
        free = target > column and not any(
            column < taken < target for taken in self._taken[row]
        )
        (net.direct if free else net.landing).setdefault(target, []).append(link)

    def _height(self, tab: Tab, rows: Mapping[int, float] | None = None) -> float:
        """Return the height of a tab; without tops of the rows one that is as distinct."""
        row = self._cells[tab.box][1]
        top = row * 1e6 if rows is None else rows[row]
        return top + self._depths[tab]

    def _divert(self) -> None:
        """Let wires that would overlap in any order of the stretches use a lane."""
        channels: dict[int, dict[Stretch, Net]] = defaultdict(dict)
        for net in self.nets.values():
            for channel, links in net.direct.items():
                before = {self._height(net.source)}
                after = {self._height(link.target) for link in links}
                channels[channel][Stretch(net.source, before, after)] = net
        for channel, nets in channels.items():
            for stretch in cyclic([*nets], precedences([*nets])):
                net = nets[stretch]
                height = self._height(net.source)
                straight = [
                    link
                    for link in net.direct[channel]
                    if self._height(link.target) == height
                ]
                turning = [e for e in net.direct.pop(channel) if e not in straight]
                net.landing.setdefault(channel, []).extend(turning)
                if straight:
                    net.direct[channel] = straight

    def _gap(self, net: Net) -> int:
        """Return the gap with the smallest detour, counted from 0 above the first row."""
        links = [link for each in net.landing.values() for link in each]
        ends = [self._share(net.source), *(self._share(link.target) for link in links)]
        forward = net.column <= max(net.landing)
        near = int(min(ends)), int(max(ends)) + 1
        return min(
            range(max(0, near[0]), min(self._rows, near[1]) + 1),
            key=lambda gap: (
                fsum(abs(gap - end) for end in ends),
                gap if forward else -gap,
            ),
        )

    def _share(self, tab: Tab) -> float:
        """Return the height of a tab in rows."""
        row = self._cells[tab.box][1]
        return row + self._depths[tab] / self._tallest[row]

    def _lanes(self) -> dict[Tab, int]:
        """Return the lane of each net with one, from 0 at the top of its gap."""
        gaps: dict[int, list[Stretch]] = defaultdict(list)
        for net in self.nets.values():
            if not net.landing:
                continue
            lane = Stretch(net.source)
            ends = [(net.column, self._cells[net.source.box][1])]
            ends += [
                (channel, self._cells[link.target.box][1])
                for channel, links in net.landing.items()
                for link in links
            ]
            for channel, row in ends:
                (lane.before if row < net.gap else lane.after).add(channel * 1e3)
            gaps[net.gap].append(lane)
        return {
            lane.source: place
            for lanes in gaps.values()
            for lane, place in tracks(lanes, ()).items()
            if isinstance(lane.source, Tab)
        }

    def counts(self) -> dict[int, int]:
        """Return the number of lanes in each gap."""
        most: dict[int, int] = defaultdict(int)
        for source, lane in self.lanes.items():
            gap = self.nets[source].gap
            most[gap] = max(most[gap], lane + 1)
        return most

    def assign(
        self, rows: Mapping[int, float], lanes: Mapping[Tab, float]
    ) -> dict[int, int]:
        """Assign tracks, for the tops of rows and the heights of lanes.

        Returns the number of tracks in each channel, from 0 before the first column.
        """
        channels: dict[int, list[Stretch]] = defaultdict(list)
        pairs: dict[int, list[Pair]] = defaultdict(list)
        for net in self.nets.values():
            start = self._height(net.source, rows)
            through = any(channel > net.column for channel in net.direct)
            if net.landing or net.column in net.direct:
                leaving = Stretch(net.source, {start}, set(), -1)
                self._turns[net.source, net.column] = leaving
                channels[net.column].append(leaving)
                if through:
                    leaving.after.add(start)
            for channel, links in net.direct.items():
                if channel == net.column:
                    turn = self._turns[net.source, channel]
                else:
                    turn = Stretch(net.source, {start}, set())
                    self._turns[net.source, channel] = turn
                    channels[channel].append(turn)
                turn.pull = 0
                turn.after |= {self._height(link.target, rows) for link in links}
                if through and channel < max(net.direct):
                    turn.after.add(start)
            if net.landing:
                height = lanes[net.source]
                leaving = self._turns[net.source, net.column]
                _pass(leaving, height, net.column, net)
                for channel, links in net.landing.items():
                    after = {self._height(link.target, rows) for link in links}
                    landing = Stretch(net.source, set(), after, 1)
                    _pass(landing, height, channel, net)
                    if channel == net.column:
                        landing.before.add(height)
                        leaving.after.add(height)
                        pairs[channel].append((leaving, landing))
                    self._landings[net.source, channel] = landing
                    channels[channel].append(landing)
        counts: dict[int, int] = {}
        for channel, stretches in channels.items():
            order = {*precedences(stretches), *pairs[channel]}
            number = {each: index for index, each in enumerate(stretches)}
            placed = tracks(
                stretches, sorted(order, key=lambda p: (number[p[0]], number[p[1]]))
            )
            self._tracks |= placed
            counts[channel] = max(placed.values(), default=-1) + 1
        return counts

    def path(
        self,
        link: Link,
        ends: tuple[Place, Place],
        lanes: Mapping[Tab, float],
        first: Mapping[int, float],
        step: float,
    ) -> list[Place]:
        """Return the corners of a wire; `first` has the place of each channel's first track."""
        (x1, y1), (x2, y2) = ends
        net = self.nets[link.source]
        channel = self._cells[link.target.box][0]

        def place(stretch: Stretch, at: int) -> float:
            return first[at] + self._tracks[stretch] * step

        if link in net.direct.get(channel, ()):
            if y1 == y2:
                return [(x1, y1), (x2, y2)]
            x = place(self._turns[link.source, channel], channel)
            return [(x1, y1), (x, y1), (x, y2), (x2, y2)]
        lane = lanes[link.source]
        out = place(self._turns[link.source, net.column], net.column)
        back = place(self._landings[link.source, channel], channel)
        return [(x1, y1), (out, y1), (out, lane), (back, lane), (back, y2), (x2, y2)]


def _pass(stretch: Stretch, height: float, channel: int, net: Net) -> None:
    """Add the lane of a net to a stretch, on the sides where the lane goes on."""
    low, high = net.reach
    if low < channel:
        stretch.before.add(height)
    if channel < high:
        stretch.after.add(height)
