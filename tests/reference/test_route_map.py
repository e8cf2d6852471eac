"""The map of the planner: cheapest ways, nearest nodes, and invalid texts."""

from __future__ import annotations

from itertools import pairwise, permutations
from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from refnav.map_text import MapError
from refnav.route_map import parse

SQUARE = """
# a square with a diagonal
n 0 0 0 0
n 1 1 0 0
n 2 1 1 0
n 3 0 1 0
l 0 1 0
l 1 2 -1   # its length
l 2 3 0
l 3 0 5
l 0 2 1.5
"""


def test_links_cost_their_length_where_no_cost_is_given() -> None:
    links = parse(SQUARE, "map").links
    assert links[0] == {1: 1.0, 3: 5.0, 2: 1.5}
    assert links[1] == {0: 1.0, 2: 1.0}


def test_the_cheapest_way_counts() -> None:
    route = parse(SQUARE, "map")
    assert route.cheapest(0, 2) == [0, 2]
    assert route.cheapest(0, 3) == [0, 2, 3]
    assert route.cheapest(3, 0) == [3, 2, 0]
    assert route.cheapest(1, 1) == [1]


def test_there_may_be_no_way() -> None:
    route = parse("n 0 0 0 0\nn 1 1 0 0\n", "map")
    assert route.cheapest(0, 1) == []


def test_the_nearest_node() -> None:
    route = parse(SQUARE, "map")
    assert route.nearest(0.9, 0.6) == 2
    assert route.nearest(-3.0, 0.4) == 0
    assert route.nearest(0.5, 0.5) == 0


COSTS = st.lists(
    st.tuples(st.integers(0, 5), st.integers(0, 5), st.integers(1, 9)), max_size=12
)


@given(COSTS, st.integers(0, 5), st.integers(0, 5))
def test_no_way_is_cheaper(
    links: list[tuple[int, int, int]], start: int, end: int
) -> None:
    nodes = "".join(f"n {i} {i} 0 0\n" for i in range(6))
    route = parse(nodes + "".join(f"l {a} {b} {c}\n" for a, b, c in links), "map")

    def cost(way: tuple[int, ...]) -> float:
        return sum(route.links[a].get(b, float("inf")) for a, b in pairwise(way))

    others = [i for i in range(6) if i not in (start, end)]
    ways = [
        (start, *between, end)
        for size in range(len(others) + 1)
        for between in permutations(others, size)
    ]
    best = 0.0 if start == end else min(map(cost, ways))
    found = tuple(route.cheapest(start, end))
    if found:
        assert (found[0], found[-1]) == (start, end)
        assert cost(found) == best
    else:
        assert best == float("inf")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "map:1: no node"),
        ("l 0 1 0\n", "map:1: no node"),
        ("n 0 0 0\n", "map:1: n and 4 finite numbers expected"),
        ("n 0 0 0 nan\n", "map:1: n and 4 finite numbers expected"),
        ("\nn 0.5 0 0 0\n", "map:2: 0.5 is not a number of a node"),
        ("n 0 0 0 0\nn 0 1 0 0\n", "map:2: node 0 is there already"),
        ("n 0 0 0 0\nl 0 1 0\n", "map:2: there is no node 1"),
        ("n 0 0 0 x\n", "map:1: not numbers: 'n 0 0 0 x'"),
        ("k 0 0 0\n", "map:1: 'k' begins no line; known: l, n"),
        ("#\n" * 100_001, "map:100001: more than 100000 lines"),
    ],
)
def test_what_is_no_map(text: str, why: str) -> None:
    with pytest.raises(MapError) as caught:
        parse(text, "map")
    assert str(caught.value) == why


def test_lengths_are_euclidean() -> None:
    route = parse("n 0 0 0 0\nn 1 3 4 0\nl 0 1 0\n", "map")
    assert route.links[1][0] == hypot(3.0, 4.0)
