"""Components wait for the providers of their services, in any order, also in real time."""

from __future__ import annotations

from abc import abstractmethod
from itertools import pairwise, permutations
from typing import ClassVar

import pytest

from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    RTC_ERROR,
    RTC_OK,
    SECOND,
    Clock,
    Component,
    ComponentProfile,
    RealClock,
    ReturnCode_t,
    Servant,
    SimulatedClock,
    Skeleton,
    Stub,
    System,
)
from rtgen.runtime.marshalling.descriptors import InterfaceDescriptor


class Source(Servant):
    _descriptor_: ClassVar[InterfaceDescriptor] = InterfaceDescriptor(
        "IDL:Source:1.0", "Source", ("long value()",)
    )

    @abstractmethod
    def value(self) -> int: ...


class SourceStub(Source, Stub):
    """Calls a Source."""


class SourceSkeleton(Skeleton, interface=Source):
    """Serves a Source."""


class Stage(Component):
    """A component that calls the next stage in every callback, like a client of a board."""

    profile: ClassVar[ComponentProfile] = ComponentProfile("Stage", max_instances=0)
    calls = False
    fails = False

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.offered = self.add_provider("offered", "offered", Source)
        self.used = self.add_consumer("used", "used", Source)

    def on_initialize(self) -> ReturnCode_t:
        stage = self

        class Carrier(Source):
            def value(self) -> int:
                return stage.used.object.value() + 1 if stage.calls else 0

        self.offered.set_servant(Carrier())
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        if self.calls:
            self.used.object.value()
        return RTC_ERROR if self.fails else RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        return self.on_activated(ec_id)


NAMES = ("Client", "Marshaller", "Communication")


def chain(clock: Clock, order: tuple[str, ...], rates: dict[str, float]) -> System:
    """Return a chain of services; all components are requested to become ACTIVE."""
    system = System(clock)
    for name in order:
        stage = Stage(name)
        stage.calls = name != NAMES[-1]
        system.add(stage, rates.get(name, 100.0))
    for consumer, provider in pairwise(NAMES):
        system.connect((consumer, "used"), (provider, "offered"))
    for name in order:
        assert system.activate(name) is RTC_OK
    return system


def is_active(system: System) -> bool:
    return all(system.state(name) is ACTIVE_STATE for name in NAMES)


@pytest.mark.parametrize("order", list(permutations(NAMES)))
@pytest.mark.parametrize("slow", NAMES)
def test_any_order_in_simulated_time(order: tuple[str, ...], slow: str) -> None:
    with chain(SimulatedClock(), order, {slow: 10.0}) as system:
        assert system.run(SECOND, is_active)
        system.run(2 * SECOND)
        assert is_active(system)


def test_starts_in_real_time() -> None:
    for order in permutations(NAMES):
        for slow in NAMES:
            rates = dict.fromkeys(NAMES, 1000.0) | {slow: 100.0}
            with chain(RealClock(), order, rates) as system:
                assert system.run(10 * SECOND, is_active), (order, slow)
                ticks = system.statistics("Client").ticks
                assert system.run(
                    20 * SECOND,
                    lambda s, t=ticks: s.statistics("Client").ticks > t + 2,
                )
                assert is_active(system)


def test_a_provider_that_fails_lets_its_consumers_go_on() -> None:
    with chain(SimulatedClock(), NAMES, {}) as system:
        communication = system.component("Communication")
        assert isinstance(communication, Stage)
        communication.fails = True
        system.run(SECOND)
        assert system.state("Communication") is ERROR_STATE
        assert system.state("Marshaller") is ERROR_STATE
        assert "Communication" in system.statistics("Marshaller").reason


def test_a_circle_is_activated_in_its_order() -> None:
    system = System(SimulatedClock())
    with system:
        for name in ("A", "B"):
            system.add(Stage(name), 100.0)
        system.connect(("A", "used"), ("B", "offered"))
        system.connect(("B", "used"), ("A", "offered"))
        for name in ("A", "B"):
            system.activate(name)
        assert system.activation_order(["A", "B"]) == ["B", "A"]
        system.run(SECOND)
        assert system.state("A") is system.state("B") is ACTIVE_STATE


def test_whom_a_component_waits_for() -> None:
    with chain(SimulatedClock(), NAMES, {}) as system:
        system.run(1)
        assert system.statistics("Client").awaited == "Marshaller to be activated"
    with chain(SimulatedClock(), NAMES, {}) as system:
        system.context("Communication").stop()
        system.run(SECOND)
        assert system.state("Client") is ERROR_STATE, "who never ticks is not awaited"
