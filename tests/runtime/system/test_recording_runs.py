"""Listeners and the JSON lines recorder: records, their order, and repeatability."""

from __future__ import annotations

import io
import json
import math
from dataclasses import dataclass, field
from decimal import Decimal
from enum import IntEnum
from typing import Any

import pytest
from runtime_samples import MS, Actor, activated, drained, long

from rtgen.runtime import (
    ACTIVE_STATE,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    JsonLinesRecorder,
    Record,
    ReturnCode_t,
    SampleRecord,
    StateRecord,
    System,
)
from rtgen.runtime.system.json_printers import plain


class Colour(IntEnum):
    RED = 0


@dataclass(slots=True)
class Everything:
    number: float = math.nan
    big: int = 2**40
    flag: bool = True
    text: str = "é"
    octets: bytes = b"\x00\xff"
    colour: Colour = Colour.RED
    money: Decimal = Decimal("1.50")
    items: list[float] = field(default_factory=lambda: [1.0, math.inf])


class Union:
    discriminator = Colour.RED
    value = 5


def test_values_become_plain() -> None:
    assert plain(Everything()) == {
        "number": "nan",
        "big": 2**40,
        "flag": True,
        "text": "é",
        "octets": [0, 255],
        "colour": "RED",
        "money": "1.50",
        "items": [1.0, "inf"],
    }
    assert plain(Union()) == {"discriminator": "RED", "value": 5}
    assert plain({"a": 1}) == [["a", 1]]
    assert plain(None) is None


def pipeline(system: System) -> None:
    """A counter, a relay and a sink at three rates; the relay breaks at 10."""
    counter, relay = Actor("counter", outputs=("out",)), Actor(
        "relay", inputs=("in",), outputs=("out",)
    )
    sink = Actor("sink", inputs=("in",))
    count = iter(range(1000))

    def pass_on() -> ReturnCode_t | None:
        for value in drained(relay.inputs["in"]):
            if value == 10:
                return relay.fail("ten")
            sample = long(value * 2)
            relay.stamp(sample)
            relay.outputs["out"].write(sample)
        return None

    def write() -> None:
        counter.outputs["out"].write(long(next(count)))

    counter.execute, relay.execute = write, pass_on
    for component, rate in ((counter, 1000.0), (relay, 300.0), (sink, 50.0)):
        activated(system, component, rate_hz=rate)
    system.connect(
        ("counter", "out"),
        ("relay", "in"),
        {"dataport.io_mode": "nonblock", "dataport.publisher.push_policy": "all"},
    )
    system.connect(("relay", "out"), ("sink", "in"))


def log_of_a_run() -> str:
    stream = io.StringIO()
    system = System()
    system.add_listener(JsonLinesRecorder(stream))
    pipeline(system)
    system.at(20 * MS, lambda: system.reset("relay") and None)
    system.run(until_ns=30 * MS)
    system.close()
    return stream.getvalue()


def test_two_runs_give_the_same_bytes() -> None:
    first = log_of_a_run()
    assert first == log_of_a_run()
    lines = [json.loads(line) for line in first.splitlines()]
    assert lines[0] == {
        "t": 0,
        "event": "state",
        "instance": "counter",
        "from": "CREATED_STATE",
        "to": "INACTIVE_STATE",
        "context": 0,
    }
    assert {"sample", "state"} == {line["event"] for line in lines}
    broken = [line for line in lines if line.get("to") == "ERROR_STATE"]
    assert broken == [
        {
            "t": 13333332,
            "event": "state",
            "instance": "relay",
            "from": "ACTIVE_STATE",
            "to": "ERROR_STATE",
            "context": 0,
            "reason": "ten",
        }
    ]
    samples = [
        line
        for line in lines
        if line["event"] == "sample" and line["instance"] == "relay"
    ]
    assert samples[1] == {
        "t": 3333333,
        "event": "sample",
        "instance": "relay",
        "port": "out",
        "value": {"tm": {"sec": 0, "nsec": 3333333}, "data": 2},
    }
    assert [line["t"] for line in lines] == sorted(line["t"] for line in lines)


def test_listeners_get_snapshots_and_can_leave() -> None:
    records: list[Record] = []
    system = System()
    writer = Actor("writer", outputs=("out",))
    system.add_listener(records.append)
    activated(system, writer)
    sample = long(1)
    writer.outputs["out"].write(sample)
    sample.data = 2
    system.run(until_ns=1)
    assert records == [
        StateRecord("state", 0, "writer", CREATED_STATE, INACTIVE_STATE, 0, ""),
        SampleRecord("sample", 0, "writer", "out", long(1)),
        StateRecord("state", 0, "writer", INACTIVE_STATE, ACTIVE_STATE, 0, ""),
    ]
    system.remove_listener(print)
    system.remove_listener(records.append)
    system.activate("writer")
    system.run(until_ns=5 * MS)


def test_a_listener_that_comes_late_sees_the_rest() -> None:
    records: list[Any] = []
    system = System()
    writer = Actor("writer", outputs=("out",))
    activated(system, writer)

    def listen(record: Record) -> None:
        records.append(record)

    system.run(until_ns=MS)
    system.add_listener(listen)
    writer.execute = lambda: writer.fail("enough")
    system.run(until_ns=2 * MS)
    writer.outputs["out"].write(long(1))
    system.remove_listener(listen)
    writer.outputs["out"].write(long(2))
    system.reset("writer")
    system.run(until_ns=4 * MS)
    assert records == [
        StateRecord("state", MS, "writer", ACTIVE_STATE, ERROR_STATE, 0, "enough"),
        SampleRecord("sample", 2 * MS, "writer", "out", long(1)),
    ]


@pytest.mark.parametrize("listening", [False, True])
def test_a_record_changes_nothing_of_what_arrives(listening: bool) -> None:
    system = System()
    if listening:
        system.add_listener(lambda record: None)
    pipeline(system)
    system.run(until_ns=12 * MS)
    sink = system.component("sink")
    assert drained(sink.in_ports["in"]) == [2, 4, 6, 8, 10, 12, 14, 16, 18][-8:]
