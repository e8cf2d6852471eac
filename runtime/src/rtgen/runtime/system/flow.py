"""The order of components along the flow of their data."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import Any, TypeVar

import msgspec

from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.system.scheduling import Scheduler

T = TypeVar("T", bound=Hashable)


class Flow(msgspec.Struct, eq=False):
    """The order of the contexts of a system; both mappings may change later."""

    _participants: Mapping[str, Participant]
    _connectors: Mapping[str, Any]
    further: list[tuple[str, str]] = msgspec.field(default_factory=list)
    """Connections that count although they are not here: the instances of their ends."""
    is_fixed: bool = False

    def fix(self, scheduler: Scheduler) -> None:
        """Let periodic contexts of equal rate tick in the order of the flow of their data.

        Connections that are made later do not count: what a run does must not depend on where
        calls of `run` divide it.
        """
        if self.is_fixed:
            return
        self.is_fixed = True
        orders = scheduler.orders
        contexts = {name: each.context for name, each in self._participants.items()}
        groups: dict[int, list[ExecutionContext]] = {}
        for context in sorted(orders, key=orders.__getitem__):
            if context.owner is not None and not context.is_event_driven:
                groups.setdefault(context.period, []).append(context)
        flow = [
            (contexts.get(each.source.owner), contexts.get(each.target.owner))
            for each in tuple(self._connectors.values())
            if isinstance(each, DataConnector)
        ]
        flow += [(contexts.get(a), contexts.get(b)) for a, b in self.further]
        for group in groups.values():
            places = sorted(orders[context] for context in group)
            ordered = in_order_of_flow(group, flow)
            if ordered != group:
                scheduler.reorder(dict(zip(ordered, places, strict=True)))


def in_order_of_flow(items: Sequence[T], flow: Iterable[tuple[Any, Any]]) -> list[T]:
    """Return the items, each after those that its data come from; else they keep their order.

    Of a cycle, the first item comes first: what flows back to it is not considered.
    """
    place = {item: number for number, item in enumerate(items)}
    sources: dict[T, set[T]] = {item: set() for item in items}
    for source, target in flow:
        if source in place and target in place and source != target:
            sources[target].add(source)
    waiting = [group for group in _cycles(items, sources) if len(group) > 1]
    while waiting:
        group = waiting.pop()
        first = min(group, key=place.__getitem__)
        sources[first] -= group
        inside = {item: sources[item] & group for item in group}
        waiting += [
            each
            for each in _cycles(sorted(group, key=place.__getitem__), inside)
            if len(each) > 1
        ]
    return _sorted(items, place, sources)


def _sorted(
    items: Sequence[T], place: Mapping[T, int], sources: Mapping[T, set[T]]
) -> list[T]:
    targets: dict[T, list[T]] = {item: [] for item in items}
    for target, its in sources.items():
        for source in its:
            targets[source].append(target)
    left = {item: len(its) for item, its in sources.items()}
    ready = [place[item] for item, number in left.items() if not number]
    heapify(ready)
    ordered = []
    while ready:
        item = items[heappop(ready)]
        ordered.append(item)
        for target in targets[item]:
            left[target] -= 1
            if not left[target]:
                heappush(ready, place[target])
    return ordered


def _cycles(items: Sequence[T], sources: Mapping[T, set[T]]) -> list[set[T]]:
    """Return the strongly connected components (Tarjan 1972), without recursion."""
    number: dict[T, int] = {}
    lowest: dict[T, int] = {}
    path: list[T] = []
    on_path: set[T] = set()
    found: list[set[T]] = []
    for root in items:
        if root in number:
            continue
        work = [(root, iter(sources[root]))]
        number[root] = lowest[root] = len(number)
        path.append(root)
        on_path.add(root)
        while work:
            item, rest = work[-1]
            following = next(rest, None)
            if following is None:
                work.pop()
                if work:
                    above = work[-1][0]
                    lowest[above] = min(lowest[above], lowest[item])
                if lowest[item] == number[item]:
                    group: set[T] = set()
                    while item not in group:
                        group.add(path[-1])
                        on_path.discard(path.pop())
                    found.append(group)
            elif following not in number:
                number[following] = lowest[following] = len(number)
                path.append(following)
                on_path.add(following)
                work.append((following, iter(sources[following])))
            elif following in on_path:
                lowest[item] = min(lowest[item], number[following])
    return found
