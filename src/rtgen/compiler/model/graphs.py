"""Graph algorithms in linear time: strongly connected components, cycles, reachability."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from typing import TypeVar

Node = TypeVar("Node", bound=Hashable)


def groups(edges: Mapping[Node, Collection[Node]]) -> Iterator[list[Node]]:
    """Yield the strongly connected components, each after those it refers to.

    A node outside of cycles is a group of one. Tarjan's algorithm, without recursion; targets that
    are not keys of `edges` are ignored.
    """
    order: dict[Node, int] = {}
    lowest: dict[Node, int] = {}
    open_: dict[Node, None] = {}
    for start in edges:
        if start in order:
            continue
        work = [(start, iter(edges[start]))]
        order[start] = lowest[start] = len(order)
        open_[start] = None
        while work:
            node, following = work[-1]
            for other in following:
                if other not in edges:
                    continue
                if other not in order:
                    order[other] = lowest[other] = len(order)
                    open_[other] = None
                    work.append((other, iter(edges[other])))
                    break
                if other in open_:
                    lowest[node] = min(lowest[node], order[other])
            else:
                work.pop()
                if work:
                    above = work[-1][0]
                    lowest[above] = min(lowest[above], lowest[node])
                if lowest[node] == order[node]:
                    group: list[Node] = []
                    while not group or group[-1] != node:
                        group.append(open_.popitem()[0])
                    yield group[::-1]


def in_circles(edges: Mapping[Node, Collection[Node]]) -> Iterator[Node]:
    """Yield the nodes on a cycle."""
    leading = {node: others for node, others in edges.items() if others}
    for group in groups(leading):
        if len(group) > 1 or group[0] in edges[group[0]]:
            yield from group


def leading_to(
    edges: Mapping[Node, Iterable[Node]], targets: Collection[Node]
) -> set[Node]:
    """Return the wanted nodes, and all nodes from which one of them is reachable."""
    users: dict[Node, list[Node]] = {}
    for node, others in edges.items():
        for other in others:
            users.setdefault(other, []).append(node)
    return reached(targets, lambda node: users.get(node, ()))


def reached(
    start: Iterable[Node], following: Callable[[Node], Iterable[Node]]
) -> set[Node]:
    """Return nodes, and all that are reachable from them."""
    nodes: set[Node] = set()
    waiting = list(start)
    while waiting:
        node = waiting.pop()
        if node not in nodes:
            nodes.add(node)
            waiting += following(node)
    return nodes
