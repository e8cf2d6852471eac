"""Received data leave a proxy at once, however slow the proxy's context is."""

from __future__ import annotations

import pytest
from proxy_bench import MS, Bench

from rtgen.runtime import RealClock, SampleRecord


@pytest.fixture(params=[0.1, 1.0, 100.0])
def slow(request: pytest.FixtureRequest) -> Bench:
    """Return an ACTIVE proxy in a context of this rate."""
    bench = Bench()
    bench.with_node()
    bench.run(0.05)
    bench.activate()
    bench.system.context("Drive0").set_rate(request.param)
    bench.run(0.02)
    return bench


def arrivals(bench: Bench) -> list[tuple[int, int]]:
    return [(s.time, s.value.data) for s in bench.samples if s.port == "tpdo1"]


def test_it_comes_out_at_the_instant_of_its_arrival(slow: Bench) -> None:
    sent = []
    for value in range(10):
        slow.run(0.0037)
        slow.node.send_position(value)
        sent.append((slow.system.time, value))
    slow.run(0.001)
    assert arrivals(slow) == sent
    assert slow.state == "ACTIVE"


def test_callbacks_and_their_count_are_as_without() -> None:
    with Bench() as bench:
        bench.with_node()
        bench.run(0.05)
        bench.activate()
        before = bench.system.statistics("Drive0").ticks
        for value in range(1000):
            bench.node.send_position(value)
            bench.run(0.0001)
        assert bench.system.statistics("Drive0").ticks - before in (9, 10)
        assert bench.values() == list(range(1000))


def test_nothing_comes_out_of_one_that_is_not_active() -> None:
    with Bench() as bench:
        bench.with_node()
        bench.run(0.05)
        bench.node.send_position(1)
        bench.run(0.05)
        bench.activate()
        bench.node.send_position(2)
        bench.system.deactivate("Drive0")
        bench.run(0.5)
        bench.node.send_position(3)
        bench.run(0.05)
        assert bench.values() == [2]


def test_in_real_time_a_slow_context_is_woken() -> None:
    """The next tick is far away: data that arrive in time did not wait for it."""
    with Bench(RealClock(), settings={"channel": "can0"}) as bench:
        bench.with_node()
        bench.activate()
        bench.system.context("Drive0").set_rate(0.01)
        ticks = bench.system.statistics("Drive0").ticks
        got: list[int] = []
        bench.system.add_listener(
            lambda r: got.append(r.value.data) if isinstance(r, SampleRecord) else None
        )
        for value in range(50):
            bench.node.send_position(value)
        limit = bench.system.time + 20_000 * MS
        assert bench.system.run(limit, until=lambda _: len(got) == 50)
        assert got == list(range(50))
        assert bench.system.statistics("Drive0").ticks <= ticks + 2
        bench.link.close()
