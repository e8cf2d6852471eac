"""Components of one rate tick in the order of the flow of their data."""

from __future__ import annotations

from itertools import pairwise, permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from patience import PATIENCE
from runtime_samples import MS, SECOND, Actor, activated, drained, long

from rtgen.runtime import RealClock, System
from rtgen.runtime.system.flow import in_order_of_flow


@pytest.mark.parametrize("order", [*permutations("abcd")])
def test_a_chain_has_one_order(order: tuple[str, ...]) -> None:
    assert in_order_of_flow(order, pairwise("abcd")) == [*"abcd"]


@pytest.mark.parametrize(
    ("items", "flow", "ordered"),
    [
        ("abc", "", "abc"),
        ("abc", "ab bc ca", "abc"),
        ("cba", "ab bc ca", "cab"),
        ("cba", "cb ba", "cba"),
        ("xba", "ab", "xab"),
        ("ab", "aa ab ba", "ab"),
        ("dcba", "ab bc cb cd", "cdab"),
        ("ab", "ax xb", "ab"),
    ],
)
def test_cycles_begin_with_the_first(items: str, flow: str, ordered: str) -> None:
    pairs = [(pair[0], pair[1]) for pair in flow.split()]
    assert "".join(in_order_of_flow(items, pairs)) == ordered


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=30))
def test_every_item_is_there_once_and_flows_without_cycles_are_kept(
    flow: list[tuple[int, int]],
) -> None:
    ordered = in_order_of_flow(range(10), flow)
    assert sorted(ordered) == [*range(10)]
    forward = [(a, b) if a < b else (b, a) for a, b in flow if a != b]
    shuffled = sorted(range(10), key=lambda n: -n)
    place = {n: i for i, n in enumerate(in_order_of_flow(shuffled, forward))}
    assert all(place[a] < place[b] for a, b in forward)


def test_a_long_ring_is_ordered() -> None:
    items = range(3000)
    ring = [(n, (n + 1) % 3000) for n in items]
    assert in_order_of_flow(items, ring) == [*items]


def relays(count: int) -> list[Actor]:
    """Return components that write the highest number that they have read, plus one."""
    made = []
    for number in range(count):
        relay = Actor(f"r{number}", inputs=("in",), outputs=("out",))

        def pass_on(relay: Actor = relay, is_first: bool = number == 0) -> None:
            read = [0] if is_first else drained(relay.inputs["in"])
            for each in read:
                relay.outputs["out"].write(long(each + 1))

        relay.execute = pass_on
        made.append(relay)
    return made


@pytest.mark.parametrize("order", [*permutations(range(4))])
def test_a_chain_of_one_rate_takes_no_tick(order: tuple[int, ...]) -> None:
    chain = relays(4)
    end = Actor("end", inputs=("in",))
    got: list[tuple[int, int]] = []
    end.execute = lambda: got.extend(
        (system.time // MS, each) for each in drained(end.inputs["in"])
    )
    with System() as system:
        activated(system, end, *(chain[n] for n in order))
        for first, second in pairwise([*chain, end]):
            ends = first.instance_name, second.instance_name
            system.connect((ends[0], "out"), (ends[1], "in"))
        system.run(until_ns=3 * MS)
    assert got == [(0, 4), (1, 4), (2, 4)]


def test_other_rates_and_places_stay_as_they_were() -> None:
    seen: list[str] = []
    with System() as system:
        for name, rate in (("c", 1000.0), ("x", 500.0), ("b", 1000.0), ("a", 1000.0)):
            actor = Actor(
                name,
                lambda n=name: seen.append(n),
                inputs=("in",),
                outputs=("out",),
            )
            activated(system, actor, rate_hz=rate)
        system.connect(("a", "out"), ("b", "in"))
        system.connect(("a", "out"), ("x", "in"))
        system.connect(("b", "out"), ("c", "in"))
        system.run(until_ns=MS)
    assert seen == ["a", "x", "b", "c"]


@pytest.mark.parametrize("pieces", [1, 2, 3])
def test_a_connection_made_later_leaves_the_order(pieces: int) -> None:
    seen: list[str] = []
    with System() as system:
        for name in ("b", "a"):
            actor = Actor(
                name,
                lambda n=name: seen.append(n),
                inputs=("in",),
                outputs=("out",),
            )
            activated(system, actor, rate_hz=1000.0)
        system.at(MS, lambda: system.connect(("a", "out"), ("b", "in")))
        for piece in range(1, pieces + 1):
            system.run(until_ns=6 * MS * piece // pieces)
    assert seen == ["b", "a"] * 6


def test_connections_that_are_elsewhere_count() -> None:
    seen: list[str] = []
    with System() as system:
        for name in ("c", "b", "a"):
            activated(
                system, Actor(name, lambda n=name: seen.append(n)), rate_hz=1000.0
            )
        system.follow([("a", "b"), ("b", "c"), ("a", "x")])
        system.run(until_ns=MS)
    assert seen == ["a", "b", "c"]


def test_real_time_has_the_same_order() -> None:
    seen: list[str] = []
    with System(RealClock()) as system:
        for name in ("c", "b", "a"):
            actor = Actor(
                name,
                lambda n=name: seen.append(n),
                inputs=("in",),
                outputs=("out",),
            )
            activated(system, actor, rate_hz=100.0)
        system.connect(("a", "out"), ("b", "in"))
        system.connect(("b", "out"), ("c", "in"))
        limit = int(PATIENCE * SECOND)
        assert system.run(limit, lambda _: len(seen) >= 9)
    text = "".join(seen)
    assert "abcabc" in text
