"""Requests that wait for an external condition: gates and their failures."""

from __future__ import annotations

from functools import partial

import pytest

from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_OK,
    Component,
    LifeCycleState,
    RealClock,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.runtime.rtc.life_cycle import Request

MILLISECOND = 1_000_000


class Slow(Component):
    """A gate that lets a request pass some time after it was first asked."""

    def __init__(self, delay: int = 25 * MILLISECOND) -> None:
        super().__init__("Slow0")
        self.delay = delay
        self.began: int | None = None
        self.asked: list[Request] = []
        self.answer: ReturnCode_t | None = RTC_OK

    def _gate(self, request: Request) -> ReturnCode_t | None:
        self.asked.append(request)
        self.began = self.now() if self.began is None else self.began
        if self.now() - self.began < self.delay:
            self._awaited = f"{request}'s end"
            return None
        self.began = None
        return self.answer


def started(component: Component, clock: SimulatedClock | RealClock) -> System:
    system = System(clock)
    system.add(component, 100.0)
    return system


def is_in(state: LifeCycleState, system: System) -> bool:
    return system.state("Slow0") is state


@pytest.mark.parametrize("clock", [SimulatedClock, RealClock])
def test_each_transition_waits_for_its_gate(
    clock: type[SimulatedClock] | type[RealClock],
) -> None:
    slow = Slow()
    with started(slow, clock()) as system:
        for ask, before, after in (
            (system.activate, INACTIVE_STATE, ACTIVE_STATE),
            (system.deactivate, ACTIVE_STATE, INACTIVE_STATE),
        ):
            begin = system.time
            assert ask("Slow0") is RTC_OK
            assert system.state("Slow0") is before
            assert system.run(10**10, until=partial(is_in, after))
            assert system.time - begin >= slow.delay
        assert system.statistics("Slow0").awaited == ""


def test_a_gate_is_asked_once_in_a_tick() -> None:
    slow = Slow()
    with started(slow, SimulatedClock()) as system:
        system.activate("Slow0")
        system.activate("Slow0")
        system.run(30 * MILLISECOND)
        assert slow.asked == [Request.ACTIVATE] * 3
        assert system.statistics("Slow0").awaited == "activate's end"
        assert system.deactivate("Slow0") is PRECONDITION_NOT_MET
        system.run(40 * MILLISECOND)
        assert system.state("Slow0") is ACTIVE_STATE
        assert system.statistics("Slow0").ticks == 1


def test_a_component_goes_on_while_its_deactivation_waits() -> None:
    slow = Slow(0)
    with started(slow, SimulatedClock()) as system:
        system.activate("Slow0")
        system.run(10 * MILLISECOND)
        slow.delay = 25 * MILLISECOND
        system.deactivate("Slow0")
        system.run(50 * MILLISECOND)
        assert system.state("Slow0") is INACTIVE_STATE
        assert system.statistics("Slow0").ticks == 4


def test_the_first_failure_is_the_reason_and_ends_what_waits() -> None:
    slow = Slow()
    with started(slow, SimulatedClock()) as system:
        system.activate("Slow0")
        system.run(10 * MILLISECOND)
        context = system.context("Slow0")
        assert context.fail_component(slow, "lost") is RTC_OK
        assert context.fail_component(slow, "lost again") is RTC_OK
        system.run(60 * MILLISECOND)
        assert system.state("Slow0") is ERROR_STATE
        assert slow.reason == "lost"
        assert slow._awaited == ""
        assert context.fail_component(slow, "too late") is PRECONDITION_NOT_MET
        assert slow.asked == [Request.ACTIVATE] * 2


def test_a_refusal_says_why() -> None:
    class Refusing(Slow):
        def _gate(self, request: Request) -> ReturnCode_t | None:
            return self.fail("no answer")

    slow = Refusing()
    with started(slow, SimulatedClock()) as system:
        system.activate("Slow0")
        system.run(10 * MILLISECOND)
        assert system.state("Slow0") is ERROR_STATE
        assert slow.reason == "no answer"


def test_the_parameters_are_there_when_the_gate_is_asked() -> None:
    """The gate may need their values."""
    from dataclasses import dataclass

    from rtgen.runtime.rtc.profiles import ComponentProfile, ParameterProfile

    @dataclass
    class Configuration:
        speed: int = 1

    seen: list[int] = []

    class Configured(Component):
        profile = ComponentProfile(
            "Configured",
            configuration=(ParameterProfile("speed", "speed", "long", "1"),),
        )

        def __init__(self) -> None:
            super().__init__("Configured0")
            self.config = self.add_configuration(Configuration())

        def _gate(self, request: Request) -> ReturnCode_t | None:
            seen.append(self.config.speed)
            return RTC_OK

    with started(Configured(), SimulatedClock()) as system:
        system.configure("Configured0", "speed", "7")
        system.activate("Configured0")
        system.run(10 * MILLISECOND)
    assert seen == [7]
