"""Places boxes in columns and rows, by an editor's coordinates or by layers."""

from __future__ import annotations

from bisect import bisect_right, insort
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from heapq import heapify, heappop, heappush
from operator import add
from typing import TypeAlias

from rtgen.compiler.backends.wiring.diagram import Box, Diagram

Cell: TypeAlias = tuple[int, int]
"""Column and row, both from 0."""

_SAME_PLACE = 50
"""Boxes closer than this, in the editor's pixels, share a column or row."""

_SWEEPS = 6


def place(diagram: Diagram) -> dict[Box, Cell]:
    """Return the cell of each box; cells are distinct."""
    return _by_location(diagram.boxes) or _by_layers(diagram)


def folded(
    diagram: Diagram, cells: Mapping[Box, Cell], columns: int, *, dense: bool = False
) -> dict[Box, Cell]:
    """Return the cells in bands of at most `columns` columns, one band below the other.

    The boxes of a column keep their order; with `dense` there is no free row between them. Boxes
    without links fill the rows below, so that they do not widen the picture.
    """
    linked = {tab.box for link in diagram.links for tab in (link.source, link.target)}
    used = {column: n for n, column in enumerate(sorted({cells[b][0] for b in linked}))}
    bands: dict[int, dict[Box, Cell]] = defaultdict(dict)
    for box, (column, row) in cells.items():
        if box in linked:
            bands[used[column] // columns][box] = used[column] % columns, row
    placed: dict[Box, Cell] = {}
    first = 0
    for _, band in sorted(bands.items()):
        rows = _merged_rows(band.values())
        filled: dict[int, int] = defaultdict(int)
        for box, (column, row) in sorted(band.items(), key=lambda each: each[1]):
            placed[box] = column, first + (filled[column] if dense else rows[row])
            filled[column] += 1
        first += max(filled.values()) if dense else max(rows.values()) + 1
    others = sorted(
        (cells[box][::-1], n, box) for n, box in enumerate(cells) if box not in linked
    )
    for place, (_, _, box) in enumerate(others):
        placed[box] = place % columns, first + place // columns
    return {box: placed[box] for box in cells}


def _merged_rows(cells: Iterable[Cell]) -> dict[int, int]:
    """Return new rows from 0: a row joins the one above if no column has boxes in both."""
    columns: dict[int, set[int]] = defaultdict(set)
    for column, row in cells:
        columns[row].add(column)
    merged: dict[int, int] = {}
    taken: set[int] = set()
    number = -1
    for row in sorted(columns):
        if number < 0 or taken & columns[row]:
            number += 1
            taken = set()
        taken |= columns[row]
        merged[row] = number
    return merged


def _by_location(boxes: Sequence[Box]) -> dict[Box, Cell] | None:
    located = [box.location for box in boxes if box.location is not None]
    if len(located) < len(boxes):
        return None
    columns = _ranks([x for x, _ in located])
    rows = _ranks([y for _, y in located])
    cells = {
        box: (columns[x], rows[y]) for box, (x, y) in zip(boxes, located, strict=True)
    }
    return cells if len(set(cells.values())) == len(boxes) else None


def _ranks(values: Sequence[int]) -> dict[int, int]:
    ranks: dict[int, int] = {}
    first = rank = 0
    for value in sorted(set(values)):
        if not ranks:
            first = value
        elif value - first >= _SAME_PLACE:
            first, rank = value, rank + 1
        ranks[value] = rank
    return ranks


def _by_layers(diagram: Diagram) -> dict[Box, Cell]:
    """Sugiyama's method: break cycles, assign layers, order each layer with few crossings."""
    boxes = list(diagram.boxes)
    number = {box: index for index, box in enumerate(boxes)}
    edges = [
        (number[link.source.box], number[link.target.box])
        for link in diagram.links
        if link.source.box is not link.target.box
    ]
    order = _order_without_cycles(len(boxes), edges)
    forward = [(a, b) for a, b in edges if order[a] < order[b]]
    columns = _layers(
        len(boxes), forward, sorted(range(len(boxes)), key=order.__getitem__)
    )
    rows = _rows(columns, edges)
    return {box: (columns[index], rows[index]) for box, index in number.items()}


def _order_without_cycles(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """Order the boxes such that few edges point backward (Eades, Lin, Smyth 1993)."""
    followers = _adjacent(count, edges)
    leaders = _adjacent(count, [(b, a) for a, b in edges])
    outgoing = [len(each) for each in followers]
    incoming = [len(each) for each in leaders]
    # The next sink, source and box with fewest edges in; entries that no longer hold are skipped.
    sinks = [-n for n in range(count) if incoming[n] and not outgoing[n]]
    inmost = [(incoming[n], n) for n in range(count)]
    heapify(sinks)
    heapify(inmost)
    placed = [False] * count
    head: list[int] = []
    tail: list[int] = []
    while len(head) + len(tail) < count:
        if sinks:
            chosen = -heappop(sinks)
            if placed[chosen] or not incoming[chosen]:
                continue
            tail.append(chosen)
        else:
            edges_in, chosen = heappop(inmost)
            if placed[chosen] or edges_in != incoming[chosen]:
                continue
            head.append(chosen)
        placed[chosen] = True
        for node in leaders[chosen]:
            outgoing[node] -= 1
            if not outgoing[node] and not placed[node]:
                heappush(sinks, -node)
        for node in followers[chosen]:
            incoming[node] -= 1
            if not placed[node]:
                heappush(inmost, (incoming[node], node))
    positions = [0] * count
    for position, node in enumerate(head + tail[::-1]):
        positions[node] = position
    return positions


def _adjacent(count: int, edges: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Return the ends of the edges from each box."""
    ends: list[list[int]] = [[] for _ in range(count)]
    for a, b in edges:
        ends[a].append(b)
    return ends


def _layers(
    count: int, forward: Sequence[tuple[int, int]], order: Sequence[int]
) -> list[int]:
    """Return the column of each box: one after its last predecessor.

    Sources are next to their successors.
    """
    columns = [0] * count
    followers = _adjacent(count, forward)
    leaders = _adjacent(count, [(b, a) for a, b in forward])
    for node in order:
        columns[node] = max((columns[a] + 1 for a in leaders[node]), default=0)
    for node in reversed(order):
        if followers[node] and not leaders[node]:
            columns[node] = min(columns[b] for b in followers[node]) - 1
    return columns


def _rows(columns: Sequence[int], edges: Sequence[tuple[int, int]]) -> list[int]:
    """Return the row of each box: by the mean row of its neighbours in each column."""
    layers: list[list[int]] = [[] for _ in range(max(columns, default=-1) + 1)]
    for node, column in enumerate(columns):
        layers[column].append(node)
    height = max((len(layer) for layer in layers), default=0)
    backward = [(b, a) for a, b in edges]
    rows = [0] * len(columns)
    for layer in layers:
        for row, node in enumerate(layer):
            rows[node] = row
    near = [
        [other for other in both if columns[other] != columns[node]]
        for node, both in enumerate(
            map(add, _adjacent(len(rows), edges), _adjacent(len(rows), backward))
        )
    ]
    best, fewest = list(rows), _crossings(columns, rows, edges)
    for sweep in range(_SWEEPS):
        for layer in layers if sweep % 2 == 0 else layers[::-1]:
            _reorder(layer, rows, near, height)
        crossings = _crossings(columns, rows, edges)
        if crossings < fewest:
            best, fewest = list(rows), crossings
    return best


def _reorder(
    layer: Sequence[int], rows: list[int], near: Sequence[Sequence[int]], height: int
) -> None:
    heights: dict[int, float] = {}
    for node in layer:
        others = [rows[other] for other in near[node]]
        heights[node] = sum(others) / len(others) if others else rows[node]
    lowest = 0
    for index, node in enumerate(sorted(layer, key=lambda n: (heights[n], rows[n]))):
        room_below = height - (len(layer) - index)
        rows[node] = min(max(lowest, round(heights[node])), room_below)
        lowest = rows[node] + 1


def _crossings(
    columns: Sequence[int], rows: Sequence[int], edges: Sequence[tuple[int, int]]
) -> tuple[int, int]:
    """Return the cost of an order: pairs of crossing edges, then the total height of edges."""
    spans = [
        (
            ((columns[a], rows[a]), (columns[b], rows[b]))
            if columns[a] <= columns[b]
            else ((columns[b], rows[b]), (columns[a], rows[a]))
        )
        for a, b in edges
    ]
    groups: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    for start, end in spans:
        groups[start[0], end[0]].append((start[1], end[1]))
    crossed = 0
    for ends in groups.values():
        above: list[int] = []
        for _, row in sorted(ends):
            crossed += len(above) - bisect_right(above, row)
            insort(above, row)
    return crossed, sum(abs(start[1] - end[1]) for start, end in spans)
