"""Groups, cycles and paths in random graphs, compared with searches from each node."""

from __future__ import annotations

from random import Random

from rtgen.compiler.model.graphs import groups, in_circles, leading_to


def reached(edges: dict[int, set[int]], start: int) -> set[int]:
    found: set[int] = set()
    waiting = list(edges.get(start, ()))
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting += edges.get(node, ())
    return found


def test_graphs() -> None:
    chance = Random(14)
    for _ in range(300):
        count = chance.randrange(1, 12)
        edges = {
            node: {
                chance.randrange(count + 1) for _ in range(chance.choice([0, 1, 1, 2]))
            }
            for node in range(count)
        }
        ways = {node: reached(edges, node) for node in range(count + 1)}
        made = list(groups(edges))
        assert sorted(node for group in made for node in group) == list(edges)
        seen: set[int] = {count}
        for group in made:
            for node in group:
                together = {n for n in ways[node] if node in ways[n]} | {node}
                assert together == set(group)
            seen |= set(group)
            assert all(ways[node] <= seen for node in group)
        assert set(in_circles(edges)) == {n for n in edges if n in ways[n]}
        wanted = {chance.randrange(count + 1)}
        users = {n for n in edges if not ways[n].isdisjoint(wanted)}
        assert leading_to(edges, wanted) == users | wanted


def test_a_long_chain_needs_no_recursion() -> None:
    edges = {node: {node + 1} for node in range(100_000)}
    assert len(list(groups(edges))) == len(edges)
