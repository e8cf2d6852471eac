"""The map of the planner: nodes, and links with costs between them."""

from __future__ import annotations

from collections.abc import Mapping
from heapq import heappop, heappush
from math import hypot

from refnav.geometry import Pose
from refnav.map_text import lines, map_error


class RouteMap:
    """Nodes by number, and the costs of the links to their neighbours."""

    def __init__(
        self, nodes: Mapping[int, Pose], links: Mapping[int, Mapping[int, float]]
    ) -> None:
        self.nodes = nodes
        self.links = links

    def nearest(self, x: float, y: float) -> int:
        """Return the node nearest to a point [m]; of several the first in the file."""
        return min(
            self.nodes,
            key=lambda number: hypot(
                self.nodes[number].x - x, self.nodes[number].y - y
            ),
        )

    def cheapest(self, start: int, end: int) -> list[int]:
        """Return the nodes of the cheapest way, both ends included; empty if there is no way."""
        reached = {start: start}
        waiting = [(0.0, start, start)]
        done: set[int] = set()
        while waiting:
            cost, here, before = heappop(waiting)
            if here in done:
                continue
            done.add(here)
            reached[here] = before
            if here == end:
                return _back(reached, start, end)
            for neighbour, more in self.links.get(here, {}).items():
                if neighbour not in done:
                    heappush(waiting, (cost + more, neighbour, here))
        return []


def parse(text: str, name: str) -> RouteMap:
    """Parse the map in a file's text, of one node or more; `name` is used in errors.

    `n NUMBER X Y THETA` is a node [m, rad], `l FROM TO COST` a link in both directions, whose
    cost is its length if COST is not above 0. Raises MapError.
    """
    nodes: dict[int, Pose] = {}
    links: list[tuple[int, int, int, float]] = []
    for line, letter, values in lines(text, name, {"n": 4, "l": 3}):
        if letter == "n":
            number = _node(name, line, values[0])
            if number in nodes:
                raise map_error(name, line, f"node {number} is there already")
            nodes[number] = Pose(*values[1:])
        else:
            first, second = (_node(name, line, value) for value in values[:2])
            links.append((line, first, second, values[2]))
    if not nodes:
        raise map_error(name, 1, "no node")
    costs: dict[int, dict[int, float]] = {number: {} for number in nodes}
    for line, first, second, cost in links:
        for number in (first, second):
            if number not in nodes:
                raise map_error(name, line, f"there is no node {number}")
        a, b = nodes[first], nodes[second]
        worth = cost if cost > 0.0 else hypot(b.x - a.x, b.y - a.y)
        costs[first][second] = costs[second][first] = worth
    return RouteMap(nodes, costs)


def _node(name: str, line: int, value: float) -> int:
    if value != int(value):
        raise map_error(name, line, f"{value} is not a number of a node")
    return int(value)


def _back(reached: Mapping[int, int], start: int, end: int) -> list[int]:
    way = [end]
    while way[-1] != start:
        way.append(reached[way[-1]])
    return way[::-1]
