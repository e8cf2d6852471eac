"""Subscription types and push policies in simulated time."""

from __future__ import annotations

from itertools import chain

import pytest
from runtime_samples import MS, Actor, activated, drained, joined, long

from rtgen.runtime import PORT_OK, DataConnector, PortStatus, System

NEW = {"dataport.subscription_type": "new"}
LENGTH = "dataport.buffer.length"


def periodic(rate: float, **more: str) -> dict[str, str]:
    properties = {
        "dataport.subscription_type": "periodic",
        "dataport.publisher.push_rate": str(rate),
    }
    return properties | {
        f"dataport.publisher.{key}": text for key, text in more.items()
    }


def writing_system(
    properties: dict[str, str], per_tick: int, rate_hz: float = 1000.0
) -> tuple[System, list[list[int]], Actor]:
    """Return a writer of `per_tick` samples each ms, and a reader's samples by its ticks.

    The reader comes first in the order of equal instants: it is the first of a cycle of data.
    """
    got: list[list[int]] = []
    reader = Actor("reader", inputs=("in",), outputs=("back",))
    reader.execute = lambda: got.append(drained(reader.inputs["in"]))
    writer = Actor("writer", inputs=("back",), outputs=("out",))
    count = iter(range(1000))

    def write() -> None:
        for _ in range(per_tick):
            writer.outputs["out"].write(long(next(count)))

    writer.execute = write
    system = activated(System(), reader, writer, rate_hz=rate_hz)
    system.connect(("writer", "out"), ("reader", "in"), properties, "c")
    system.connect(("reader", "back"), ("writer", "back"))
    return system, got, writer


def lost(system: System) -> tuple[int, int]:
    connector = system.connector("c")
    assert isinstance(connector, DataConnector)
    return connector.lost, connector.dropped


def test_flush_delivers_inside_write() -> None:
    _, out, port = joined({"dataport.subscription_type": "flush"})
    out.write(long(1))
    assert port.is_new()


def test_new_delivers_at_the_end_of_the_writers_tick() -> None:
    system, out, port = joined(NEW)
    seen_in_tick: list[bool] = []
    writer = system.component("writer")
    assert isinstance(writer, Actor)

    def write() -> None:
        out.write(long(1))
        seen_in_tick.append(port.is_new())

    writer.execute = write
    system.run(until_ns=1)
    assert seen_in_tick == [False]
    assert drained(port) == [1]


@pytest.mark.parametrize(
    ("policy", "expected", "dropped"),
    [
        ("all", [[], [0, 1, 2], [3, 4, 5], [6, 7, 8]], 0),
        ("new", [[], [2], [5], [8]], 8),
        ("fifo", [[], [0], [1], [2]], 0),
        ("skip", [[], [1], [3, 5], [7]], 6),
    ],
)
def test_new_by_push_policy(
    policy: str, expected: list[list[int]], dropped: int
) -> None:
    properties = {"dataport.publisher.push_policy": policy, LENGTH: "100"}
    if policy == "skip":
        properties["dataport.publisher.skip_count"] = "1"
    system, got, _ = writing_system(NEW | properties, per_tick=3)
    system.run(until_ns=4 * MS)
    assert got == expected
    assert lost(system) == (dropped, dropped)


def test_fifo_goes_on_delivering_after_the_last_write() -> None:
    properties = NEW | {"dataport.publisher.push_policy": "fifo"}
    system, got, writer = writing_system(properties, per_tick=3)
    system.run(until_ns=1)
    writer.execute = None
    system.run(until_ns=6 * MS)
    assert got == [[], [0], [1], [2], [], []]


def test_the_writers_buffer_overwrites_while_it_waits() -> None:
    properties = NEW | {"dataport.publisher.push_policy": "all"}
    properties["dataport.outport.buffer.length"] = "2"
    system, got, _ = writing_system(properties, per_tick=3)
    system.run(until_ns=2 * MS)
    assert got == [[], [1, 2]]
    assert lost(system) == (2, 0)


def test_what_the_readers_buffer_refuses_is_offered_again() -> None:
    properties = NEW | {"dataport.publisher.push_policy": "all"}
    properties["dataport.inport.buffer.length"] = "1"
    properties["dataport.inport.buffer.write.full_policy"] = "do_nothing"
    system, got, writer = writing_system(properties, per_tick=3)
    system.run(until_ns=1)
    writer.execute = None
    system.run(until_ns=6 * MS)
    assert got == [[], [0], [1], [2], [], []]
    assert lost(system) == (0, 0)


def test_a_refused_write_of_a_new_connection_is_counted_and_told() -> None:
    properties = NEW | {"dataport.buffer.write.full_policy": "do_nothing", LENGTH: "1"}
    system, out, port = joined(properties)
    assert out.write(long(1)) is PORT_OK
    assert out.write(long(2)) is PortStatus.BUFFER_FULL
    system.run(until_ns=1)
    assert drained(port) == [1]
    assert lost(system) == (1, 0)


@pytest.mark.parametrize(
    ("policy", "expected"),
    [("all", [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]), ("new", [4, 9]), ("fifo", [0, 1])],
)
def test_periodic_delivers_at_its_rate(policy: str, expected: list[int]) -> None:
    properties = periodic(200.0, push_policy=policy) | {LENGTH: "100"}
    system, got, _ = writing_system(properties, per_tick=1)
    system.run(until_ns=11 * MS)
    when = [tick for tick, values in enumerate(got) if values]
    assert when == [5, 10]
    assert [*chain(*got)] == expected


def test_periodic_skips_samples() -> None:
    properties = periodic(100.0, push_policy="skip", skip_count="2") | {LENGTH: "100"}
    system, got, _ = writing_system(properties, per_tick=1)
    system.run(until_ns=21 * MS)
    assert [*chain(*got)] == [2, 5, 8, 11, 14, 17]


def test_a_cut_counts_what_waits_at_both_ends_and_ends_deliveries() -> None:
    properties = periodic(100.0, push_policy="all")
    system, out, port = joined(properties)
    for n in range(3):
        out.write(long(n))
    system.run(until_ns=11 * MS)
    out.write(long(3))
    system.disconnect("c")
    assert port.lost == 4
    system.run(until_ns=50 * MS)
    assert not port.is_new()


def test_a_cut_counts_the_sample_that_was_refused_too() -> None:
    properties = NEW | {"dataport.publisher.push_policy": "all"}
    properties["dataport.inport.buffer.length"] = "1"
    properties["dataport.inport.buffer.write.full_policy"] = "do_nothing"
    system, out, port = joined(properties)
    for n in range(3):
        out.write(long(n))
    system.run(until_ns=1)
    system.disconnect("c")
    assert port.lost == 3
    system.run(until_ns=2 * MS)
    assert not system.component("writer")._deferred_calls


def test_the_newest_replaces_the_one_that_was_refused() -> None:
    properties = dict(NEW)
    properties["dataport.inport.buffer.length"] = "1"
    properties["dataport.inport.buffer.write.full_policy"] = "do_nothing"
    system, out, port = joined(properties)
    for n in range(4):
        out.write(long(n))
        system.run(until_ns=system.time + MS)
    assert drained(port) == [0]
    system.run(until_ns=system.time + MS)
    assert drained(port) == [3]
    assert lost(system) == (2, 2)
