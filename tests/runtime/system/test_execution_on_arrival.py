"""Components that are executed when samples come, in simulated and in real time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from itertools import pairwise, permutations
from typing import ClassVar

import pytest
from patience import PATIENCE
from runtime_samples import MS, SECOND, Actor, drained, long

from rtgen.runtime import (
    ERROR_STATE,
    INACTIVE_STATE,
    ComponentProfile,
    EndlessFlowError,
    ExecutionKind,
    RealClock,
    ReturnCode_t,
    System,
)

Passed = list[tuple[str, int, int]]
"""Component, time in ms, number of a sample."""


class Relay(Actor):
    """Passes on what comes, as a class with the activity EVENTDRIVEN."""

    profile: ClassVar[ComponentProfile] = ComponentProfile(
        "Relay", rate=10.0, activity="EVENTDRIVEN"
    )

    def __init__(self, name: str, passed: Passed | None = None) -> None:
        super().__init__(name, self.pass_on, inputs=("in",), outputs=("out",))
        self.passed = [] if passed is None else passed

    def pass_on(self) -> None:
        for number in drained(self.inputs["in"]):
            self.passed.append(
                (self.instance_name, self._clock.elapsed() // MS, number)
            )
            self.outputs["out"].write(long(number))


class Source(Actor):
    """Writes a number in each tick, 100 times a second."""

    profile: ClassVar[ComponentProfile] = ComponentProfile("Source", rate=100.0)

    def __init__(self, name: str = "source", count: int = 1) -> None:
        super().__init__(name, self.send, outputs=("out",))
        self.number, self.count = 0, count

    def send(self) -> None:
        for _ in range(self.count):
            self.outputs["out"].write(long(self.number))
            self.number += 1


def chained(system: System, added: tuple[Actor, ...], chain: tuple[Actor, ...]) -> None:
    """Add components in an order, connect and activate them in that of the chain."""
    for component in added:
        system.add(component)
    for first, second in pairwise(chain):
        names = first.instance_name, second.instance_name
        system.connect((names[0], "out"), (names[1], "in"))
    for component in chain:
        system.activate(component.instance_name)


@pytest.mark.parametrize("order", [*permutations(range(4))])
def test_a_chain_passes_a_sample_on_at_its_instant(order: tuple[int, ...]) -> None:
    passed: Passed = []
    chain = (Source(), *(Relay(name, passed) for name in "abc"))
    with System() as system:
        chained(system, tuple(chain[n] for n in order), chain)
        system.run(until_ns=30 * MS)
    # What comes before they are ACTIVE is passed on when they are.
    assert sorted(passed) == [
        (name, 10 * number, number) for name in "abc" for number in range(3)
    ]
    later = [each for each in passed if each[2] > 0]
    assert later == [(name, 10 * n, n) for n in (1, 2) for name in "abc"]


def test_it_is_executed_before_the_next_component_of_the_instant() -> None:
    seen: list[int] = []
    with System() as system:
        reader = Actor("reader", inputs=("in",))
        reader.execute = lambda: seen.extend(drained(reader.inputs["in"]))
        relay, source = Relay("relay"), Source()
        system.add(source)
        system.add(reader, 100.0)
        system.add(relay)
        system.connect(("source", "out"), ("relay", "in"))
        system.connect(("relay", "out"), ("reader", "in"))
        for name in system.instances:
            system.activate(name)
        system.run(until_ns=11 * MS)
    assert seen == [0, 1]


def test_a_run_is_the_same_each_time() -> None:
    runs = []
    for _ in range(2):
        passed: Passed = []
        relays = [Relay(f"r{n}", passed) for n in range(6)]
        with System() as system:
            for component in (Source("s", 2), Source("t"), *relays):
                system.add(component)
            for n, relay in enumerate(relays):
                for source in ("s", "t") if n < 3 else (f"r{n - 3}", f"r{(n + 1) % 3}"):
                    system.connect((source, "out"), (relay.instance_name, "in"))
            for name in system.instances:
                system.activate(name)
            system.run(until_ns=SECOND)
        runs.append(passed)
    assert runs[0] == runs[1]
    assert len(runs[0]) > 1000


def test_one_that_reads_one_sample_at_a_time_is_executed_for_each() -> None:
    class Single(Relay):
        def pass_on(self) -> None:
            sample = self.inputs["in"].read()
            assert sample is not None
            self.passed.append((self.instance_name, 0, sample.data))

    single, source = Single("single"), Source(count=3)
    with System() as system:
        chained(system, (source, single), (source, single))
        system.run(until_ns=20 * MS)
        assert [number for _, _, number in single.passed] == [0, 1, 2, 3, 4, 5]
        assert system.statistics("single").ticks == 6


def test_one_that_reads_nothing_is_executed_once_for_each_tick_of_its_writer() -> None:
    lazy, source = Relay("lazy"), Source(count=3)
    lazy.execute = lambda: None
    with System() as system:
        chained(system, (source, lazy), (source, lazy))
        system.run(until_ns=35 * MS)
        assert system.statistics("lazy").ticks == 4


def test_named_ports_alone_trigger_it() -> None:
    class Fusing(Relay):
        profile: ClassVar[ComponentProfile] = ComponentProfile(
            "Fusing", rate=10.0, activity="EVENTDRIVEN", triggers=("in",)
        )

        def __init__(self) -> None:
            super().__init__("fusing")
            self.aside = self.add_in_port("aside", type(long(0)))

    with System() as system:
        fusing = Fusing()
        for component in (fast := Source("fast"), Source("slow"), fusing):
            system.add(component, 10.0 if component.instance_name == "slow" else None)
        system.connect(("slow", "out"), ("fusing", "in"))
        system.connect(("fast", "out"), ("fusing", "aside"))
        for name in system.instances:
            system.activate(name)
        system.run(until_ns=200 * MS)
        assert [time for _, time, _ in fusing.passed] == [0, 100]
        assert fast.number == 20


def test_samples_that_waited_execute_it_when_it_is_activated() -> None:
    relay, source = Relay("relay"), Source()
    with System() as system:
        system.add(source)
        system.add(relay)
        system.connect(("source", "out"), ("relay", "in"))
        system.activate("source")
        system.run(until_ns=50 * MS)
        assert system.state("relay") is INACTIVE_STATE
        assert relay.passed == []
        system.activate("relay")
        system.run(until_ns=105 * MS)
        times = [time for _, time, _ in relay.passed]
        assert times == [100] * 8  # the buffer's length


def test_a_failure_leads_to_error_and_its_ticks_go_on() -> None:
    errors: list[int] = []

    class Failing(Relay):
        def on_error(self, ec_id: int) -> ReturnCode_t:
            errors.append(self._clock.elapsed() // MS)
            return ReturnCode_t.RTC_OK

        def pass_on(self) -> None:
            raise ValueError("broken")

    failing, source = Failing("failing"), Source()
    with System() as system:
        system.on_failure = lambda failure: None
        chained(system, (source, failing), (source, failing))
        system.run(until_ns=250 * MS)
        assert system.state("failing") is ERROR_STATE
        assert errors == [100, 200]
        assert system.statistics("failing").ticks == 1


@pytest.mark.sampled(0)
def test_a_cycle_without_a_periodic_component_ends_the_run() -> None:
    first, second = Relay("first"), Relay("second")
    with System() as system:
        chained(system, (source := Source(), first, second), (source, first, second))
        system.connect(("second", "out"), ("first", "in"))
        with pytest.raises(EndlessFlowError, match="one component of a cycle"):
            system.run(until_ns=SECOND)
        assert system.time == 0


def test_a_context_of_others_executes_all_of_its_participants() -> None:
    passed: Passed = []
    with System() as system:
        context = system.add_context(10.0, kind=ExecutionKind.EVENT_DRIVEN)
        source = Source()
        system.add(source)
        for name in "ab":
            relay = Relay(name, passed)
            system.add(relay, kind=ExecutionKind.PERIODIC)
            context.add_component(relay)
            context.activate_component(relay)
            system.connect(("source", "out"), (name, "in"))
        context.start()
        system.activate("source")
        system.run(until_ns=20 * MS)
    assert [(name, time) for name, time, _ in passed] == [
        ("a", 0),
        ("b", 0),
        ("a", 10),
        ("b", 10),
    ]


def run_until(system: System, condition: Callable[[], bool]) -> None:
    limit = system.time + int(PATIENCE * SECOND)
    assert system.run(limit, lambda _: condition())


@pytest.mark.parametrize("threads", ["shared", "own"])
def test_a_chain_in_real_time_passes_on_everything(threads: str) -> None:
    passed: Passed = []
    chain = (Source(), *(Relay(name, passed) for name in "abc"))
    with System(RealClock(), threads=threads) as system:
        chained(system, chain[::-1], chain)
        run_until(system, lambda: sum(name == "c" for name, _, _ in passed) >= 10)
    for name in "abc":
        numbers = [number for each, _, number in passed if each == name]
        assert numbers == sorted(set(numbers))
        assert set(range(1, 10)) <= set(numbers)


def test_a_sample_of_another_thread_executes_it() -> None:
    came = threading.Event()
    relay = Relay("relay")
    with System(RealClock()) as system:
        outside = Actor("outside", outputs=("out",))
        system.add(outside)
        system.add(relay, 0.01)
        system.connect(("outside", "out"), ("relay", "in"))
        system.activate("relay")
        run_until(system, lambda: relay.is_active)
        relay.execute = came.set
        outside.outputs["out"].write(long(1))
        assert came.wait(PATIENCE)


def test_its_ticks_in_real_time_have_no_overruns() -> None:
    """A relay of 1 kHz that takes several periods for each sample, beside its source."""
    passed: Passed = []
    relay = Relay("slow", passed)

    def pass_on_slowly() -> None:
        end = relay.now() + 30 * MS
        while relay.now() < end:
            pass
        relay.pass_on()

    relay.execute = pass_on_slowly
    with System(RealClock()) as system:
        system.add(Source(), 100.0)
        system.add(relay, 1000.0)
        system.connect(("source", "out"), ("slow", "in"))
        system.activate("source")
        system.activate("slow")
        run_until(system, lambda: len(passed) >= 10)
        statistics = system.statistics("slow")
    assert statistics.ticks >= 2
    assert (statistics.overruns, statistics.condition) == (0, "")
