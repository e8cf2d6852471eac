"""Finds the wires that cross, and gives them unlike colours."""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from itertools import chain, count, pairwise
from typing import TypeVar

from rtgen.compiler.backends.wiring.router import Place

Wire = TypeVar("Wire", bound=Hashable)


def crossings(
    wires: Sequence[tuple[Wire, Sequence[Place]]],
) -> dict[tuple[Wire, Wire], set[Place]]:
    """Map pairs of a wire with a vertical and one with a horizontal part to where they cross.

    The parts of a path are horizontal or vertical; a wire may have several paths. One that ends
    at another, or turns at it, does not cross it.
    """
    # A horizontal part is added before, and removed after, the vertical ones between its ends.
    events: list[tuple[float, int, float, float, int]] = []
    owners: list[Wire] = []
    for owner, corners in wires:
        for (x1, y1), (x2, y2) in pairwise(corners):
            number = len(owners)
            if y1 == y2 and x1 != x2:
                events.append((min(x1, x2), 2, y1, y1, number))
                events.append((max(x1, x2), 0, y1, y1, number))
            elif y1 != y2:
                events.append((x1, 1, min(y1, y2), max(y1, y2), number))
            owners.append(owner)
    places: dict[tuple[Wire, Wire], set[Place]] = defaultdict(set)
    active: list[tuple[float, int]] = []
    for x, kind, low, high, number in sorted(events):
        if kind == 2:
            insort(active, (low, number))
        elif kind == 0:
            del active[bisect_left(active, (low, number))]
        else:
            end = bisect_left(active, (high, -1))
            for y, other in active[bisect_right(active, (low, len(owners))) : end]:
                if owners[number] != owners[other]:
                    places[owners[number], owners[other]].add((x, y))
    return places


def coloured(
    wishes: Mapping[Wire, int], pairs: Iterable[tuple[Wire, Wire]], colours: int
) -> dict[Wire, int]:
    """Return the number of a colour for each wire: unlike ones for those that cross.

    Each gets the one it wishes, if no wire that it crosses has it; else one of the first `colours`
    that others with its wish got, or few wish; else a further one. Wires with many crossings choose
    first.
    """
    crossed: dict[Wire, set[Wire]] = {wire: set() for wire in wishes}
    for one, other in pairs:
        crossed[one].add(other)
        crossed[other].add(one)
    chosen: dict[Wire, int] = {}
    wanted = Counter(wishes.values())
    others_of: dict[int, dict[int, None]] = defaultdict(dict)
    number = {wire: index for index, wire in enumerate(wishes)}
    order = sorted(wishes, key=lambda w: (-len(crossed[w]), number[w]))
    for wire in order:
        around = {chosen[other] for other in crossed[wire] if other in chosen}
        wish = wishes[wire]
        rare = sorted(range(colours), key=lambda colour: (wanted[colour], colour))
        chosen[wire] = next(
            colour
            for colour in chain([wish], others_of[wish], rare, count(colours))
            if colour not in around
        )
        if chosen[wire] != wish:
            others_of[wish][chosen[wire]] = None
            wanted[chosen[wire]] += 1
    return {wire: chosen[wire] for wire in wishes}
