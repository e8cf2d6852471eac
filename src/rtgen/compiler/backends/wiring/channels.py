"""Orders parallel stretches of wires, without overlaps and with few crossings.

A stretch is the part of a wire along a channel: vertical between two columns of boxes, or
horizontal between two rows. Its wire comes to it, and leaves it, on both sides of the channel.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush

_APART = 6
"""Minimum distance of two stretches in one track, in SVG units."""


@dataclass(slots=True, eq=False)
class Stretch:
    """A stretch of the wires of one source.

    `before` are the positions along the channel at which wires touch it from the side of the
    smaller coordinate (from the left, from above), `after` those of the other side. `pull` is
    the side that it lies near to: the one of `before` if it is negative.
    """

    source: Hashable
    before: set[float] = field(default_factory=set)
    after: set[float] = field(default_factory=set)
    pull: int = 0

    @property
    def low(self) -> float:
        """The start of the stretch."""
        return min(self.before | self.after)

    @property
    def high(self) -> float:
        """The end of the stretch."""
        return max(self.before | self.after)


Pair = tuple[Stretch, Stretch]


def precedences(stretches: Sequence[Stretch]) -> set[Pair]:
    """Return the pairs of stretches of which the first must lie before the second.

    Wires come to them on both sides at one position, and would overlap in the other order.
    """
    from_before: dict[float, list[Stretch]] = defaultdict(list)
    for stretch in stretches:
        for position in stretch.before - stretch.after:
            from_before[position].append(stretch)
    return {
        (first, second)
        for second in stretches
        for position in second.after - second.before
        for first in from_before.get(position, ())
        if first.source != second.source
    }


def cyclic(stretches: Sequence[Stretch], pairs: Iterable[Pair]) -> list[Stretch]:
    """Return stretches without which the precedences of the others have no cycle."""
    earlier: dict[Stretch, set[Stretch]] = {each: set() for each in stretches}
    later: dict[Stretch, set[Stretch]] = {each: set() for each in stretches}
    for first, second in pairs:
        earlier[second].add(first)
        later[first].add(second)
    left: list[Stretch] = []
    removed: list[Stretch] = []
    remaining = dict.fromkeys(stretches)
    free = [each for each in stretches if not earlier[each]]
    while remaining:
        if not free:
            worst = max(
                (each for each in remaining if earlier[each] and later[each]),
                key=lambda each: len(earlier[each]) * len(later[each]),
            )
            removed.append(worst)
            free.append(worst)
        for stretch in free:
            del remaining[stretch]
            left.append(stretch)
        freed = []
        for stretch in free:
            for other in later.pop(stretch):
                earlier[other].discard(stretch)
                if other in remaining and not earlier[other]:
                    freed.append(other)
            for other in earlier[stretch]:
                later[other].discard(stretch)
        free = list(dict.fromkeys(freed))
    return removed


def tracks(stretches: Sequence[Stretch], pairs: Iterable[Pair]) -> dict[Stretch, int]:
    """Return the track of each stretch, from 0; stretches that touch have different ones."""
    order = _in_order(stretches, pairs)
    ranges = [(each.low - _APART / 2, each.high + _APART / 2) for each in order]
    neighbours = _overlapping(ranges)
    last = [0] * len(order)
    for index in range(len(order)):
        before = (last[other] + 1 for other in neighbours[index] if other < index)
        last[index] = max(before, default=0)
    most = max(last, default=0)
    latest = [most] * len(order)
    for index in reversed(range(len(order))):
        behind = (latest[other] - 1 for other in neighbours[index] if other > index)
        latest[index] = min(behind, default=most)
    places = [0] * len(order)
    for index, stretch in enumerate(order):
        before = (places[other] + 1 for other in neighbours[index] if other < index)
        nearest = max(before, default=0)
        middle = (nearest + latest[index]) // 2
        places[index] = (nearest, middle, latest[index])[stretch.pull + 1]
    return dict(zip(order, places, strict=True))


def _overlapping(ranges: Sequence[tuple[float, float]]) -> list[list[int]]:
    """Return the indices of the ranges that each one touches."""
    touching: list[list[int]] = [[] for _ in ranges]
    active: list[int] = []
    for index in sorted(range(len(ranges)), key=lambda each: ranges[each]):
        low = ranges[index][0]
        active = [other for other in active if ranges[other][1] >= low]
        for other in active:
            touching[index].append(other)
            touching[other].append(index)
        active.append(index)
    return touching


def _in_order(stretches: Sequence[Stretch], pairs: Iterable[Pair]) -> list[Stretch]:
    """Return the stretches with few crossings, and the first one of each pair before the other.

    The next one is always that with the fewest crossings if it lies before all that remain.
    """
    costs = _costs(stretches)
    number = {each: index for index, each in enumerate(stretches)}
    waiting = [0] * len(stretches)
    later: dict[int, list[int]] = defaultdict(list)
    for first, second in pairs:
        later[number[first]].append(number[second])
        waiting[number[second]] += 1
    keys = [
        (sum(costs[index].values()), each.pull, index)
        for index, each in enumerate(stretches)
    ]
    heap = [key for key in keys if not waiting[key[2]]]
    heapify(heap)
    order: list[Stretch] = []
    done = [False] * len(stretches)
    while heap:
        key = heappop(heap)
        chosen = key[2]
        if done[chosen] or key != keys[chosen]:
            continue
        done[chosen] = True
        order.append(stretches[chosen])
        for other, cost in costs[chosen].items():
            total, pull, _ = keys[other]
            keys[other] = (total + cost, pull, other)
            if not (waiting[other] or done[other]):
                heappush(heap, keys[other])
        for other in later[chosen]:
            waiting[other] -= 1
            if not waiting[other]:
                heappush(heap, keys[other])
    return order


def _costs(stretches: Sequence[Stretch]) -> list[dict[int, int]]:
    """Return the crossings that each stretch has more before another one than behind it."""
    costs: list[dict[int, int]] = [{} for _ in stretches]
    sides = [(sorted(each.before), sorted(each.after)) for each in stretches]
    ranges = [(each.low, each.high) for each in stretches]

    def crossings(first: int, second: int) -> int:
        low, high = ranges[first]
        positions = sides[second][0]
        number = max(0, bisect_left(positions, high) - bisect_right(positions, low))
        low, high = ranges[second]
        positions = sides[first][1]
        number += max(0, bisect_left(positions, high) - bisect_right(positions, low))
        # A wire that joins another one does so behind the place where that one parts.
        return number + 2 * len(stretches[first].after & stretches[second].before)

    for index, others in enumerate(_overlapping(ranges)):
        source = stretches[index].source
        for other in others:
            if other < index and source != stretches[other].source:
                cost = crossings(index, other) - crossings(other, index)
                if cost:
                    costs[index][other] = cost
                    costs[other][index] = -cost
    return costs
