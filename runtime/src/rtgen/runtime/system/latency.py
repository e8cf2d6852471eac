"""Latency of samples along chains of connections.

A chain begins with an OutPort of a component that reads nothing, or where samples come from another
process. It ends with an InPort of a component that writes nothing, with an OutPort whose samples
leave the process, or where a cycle is cut, as for the order of ticks. What a component writes is
made of what it has read last. A sample counts once: when something made of it is read at the end.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from heapq import heappop, heappush
from itertools import count, pairwise
from typing import Any

import msgspec

from rtgen.runtime.ports.buffers import RingBuffer
from rtgen.runtime.ports.data_ports import DataConnector, Demand, InPort, OutPort
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.system.flow import in_order_of_flow

MAX_CHAINS = 64
"""Number of chains that are measured, the longest ones."""
_MAX_VALUES = 4096
"""Number of different latencies of a chain that are counted exactly; others are rounded."""
_BITS = 10
"""Precision of those others."""

_BEFORE = -1
"""The step from the first write of a chain to what its component had read, for other chains."""


class _Write(msgspec.Struct, gc=False):
    """The first write of chains: its time [ns], and the origin of what its component had read."""

    time: int
    before: Any = None


_Origin = Any
"""Where a sample comes from: a `_Write`, that of the only input of its component, a tuple of those
of all inputs, or None if it is not known.
"""


class Latency(msgspec.Struct, frozen=True, gc=False):
    """Latencies of the samples of a chain [ns], from the first write to the last read.

    `ports` are those of the chain in order, `late` is the 99th percentile.
    """

    name: str
    ports: tuple[str, ...]
    samples: int
    least: int = 0
    median: int = 0
    late: int = 0
    greatest: int = 0


class Latencies:
    """Measures the chains of the connections that exist when it is made."""

    def __init__(
        self,
        components: Mapping[str, Component],
        connectors: Iterable[Any],
        now: Callable[[], int],
    ) -> None:
        paths = _longest_paths(_hops(components, connectors), MAX_CHAINS)
        inputs: dict[str | None, list[_Hop]] = {}
        measured = dict.fromkeys(hop for path in paths for hop in path)
        for hop in measured:
            hop.is_first = any(path[0] is hop for path in paths)
            hop.inputs = inputs.get(hop.source, []) if hop.source is not None else []
            if not hop.is_cut and hop.target is not None:
                inputs.setdefault(hop.target, []).append(hop)
        self._chains = [_Chain(path) for path in paths]
        ends: dict[_Hop, list[_Chain]] = {}
        for chain, path in zip(self._chains, paths, strict=True):
            ends.setdefault(path[-1], []).append(chain)
        targets: dict[InPort[Any], None] = {}
        for hop in measured:
            _measure(hop, ends.get(hop, []), now)
            if hop.connector is not None:
                targets[hop.connector.target] = None
        for port in targets:
            port._rewire()

    def __iter__(self) -> Iterator[Latency]:
        """Yield the latencies so far, those of the longest chains first."""
        for chain in self._chains:
            yield chain.latency()


class _Chain:
    """`steps` are the places in the origin of a last sample that lead to that of the first."""

    __slots__ = ("counts", "last", "name", "ports", "steps")

    def __init__(self, path: tuple[_Hop, ...]) -> None:
        self.ports = tuple(port for hop in path for port in hop.ports)
        inner = [hop.target or "" for hop in path[:-1]]
        if len(path[-1].ports) == 1:
            inner.pop()  # the port of the same component is the end
        self.name = " > ".join((self.ports[0], *inner, self.ports[-1]))
        steps: list[int] = []
        for before, hop in pairwise(path):
            index = [hop.inputs.index(before)] if len(hop.inputs) > 1 else []
            steps = [*[_BEFORE] * hop.is_first, *index, *steps]
        self.steps = steps
        self.counts: dict[int, int] = {}
        self.last: _Origin = None

    def end(self, origin: _Origin, now: int) -> None:
        """Count the latency of a sample at the end of the chain."""
        for step in self.steps:
            if origin is None:
                return
            origin = origin.before if step == _BEFORE else origin[step]
        if origin is None or origin is self.last:
            return
        self.last = origin
        latency = now - origin.time
        counts = self.counts
        if latency not in counts and len(counts) >= _MAX_VALUES:
            unit = max(latency.bit_length() - _BITS, 0)
            latency = latency >> unit << unit
        counts[latency] = counts.get(latency, 0) + 1

    def latency(self) -> Latency:
        """Return what was counted so far."""
        counts = sorted(self.counts.copy().items())
        samples = sum(number for _, number in counts)
        if not samples:
            return Latency(self.name, self.ports, 0)
        median, late = (_at(counts, int(samples * part)) for part in (0.5, 0.99))
        least, greatest = counts[0][0], counts[-1][0]
        return Latency(self.name, self.ports, samples, least, median, late, greatest)


def _at(counts: Iterable[tuple[int, int]], place: int) -> int:
    value = 0
    for value, number in counts:  # noqa: B007
        place -= number
        if place < 0:
            break
    return value


class _Samples(deque[Any]):
    """The samples of a buffer, with the origin of each; `origin` is that of the last one taken.

    Functions of the object itself, for what is called for each sample, take half of the time of
    methods. `drop` removes the oldest sample, which nobody has read.
    """

    def __init__(self) -> None:
        super().__init__()
        self.origin: _Origin = None
        self._origins: deque[_Origin] = deque()

    def measure(
        self,
        chains: Sequence[_Chain],
        next_origin: Any,
        now: Callable[[], int],
        only: _Samples | None = None,
        begins: bool = False,
    ) -> None:
        """Keep the origins from now on; `chains` end here.

        `only` has the next origin, if it is always that of its last sample; `begins`: all chains
        begin here. Both spare a call for each sample.
        """
        end = _end_of(chains, now) if chains else None
        add, add_origin = super().append, self._origins.append
        take, take_origin = super().popleft, self._origins.popleft

        if only is not None:

            def append(sample: Any) -> None:
                add_origin(only.origin)
                add(sample)

        elif begins:

            def append(sample: Any) -> None:
                add_origin(_Write(now()))
                add(sample)

        else:

            def append(sample: Any) -> None:
                add_origin(next_origin())
                add(sample)

        def drop() -> None:
            take_origin()
            take()

        def popleft() -> Any:
            self.origin = take_origin()
            return take()

        def popleft_last() -> Any:
            assert end is not None
            end(take_origin())
            return take()

        newest, newest_origin = super().pop, self._origins.pop
        empty, empty_origins = super().clear, self._origins.clear

        def pop() -> Any:
            self.origin = newest_origin()
            return newest()

        def pop_last() -> Any:
            assert end is not None
            end(newest_origin())
            return newest()

        def clear() -> None:
            empty()
            empty_origins()

        vars(self).update(append=append, drop=drop, clear=clear)
        if end is None:
            vars(self).update(pop=pop, popleft=popleft)
        else:
            vars(self).update(pop=pop_last, popleft=popleft_last)

    def replace(self, buffer: RingBuffer[Any]) -> None:
        """Become the samples of a buffer."""
        with buffer.guard:
            self.extend(buffer.samples)
            self._origins.extend([None] * len(self))
            buffer.samples = self

    def __delitem__(self, place: Any) -> None:
        del self._origins[place]
        _delete(self, place)


_delete = deque.__delitem__


def _end_of(
    chains: Sequence[_Chain], now: Callable[[], int]
) -> Callable[[_Origin], None]:
    """Return the function that is called with the origin of each sample at the end of chains."""
    last: _Origin = None

    def end(origin: _Origin) -> None:
        nonlocal last
        if origin is not last:
            last, time = origin, now()
            for chain in chains:
                chain.end(origin, time)

    return end


def _measure(hop: _Hop, chains: Sequence[_Chain], now: Callable[[], int]) -> None:
    """Measure the samples of a hop; `chains` end with it."""
    next_origin = _next_origin(hop, now)
    if hop.connector is None:
        end = _end_of(chains, now)

        def leave(_: Any) -> PortStatus:
            end(next_origin())
            return PORT_OK

        hop.out_port.add_outlet(leave, lambda: Demand.NOBODY)
        return
    publisher = hop.connector.publisher
    if publisher is not None:
        waiting = _Samples()
        waiting.measure((), next_origin, now)
        waiting.replace(publisher.waiting)
        next_origin = lambda: waiting.origin  # noqa: E731
    direct = publisher is None and len(hop.inputs) == 1 and not hop.is_first
    only = hop.inputs[0].samples if direct else None
    begins = publisher is None and not hop.inputs
    hop.samples.measure(chains, next_origin, now, only, begins)
    hop.samples.replace(hop.connector.buffer)


def _next_origin(hop: _Hop, now: Callable[[], int]) -> Callable[[], _Origin]:
    """Return a function that returns the origin of the next sample."""
    match [each.samples for each in hop.inputs], hop.is_first:
        case [], _:
            return lambda: _Write(now())
        case [a], True:
            return lambda: _Write(now(), a.origin)
        case [a], _:
            return lambda: a.origin
        case [a, b], True:
            return lambda: _Write(now(), (a.origin, b.origin))
        case inputs, True:
            return lambda: _Write(now(), tuple([each.origin for each in inputs]))
        case inputs, _:
            return lambda: tuple([each.origin for each in inputs])


class _Hop(msgspec.Struct, eq=False):
    """A connection, or the exit from the process (without `connector`).

    `source` and `target` are instances, None in another process. Nothing is made of the samples of
    one that `is_cut`.
    """

    ports: tuple[str, ...]
    source: str | None
    target: str | None
    out_port: OutPort[Any]
    connector: DataConnector[Any] | None
    is_cut: bool = False
    place: int = -1
    """That of the source in the order of the flow."""
    is_first: bool = False
    """Whether a chain begins with it."""
    inputs: list[_Hop] = []
    """Hops of what its component reads."""
    samples: _Samples = msgspec.field(default_factory=_Samples)


def _hops(components: Mapping[str, Component], connectors: Iterable[Any]) -> list[_Hop]:
    """Return the hops of all samples, in the order of the flow."""
    hops = []
    inner = dict.fromkeys(
        each for each in connectors if isinstance(each, DataConnector)
    )
    for component in components.values():
        for in_port in component.in_ports.values():
            inner.update(dict.fromkeys(in_port.connectors))
        for port in component.out_ports.values():
            leaves = [c for c in port.connectors if c.target.owner not in components]
            if leaves or port._outlets:
                hop = _Hop((str(port),), port.owner, None, port, None)
                hops.append(hop)
    for each in inner:
        source, target = each.source, each.target
        if target.owner in components:
            owner = source.owner if source.owner in components else None
            ports = str(source), str(target)
            hops.append(_Hop(ports, owner, target.owner, source, each))
    order = in_order_of_flow([*components], [(w.source, w.target) for w in hops])
    places = {name: place for place, name in enumerate(order)}
    for hop in hops:
        if hop.source is not None:
            hop.place = places[hop.source]
        hop.is_cut = hop.target is not None and places[hop.target] <= hop.place
    return sorted(hops, key=lambda hop: hop.place)


def _longest_paths(hops: Sequence[_Hop], most: int) -> list[tuple[_Hop, ...]]:
    """Return the longest chains, longest first. `hops` are in the order of the flow."""
    writers = {hop.source for hop in hops}
    inputs: dict[str | None, list[_Hop]] = {}
    length: dict[_Hop, int] = {}
    number = count()
    begun: list[tuple[int, int, int, tuple[_Hop, ...], bool]] = []

    def begin(path: tuple[_Hop, ...]) -> None:
        """Add a path to those that go on to the left; that of a cycle is complete as well."""
        first, last, size = path[0], path[-1], len(path)
        # Of equal ones, that which is nearly complete goes on, so that few are begun.
        place = 1 - length[first] - size, -size, next(number)
        heappush(begun, (*place, path, False))
        if last.is_cut and first.source == last.target and before(first):
            heappush(begun, (-size, -size, next(number), path, True))

    def before(hop: _Hop) -> Sequence[_Hop]:
        return inputs.get(hop.source, ()) if hop.source is not None else ()

    for hop in hops:
        length[hop] = 1 + max((length[each] for each in before(hop)), default=0)
        if hop.target is not None and not hop.is_cut:
            inputs.setdefault(hop.target, []).append(hop)
    for hop in hops:
        if hop.is_cut or hop.target is None or hop.target not in writers:
            begin((hop,))
    chains: list[tuple[_Hop, ...]] = []
    while begun and len(chains) < most:
        *_, path, is_complete = heappop(begun)
        if is_complete or not before(path[0]):
            if path[0].connector is not None:
                chains.append(path)
            continue
        for hop in before(path[0]):
            begin((hop, *path))
    return chains
