"""Latencies along chains of connections, compared with those that the samples themselves carry."""

from __future__ import annotations

import random
from collections import Counter, defaultdict

import pytest
from seeds import cases

from rtgen.runtime import (
    RTC_OK,
    Component,
    ExecutionKind,
    RealClock,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.runtime.library.rtc import TimedLong
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.system.latency import MAX_CHAINS, Latency

MS = 1_000_000
SECOND = 1000 * MS


class Trail:
    """Where samples come from: for each, its port, its time, and what was read before."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.samples: list[tuple[str, int, dict[tuple[str, str], int]]] = []
        self.reads: dict[str, list[tuple[int, int]]] = defaultdict(list)

    def latencies(self, ports: tuple[str, ...]) -> Counter[int]:
        """Return the latencies of a chain."""
        *before, last_out, last_in = ports
        counted: Counter[int] = Counter()
        last = None
        for number, time in self.reads[last_in]:
            place: int | None = number
            if self.samples[number][0] != last_out:
                continue
            ways = zip(before[-2::-2], before[::-2], strict=True)
            for out_port, in_port in ways:
                place = self.samples[place][2].get((out_port, in_port))
                if place is None:
                    break
            if place is not None and place != last:
                last = place
                counted[time - self.samples[place][1]] += 1
        return counted


class Part(Component):
    """Reads and writes now and then; its samples are numbers of the trail."""

    def __init__(self, name: str, trail: Trail, chooser: random.Random) -> None:
        super().__init__(name)
        self.trail, self.chooser = trail, chooser
        self.inputs = [self.add_in_port(f"in{n}", TimedLong) for n in range(2)]
        self.outputs = [self.add_out_port(f"out{n}", TimedLong) for n in range(2)]
        self.last: dict[tuple[str, str], int] = {}

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        trail, draw = self.trail, self.chooser.random
        for port in self.inputs:
            while port.is_new() and draw() < 0.8:
                sample = port.read_newest() if draw() < 0.2 else port.read()
                assert sample is not None
                source = trail.samples[sample.data][0]
                self.last[source, str(port)] = sample.data
                trail.reads[str(port)].append((sample.data, trail.system.time))
        for out in self.outputs:
            if draw() < 0.8:
                number = len(trail.samples)
                trail.samples.append((str(out), trail.system.time, dict(self.last)))
                out.write(TimedLong(data=number), move=draw() < 0.5)
        return RTC_OK


PROPERTIES = (
    {},
    {"dataport.buffer.length": "1"},
    {"dataport.buffer.length": "2", "dataport.buffer.write.full_policy": "do_nothing"},
    {"dataport.subscription_type": "new"},
    {
        "dataport.subscription_type": "new",
        "dataport.publisher.push_policy": "skip",
        "dataport.publisher.skip_count": "1",
    },
    {
        "dataport.subscription_type": "periodic",
        "dataport.publisher.push_rate": "70",
        "dataport.publisher.push_policy": "new",
    },
    {"dataport.dataflow_type": "pull"},
)


@pytest.mark.random
@pytest.mark.parametrize("seed", cases(60))
def test_they_are_those_that_samples_carry(seed: int) -> None:
    draw = random.Random(seed)
    system = System()
    trail = Trail(system)
    names = [f"p{n}" for n in range(draw.randint(2, 6))]
    for name in names:
        event = draw.random() < 0.2
        kind = ExecutionKind.EVENT_DRIVEN if event else ExecutionKind.PERIODIC
        part = Part(name, trail, draw)
        system.add(part, draw.choice((10, 20, 30, 50, 100)), kind=kind)
    pairs = {
        (draw.choice(names), draw.randrange(2), draw.choice(names), draw.randrange(2))
        for _ in range(draw.randint(1, 8))
    }
    for source, out, target, in_ in sorted(pairs):
        if names.index(source) < names.index(target) or draw.random() < 0.3:
            ends = (source, f"out{out}"), (target, f"in{in_}")
            system.connect(*ends, draw.choice(PROPERTIES))
    for name in names:
        system.activate(name)
    system.measure_latencies()
    system.run(until_ns=2 * SECOND)
    for chain in system.latencies:
        assert chain.samples == trail.latencies(chain.ports).total(), chain
        if chain.samples:
            values = sorted(trail.latencies(chain.ports).elements())
            found = chain.least, chain.median, chain.late, chain.greatest
            places = 0, len(values) // 2, int(len(values) * 0.99), -1
            assert found == tuple(values[place] for place in places)


class Relay(Component):
    """Passes on what it reads; without an InPort that is connected it writes at each tick."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.input = self.add_in_port("in", TimedLong)
        self.other = self.add_in_port("other", TimedLong)
        self.output = self.add_out_port("out", TimedLong)

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        for port in (self.input, self.other):
            while port.is_new():
                port.read()
        if self.input.last is not None or not self.input.connectors:
            self.output.write(TimedLong())
        return RTC_OK


def chain(system: System, *rates: float) -> None:
    """Add a chain of relays."""
    for number, rate in enumerate(rates):
        system.add(Relay(f"r{number}"), rate)
    for number in range(1, len(rates)):
        system.connect((f"r{number - 1}", "out"), (f"r{number}", "in"))
    for name in system.instances:
        system.activate(name)


def test_of_a_chain_in_simulated_time() -> None:
    system = System()
    chain(system, 100, 10, 40)
    system.measure_latencies()
    system.run(until_ns=SECOND)
    [latency] = system.latencies
    assert latency.name == "r0.out > r1 > r2.in"
    assert latency.ports == ("r0.out", "r1.in", "r1.out", "r2.in")
    assert latency.samples == 10
    # The relay reads what was written at the same instant; its reader is then up to 25 ms later.
    assert (latency.least, latency.greatest) == (0, 0)


def test_a_cycle_ends_where_it_is_cut() -> None:
    system = System()
    chain(system, 100, 100, 100)
    system.connect(("r2", "out"), ("r0", "other"))
    system.measure_latencies()
    system.run(until_ns=SECOND)
    [latency] = system.latencies
    assert latency.name == "r0.out > r1 > r2 > r0.other"
    assert (latency.samples, latency.median) == (99, 10 * MS)


def test_longest_chains_first_and_a_limited_number() -> None:
    system = System()
    for number in range(40):
        system.add(Relay(f"r{number}"), 10)
    for number in range(1, 40):
        for port in ("in", "other"):
            system.connect((f"r{number - 1}", "out"), (f"r{number}", port))
    for name in system.instances:
        system.activate(name)
    system.measure_latencies()
    system.run(until_ns=SECOND)
    found = system.latencies
    assert len(found) == MAX_CHAINS
    assert {len(each.ports) for each in found} == {2 * 39}
    assert all(each.samples == 10 for each in found)


def test_samples_that_leave_the_process_end_chains() -> None:
    def leave(_: object) -> PortStatus:
        return PORT_OK

    system = System()
    chain(system, 100, 50)
    system.component("r1").out_ports["out"].add_outlet(leave)
    system.component("r0").out_ports["out"].add_outlet(leave)
    system.measure_latencies()
    system.run(until_ns=SECOND)
    assert [(each.name, each.samples) for each in system.latencies] == [
        ("r0.out > r1.out", 50)
    ]


def test_nothing_is_measured_unless_asked_for() -> None:
    system = System()
    chain(system, 100, 100)
    system.run(until_ns=SECOND)
    assert system.latencies == ()


def test_many_different_latencies_take_bounded_memory() -> None:
    clock = SimulatedClock()
    system = System(clock)
    chain(system, 100, 100)
    system.measure_latencies()
    writer = system.component("r0").out_ports["out"]
    reader = system.component("r1").in_ports["in"]
    [counted] = system._latencies._chains  # type: ignore[attr-defined]
    for number in range(20_000):
        writer.write(TimedLong())
        clock.time += 1_000_003 + 1009 * number
        reader.read()
    [latency] = system.latencies
    assert len(counted.counts) < 8000
    assert latency.samples == 20_000
    assert latency.median == pytest.approx(11_090_000, rel=0.01)


@pytest.mark.parametrize("threads", ["shared", "own"])
def test_of_a_chain_in_real_time(threads: str) -> None:
    with System(RealClock(), threads=threads) as system:
        chain(system, 200, 200, 200)
        system.measure_latencies()

        def is_measured(_: System) -> bool:
            return system.latencies[0].samples >= 5

        assert system.run(20 * SECOND, is_measured)
        [latency] = system.latencies
    assert 0 < latency.least <= latency.median <= latency.late <= latency.greatest
    assert latency.greatest < 20 * SECOND


def test_a_latency_without_samples() -> None:
    system = System()
    chain(system, 100, 100)
    system.measure_latencies()
    assert system.latencies == (Latency("r0.out > r1.in", ("r0.out", "r1.in"), 0),)
