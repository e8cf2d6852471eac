"""`System.close`: the order of components, and its effects on those that still run."""

from __future__ import annotations

import gc
import sys
import threading
from abc import abstractmethod
from collections.abc import Callable, Iterator
from types import FrameType
from typing import ClassVar

import pytest
from patience import PATIENCE
from runtime_samples import SECOND

from rtgen.runtime import (
    ACTIVE_STATE,
    RTC_OK,
    Clock,
    Component,
    ComponentProfile,
    Failure,
    RealClock,
    ReturnCode_t,
    Servant,
    SimulatedClock,
    Skeleton,
    Stub,
    System,
)
from rtgen.runtime.marshalling.descriptors import InterfaceDescriptor
from rtgen.runtime.system import watchdog

BETWEEN = 0.1
"""Time in which a component that still ticks at 1 kHz would call a service [s]."""


class Pump(Servant):
    _descriptor_: ClassVar[InterfaceDescriptor] = InterfaceDescriptor(
        "IDL:Pump:1.0", "Pump", ("void stop()",)
    )

    @abstractmethod
    def stop(self) -> None: ...


class PumpStub(Pump, Stub):
    """Calls a Pump."""


class PumpSkeleton(Skeleton, interface=Pump):
    """Serves a Pump."""


class Plant(Component):
    """A component that offers a pump, and calls that of another plant in its callbacks."""

    profile: ClassVar[ComponentProfile] = ComponentProfile("Plant", max_instances=0)

    def __init__(self, instance_name: str, events: list[str]) -> None:
        super().__init__(instance_name)
        self.events = events
        self.own = self.add_provider("own", "own", Pump)
        self.other = self.add_consumer("other", "other", Pump)
        self.calls = False
        self.execute: Callable[[], object] = lambda: None

    def on_initialize(self) -> ReturnCode_t:
        class Served(Pump):
            def stop(self) -> None:
                return None

        self.own.set_servant(Served())
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        if self.calls:
            self.other.object.stop()
        self.execute()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        self.events.append(self.instance_name)
        threading.Event().wait(BETWEEN)
        if self.calls:
            self.other.object.stop()
        return RTC_OK


def plants(
    clock: Clock, names: str, calls: list[tuple[str, str]]
) -> tuple[System, list[str], list[Failure]]:
    """Return ACTIVE plants, the order of their deactivation, and the failures."""
    events: list[str] = []
    failures: list[Failure] = []
    system = System(clock)
    system.on_failure = failures.append
    for name in names:
        system.add(Plant(name, events), 1000.0)
    for caller, called in calls:
        system.connect((caller, "other"), (called, "own"))
    for name in names:
        system.activate(name)
    assert system.run(
        10 * SECOND, lambda s: all(s.state(n) is ACTIVE_STATE for n in names)
    )
    for caller, _ in calls:
        plant(system, caller).calls = True
    return system, events, failures


def plant(system: System, name: str) -> Plant:
    found = system.component(name)
    assert isinstance(found, Plant)
    return found


CLOCKS = pytest.mark.parametrize("clock", [SimulatedClock, RealClock])


@CLOCKS
def test_callers_exit_before_those_whom_they_call(clock: type[Clock]) -> None:
    system, events, failures = plants(clock(), "ABC", [("A", "B"), ("B", "C")])
    system.close()
    assert (events, failures) == (["A", "B", "C"], [])


@CLOCKS
def test_else_the_last_added_exits_first(clock: type[Clock]) -> None:
    system, events, failures = plants(clock(), "ABCD", [("D", "A")])
    system.close()
    assert (events, failures) == (["D", "C", "B", "A"], [])


def test_in_a_circle_nobody_ticks_any_more_when_the_first_exits() -> None:
    system, events, failures = plants(RealClock(), "AB", [("A", "B"), ("B", "A")])
    ticks = system.statistics("A").ticks
    system.run(until=lambda s: s.statistics("A").ticks > ticks)
    system.close()
    assert [f for f in failures if f.callback == "on_execute"] == []
    assert sorted(events) == ["A", "B"]


def test_calls_that_do_not_return_are_given_up_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(watchdog, "PATIENCE", 0.3)
    system, events, failures = plants(RealClock(), "ABC", [("A", "B")])
    blocked, end = [threading.Event(), threading.Event()], threading.Event()

    def block(began: threading.Event) -> None:
        began.set()
        end.wait()

    plant(system, "A").execute = lambda: block(blocked[0])
    plant(system, "B").execute = lambda: block(blocked[1])
    for began in blocked:
        assert began.wait(PATIENCE)
    system.close()
    reported = [(f.instance, f.callback) for f in failures]
    end.set()
    assert sorted(reported) == [("A", "on_execute"), ("B", "on_execute")]
    assert events == ["C"]


@pytest.fixture
def frequent_collections() -> Iterator[list[str]]:
    """Collect garbage as often as possible; yield the phases of all collections."""
    seen: list[str] = []
    was_enabled, thresholds = gc.isenabled(), gc.get_threshold()

    def collected(phase: str, info: object) -> None:
        seen.append(phase)

    gc.callbacks.append(collected)
    gc.set_threshold(1)
    yield seen
    gc.callbacks.remove(collected)
    gc.set_threshold(*thresholds)
    (gc.enable if was_enabled else gc.disable)()


@pytest.mark.parametrize("collects", [True, False])
def test_the_collector_is_as_it_was_after_a_look_at_all_threads(
    frequent_collections: list[str], collects: bool
) -> None:
    (gc.enable if collects else gc.disable)()
    watchdog.calls_under_way()
    assert gc.isenabled() is collects


@pytest.mark.skipif(
    sys.version_info >= (3, 12), reason="3.12 makes frames without collecting garbage"
)
def test_no_garbage_is_collected_while_frames_are_read(
    frequent_collections: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    find = watchdog._call_in

    def looked(thread: int, frame: FrameType) -> object:
        before = len(frequent_collections)
        call = find(thread, frame)
        assert [[] for _ in range(9)]
        assert len(frequent_collections) == before
        return call

    monkeypatch.setattr(watchdog, "_call_in", looked)
    gc.enable()
    watchdog.calls_under_way()
    assert frequent_collections
