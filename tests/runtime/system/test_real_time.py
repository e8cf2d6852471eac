"""Real time: threads, overruns, waiting. Nothing here measures durations."""

from __future__ import annotations

import logging
import re
import threading
import time
from collections.abc import Callable, Iterator

import pytest
from patience import PATIENCE
from runtime_samples import (
    MS,
    SECOND,
    Actor,
    activated,
    drained,
    joined,
    long,
    placeless,
)

from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PORT_OK,
    RTC_OK,
    DataConnector,
    PortStatus,
    RealClock,
    ReturnCode_t,
    StateRecord,
    System,
    requests,
)
from rtgen.runtime.system.real_time import next_instant

FULL = "dataport.buffer.write.full_policy"
EMPTY = "dataport.buffer.read.empty_policy"
LENGTH = "dataport.buffer.length"


@pytest.fixture
def system() -> Iterator[System]:
    system = System(RealClock())
    yield system
    system.close()


def run_until(system: System, condition: Callable[[], bool]) -> None:
    limit = system.time + int(PATIENCE * SECOND)
    assert system.run(limit, lambda _: condition())


class Thread(threading.Thread):
    """A thread that stores the result of its function."""

    def __init__(self, function: Callable[[], object]) -> None:
        super().__init__(daemon=True)
        self._function = function
        self.result: object = "still running"
        self.start()

    def run(self) -> None:
        self.result = self._function()

    def outcome(self) -> object:
        self.join(PATIENCE)
        return self.result


@pytest.mark.parametrize(
    ("now", "due", "overruns"),
    [
        (1000, 1100, 0),
        (1099, 1100, 0),
        (1100, 1100, 0),
        (1101, 1100, 1),
        (1199, 1100, 1),
        (1200, 1200, 2),
        (1555, 1500, 5),
    ],
)
def test_instants_stay_on_the_grid(now: int, due: int, overruns: int) -> None:
    assert next_instant(1000, 100, now) == (due, overruns)


@pytest.mark.parametrize("asked", ["shared", "own"])
def test_components_tick_in_one_thread_or_in_threads_of_their_own(asked: str) -> None:
    system = System(RealClock(), threads=asked)
    threads: dict[str, set[str]] = {"a": set(), "b": set()}

    def actor(name: str) -> Actor:
        return Actor(name, lambda: threads[name].add(threading.current_thread().name))

    activated(system, actor("a"), actor("b"))
    run_until(system, lambda: min(system.statistics(n).ticks for n in threads) >= 3)
    of_each = {name: {f"rtgen {name}"} for name in threads}
    assert threads == (
        of_each if asked == "own" else {n: {"rtgen ticks"} for n in "ab"}
    )
    system.close()
    assert not [t for t in threading.enumerate() if t.name.startswith("rtgen ")]


def test_nothing_ticks_before_the_first_run(system: System) -> None:
    ticked = threading.Event()
    activated(system, Actor("a", ticked.set))
    assert not ticked.is_set()
    assert not system.run(until_ns=0)
    assert ticked.wait(PATIENCE)


def test_time_counts_from_the_first_run_and_now_is_utc(system: System) -> None:
    stamps: list[int] = []
    actor = Actor("a", lambda: stamps.append(actor.now()))
    activated(system, actor)
    before = time.time_ns()
    run_until(system, lambda: len(stamps) >= 3)
    assert stamps == sorted(stamps)
    assert abs(stamps[0] - before) < 60 * SECOND
    assert 0 < system.time < 60 * SECOND


def test_a_tick_that_takes_too_long_is_counted(
    system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(requests, "overruns", requests.Overruns(lambda: 0.0))

    def busy() -> None:
        end = time.monotonic_ns() + 3 * MS + MS // 2
        while time.monotonic_ns() < end:
            pass

    activated(system, Actor("slow", busy), rate_hz=1000.0)
    assert not requests.overruns.recent()
    run_until(system, lambda: system.statistics("slow").ticks >= 2)
    assert system.statistics("slow").overruns >= 3
    assert requests.overruns.recent()


def test_states_and_errors(system: System) -> None:
    records: list[StateRecord] = []
    system.add_listener(
        lambda r: records.append(r) if isinstance(r, StateRecord) else None
    )

    def fail() -> ReturnCode_t:
        raise ValueError("broken")

    activated(system, Actor("a", fail))
    run_until(system, lambda: system.state("a") is ERROR_STATE)
    reason = placeless(system.statistics("a").reason)
    assert reason == "on_execute: ValueError: broken"
    assert system.reset("a") is RTC_OK
    run_until(system, lambda: system.state("a") is INACTIVE_STATE)
    system.component("a").on_execute = lambda ec_id: RTC_OK  # type: ignore[method-assign]
    system.activate("a")
    run_until(system, lambda: system.state("a") is ACTIVE_STATE)
    states = [record.after.name.removesuffix("_STATE") for record in records]
    assert states == ["INACTIVE", "ACTIVE", "ERROR", "INACTIVE", "ACTIVE"]


def test_a_rate_change_wakes_a_sleeping_context(system: System) -> None:
    changed = threading.Event()

    class Rated(Actor):
        def on_rate_changed(self, ec_id: int) -> ReturnCode_t:
            changed.set()
            return RTC_OK

    activated(system, Rated("a"), rate_hz=0.001)
    run_until(system, lambda: system.statistics("a").ticks == 1)
    system.context("a").set_rate(1000.0)
    run_until(system, lambda: system.statistics("a").ticks >= 3)
    assert changed.is_set()


def test_a_context_stops_and_starts_and_may_stop_itself(system: System) -> None:
    stopped = threading.Event()

    def stop() -> None:
        system.context("a").stop()
        stopped.set()

    activated(system, Actor("a", stop))
    system.run(until_ns=0)
    assert stopped.wait(PATIENCE)
    assert system.statistics("a").ticks == 1
    system.context("a").start()
    run_until(system, lambda: system.statistics("a").ticks == 2)


def test_timeline_and_watchers_run_in_the_thread_of_run(system: System) -> None:
    threads: list[str] = []

    def note() -> None:
        threads.append(threading.current_thread().name)

    system.at(MS, note)
    end = system.every(MS, note)
    run_until(system, lambda: len(threads) >= 4)
    assert set(threads) == {threading.current_thread().name}
    end()
    count = len(threads)
    system.run(until_ns=system.time + 5 * MS)
    assert len(threads) <= count + 1


def test_a_further_context_takes_turns_with_the_own_one(system: System) -> None:
    inside = threading.Lock()
    clashes: list[int] = []
    handles: set[int] = set()

    class Double(Actor):
        def on_execute(self, ec_id: int) -> ReturnCode_t:
            if not inside.acquire(blocking=False):
                clashes.append(ec_id)
                return RTC_OK
            handles.add(ec_id)
            inside.release()
            return RTC_OK

    component = Double("a")
    activated(system, component)
    shared = system.add_context(2000.0)
    shared.add_component(component)
    shared.activate_component(component)
    shared.start()
    run_until(system, lambda: sum(p.ticks for p in shared.participants) >= 50)
    shared.stop()
    assert handles == {0, 1000}
    assert clashes == []


def test_a_blocked_writer_waits_for_the_reader(system: System) -> None:
    _, out, port = joined(
        {FULL: "block", LENGTH: "1", "dataport.buffer.write.timeout": "60"}, system
    )
    assert out.write(long(1)) is PORT_OK
    writer = Thread(lambda: out.write(long(2)))
    while (first := port.read()) is None or first.data != 1:
        pass
    assert writer.outcome() is PORT_OK
    assert drained(port) == [2]
    assert port.lost == 0


def test_a_blocked_writer_gives_up(system: System) -> None:
    _, out, port = joined(
        {FULL: "block", LENGTH: "1", "dataport.buffer.write.timeout": "0.001"}, system
    )
    out.write(long(1))
    assert Thread(lambda: out.write(long(2))).outcome() is PortStatus.BUFFER_TIMEOUT
    assert drained(port) == [1]
    assert port.lost == 1


def test_a_cut_wakes_a_blocked_writer(system: System) -> None:
    _, out, port = joined(
        {FULL: "block", LENGTH: "1", "dataport.buffer.write.timeout": "60"}, system
    )
    out.write(long(1))
    connector = system.connector("c")
    assert isinstance(connector, DataConnector)
    writer = Thread(lambda: out.write(long(2)))
    system.disconnect("c")
    assert writer.outcome() in (
        PortStatus.CONNECTION_LOST,
        PortStatus.PRECONDITION_NOT_MET,
    )
    assert (connector.cut, port.is_new()) == (1, False)


def test_a_blocked_reader_waits_for_the_writer(system: System) -> None:
    _, out, port = joined(
        {EMPTY: "block", "dataport.buffer.read.timeout": "60"}, system
    )
    reader = Thread(port.read)
    out.write(long(5))
    assert reader.outcome() == long(5)


def test_a_blocked_reader_gives_up(system: System) -> None:
    _, _, port = joined(
        {EMPTY: "block", "dataport.buffer.read.timeout": "0.001"}, system
    )
    assert Thread(port.read).outcome() is None


@pytest.mark.parametrize("policy", ["overwrite", "do_nothing"])
def test_nothing_is_lost_uncounted_between_threads(system: System, policy: str) -> None:
    _, out, port = joined({FULL: policy, LENGTH: "3"}, system)
    count = 3000
    done = threading.Event()

    def write() -> None:
        for n in range(count):
            out.write(long(n))
        done.set()

    Thread(write)
    got: list[int] = []
    while not done.is_set() or port.is_new():
        got += drained(port)
    assert got == sorted(set(got))
    assert len(got) + port.lost == count


def test_many_writers_and_one_reader_between_threads(system: System) -> None:
    _, first, port = joined({LENGTH: "1000000"}, system)
    second = Actor("second", outputs=("out",))
    system.add(second)
    system.connect(("second", "out"), ("reader", "in"), {LENGTH: "1000000"})
    outs, count = (first, second.outputs["out"]), 1000
    writers = [
        Thread(
            lambda out=out, base=base: [out.write(long(base + n)) for n in range(count)]
        )
        for base, out in enumerate(outs)
    ]
    got: list[int] = []
    while any(writer.is_alive() for writer in writers) or port.is_new():
        got += drained(port)
    assert len(got) == 2 * count
    assert port.lost == 0


def test_new_delivers_from_a_thread_of_its_own(system: System) -> None:
    properties = {
        "dataport.io_mode": "nonblock",
        "dataport.publisher.push_policy": "all",
    }
    _, out, port = joined(
        properties | {EMPTY: "block", "dataport.buffer.read.timeout": "60"}, system
    )
    for n in range(3):
        out.write(long(n))
    assert not port.is_new()
    system.run(until_ns=0)
    reader = Thread(lambda: [port.read() for _ in range(3)])
    assert reader.outcome() == [long(0), long(1), long(2)]


def test_a_refused_delivery_goes_on_when_there_is_room(system: System) -> None:
    properties = {
        "dataport.subscription_type": "new",
        "dataport.publisher.push_policy": "all",
        "dataport.outport.buffer.length": "100",
        "dataport.inport.buffer.length": "1",
        "dataport.inport.buffer.write.full_policy": "do_nothing",
        "dataport.inport.buffer.read.empty_policy": "block",
        "dataport.inport.buffer.read.timeout": "60",
    }
    _, out, port = joined(properties, system)
    system.run(until_ns=0)
    for n in range(20):
        out.write(long(n))
    reader = Thread(lambda: [port.read() for _ in range(20)])
    assert reader.outcome() == [long(n) for n in range(20)]
    assert port.lost == 0


@pytest.mark.parametrize("subscription", ["new", "periodic"])
def test_a_cut_ends_the_publisher(system: System, subscription: str) -> None:
    properties = {
        "dataport.subscription_type": subscription,
        "dataport.publisher.push_rate": "1000",
        "dataport.publisher.push_policy": "all",
        "dataport.inport.buffer.length": "1",
        "dataport.inport.buffer.write.full_policy": "block",
        "dataport.inport.buffer.write.timeout": "60",
    }
    _, out, port = joined(properties, system)
    system.run(until_ns=0)
    for n in range(5):
        out.write(long(n))
    run_until(system, port.is_new)
    system.disconnect("c")
    assert port.lost == 5
    assert not [t for t in threading.enumerate() if t.name == "rtgen publisher"]


def test_periodic_delivers_from_a_thread_of_its_own(system: System) -> None:
    properties = {
        "dataport.subscription_type": "periodic",
        "dataport.publisher.push_rate": "1000",
        "dataport.publisher.push_policy": "all",
    }
    _, out, port = joined(properties, system)
    out.write(long(1))
    run_until(system, port.is_new)
    assert drained(port) == [1]


def test_connections_are_cut_and_remade_while_active(system: System) -> None:
    got: list[int] = []
    _, out, port = joined({FULL: "do_nothing", LENGTH: "100000"}, system)
    writer, reader = system.component("writer"), system.component("reader")
    assert isinstance(writer, Actor)
    assert isinstance(reader, Actor)
    numbers = iter(range(1_000_000))

    def write() -> None:
        out.write(long(next(numbers)))

    writer.execute = write
    reader.execute = lambda: got.extend(drained(port))
    for _ in range(5):
        count = len(got)
        run_until(system, lambda count=count: len(got) > count)
        system.disconnect("c")
        system.connect(("writer", "out"), ("reader", "in"), {FULL: "do_nothing"}, "c")
    system.context("writer").stop()
    run_until(system, lambda: not port.is_new())
    system.context("reader").stop()
    assert got == sorted(set(got))
    assert len(got) + port.lost + out.unsent == next(numbers)


def other_thread(system: System, name: str) -> str:
    """Return the name of the thread in which a component ticks now."""
    component = system.component(name)
    assert isinstance(component, Actor)
    seen: list[str] = []
    component.execute = lambda: seen.append(threading.current_thread().name)
    run_until(system, lambda: bool(seen))
    return seen[-1]


def test_a_tick_that_waits_for_another_component_does_not_stop_it(
    system: System, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO, "rtgen.runtime")
    ticked, came = threading.Event(), threading.Event()

    def wait() -> None:
        if not came.is_set() and ticked.wait(PATIENCE):
            came.set()

    activated(system, Actor("a", wait), Actor("b", lambda: None))
    component = system.component("b")
    assert isinstance(component, Actor)
    run_until(system, lambda: system.statistics("a").ticks == 1)
    component.execute = ticked.set
    run_until(system, came.is_set)
    run_until(system, lambda: bool(caplog.records))
    (note,) = caplog.records
    assert note.levelname == "NOTE"
    assert re.fullmatch(
        r"a has a thread of its own from now on: on_execute"
        r" \(.*test_real_time.py, line \d+\) keeps others waiting",
        note.getMessage(),
    )
    assert other_thread(system, "a") == "rtgen a"
    assert other_thread(system, "b") == "rtgen ticks"
    assert system.context("a").has_own_thread
    assert not system.context("b").has_own_thread


def test_a_tick_that_computes_for_long_does_not_keep_others_waiting(
    system: System,
) -> None:
    ticks = 0

    def compute() -> None:
        before = system.statistics("b").ticks
        while system.statistics("b").ticks < before + 3:
            pass

    def count() -> None:
        nonlocal ticks
        ticks += 1

    activated(system, Actor("a", compute), Actor("b", count))
    run_until(system, lambda: system.statistics("a").ticks >= 2)
    assert ticks >= 3
    assert other_thread(system, "a") == "rtgen a"


def test_a_policy_that_waits_leaves_the_thread_first(system: System) -> None:
    properties = {EMPTY: "block", "dataport.buffer.read.timeout": "60"}
    _, out, port = joined(properties, system)
    reader, writer = system.component("reader"), system.component("writer")
    assert isinstance(reader, Actor)
    assert isinstance(writer, Actor)
    got: list[object] = []
    reader.execute = lambda: got.append(port.read())
    run_until(system, lambda: system.statistics("reader").ticks >= 1)
    assert got == []
    writer.execute = lambda: out.write(long(3))
    run_until(system, lambda: bool(got))
    assert got[0] == long(3)
    assert system.context("reader").has_own_thread
    assert not system.context("writer").has_own_thread


def test_a_callback_that_waits_once_does_not_keep_its_thread(system: System) -> None:
    ticked = threading.Event()

    class Slow(Actor):
        def on_activated(self, ec_id: int) -> ReturnCode_t:
            ticked.wait(PATIENCE)
            return RTC_OK

    activated(system, Slow("a"))
    activated(system, Actor("b", ticked.set))
    run_until(system, lambda: system.state("a") is ACTIVE_STATE)
    assert other_thread(system, "a") == other_thread(system, "b") == "rtgen ticks"
    assert not system.context("a").has_own_thread


def test_a_tick_that_takes_the_time_of_others_is_named(system: System) -> None:
    def wait() -> None:
        time.sleep(0.005)

    activated(system, Actor("slow", wait), rate_hz=100.0)
    activated(system, Actor("fast"), rate_hz=1000.0)
    run_until(system, lambda: system.context("slow").has_own_thread)
    assert system.context("fast").causes["slow"] > 0
    ticks = system.statistics("slow").ticks
    run_until(system, lambda: system.statistics("slow").ticks > ticks)
    assert other_thread(system, "slow") == "rtgen slow"


def test_one_component_has_a_thread_of_its_own_if_it_is_asked_for() -> None:
    with System(RealClock()) as system:
        names: dict[str, set[str]] = {"a": set(), "b": set()}
        for name, threads in (("a", "own"), ("b", None)):
            actor = Actor(
                name, lambda n=name: names[n].add(threading.current_thread().name)
            )
            system.add(actor, threads=threads)
            system.activate(name)
        run_until(system, lambda: all(names.values()))
        assert names == {"a": {"rtgen a"}, "b": {"rtgen ticks"}}


def test_a_context_that_starts_later_ticks_at_once(system: System) -> None:
    activated(system, Actor("a"), rate_hz=100.0)
    run_until(system, lambda: system.statistics("a").ticks >= 2)
    activated(system, Actor("b"), rate_hz=0.001)
    run_until(system, lambda: system.statistics("b").ticks == 1)


def test_contexts_of_equal_instants_tick_in_their_order(system: System) -> None:
    seen: list[str] = []
    names = ("c", "a", "b")
    rates = dict(zip(names, (100.0, 200.0, 100.0), strict=True))
    for name in names:
        actor = Actor(name, lambda n=name: seen.append(n))
        activated(system, actor, rate_hz=rates[name])
    run_until(system, lambda: seen.count("c") >= 4)
    order = "".join(seen[: seen.index("c", 3)])
    assert "cab" in order


@pytest.mark.parametrize("when", ["before", "during"])
def test_a_context_of_the_shared_thread_is_stopped_by_another(
    system: System, when: str
) -> None:
    stopped: list[ReturnCode_t] = []

    def stop() -> None:
        if not stopped:
            stopped.append(system.context("a").stop())

    pair = (Actor("a"), Actor("b", stop))
    activated(system, *(pair if when == "during" else pair[::-1]))
    run_until(system, lambda: bool(stopped))
    ticks = system.statistics("a").ticks
    count = system.statistics("b").ticks
    run_until(system, lambda: system.statistics("b").ticks >= count + 3)
    assert stopped == [RTC_OK]
    assert system.statistics("a").ticks == ticks
