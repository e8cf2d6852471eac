"""Simulated time: instants, their order, rates, the timeline, and further contexts."""

from __future__ import annotations

import pytest
from runtime_samples import MS, SECOND, Actor, activated, drained, long

from rtgen.runtime import (
    ACTIVE_STATE,
    BAD_PARAMETER,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    UNSUPPORTED,
    DuplicateInstanceError,
    ExecutionKind,
    InitializationError,
    RateError,
    ReturnCode_t,
    SimulatedClock,
    System,
    UnknownComponentError,
    UnknownObservableError,
)


def ticking(*names: str) -> tuple[System, list[tuple[str, int]]]:
    """Return components that record (name, time in ms) at each tick, at 1000 Hz."""
    system, notes = System(SimulatedClock()), []

    def actor(name: str) -> Actor:
        return Actor(name, lambda: notes.append((name, system.time // MS)))

    activated(system, *(actor(name) for name in names))
    return system, notes


def test_a_run_ends_before_its_last_instant_and_can_go_on() -> None:
    system, notes = ticking("a")
    assert not system.run(until_ns=3 * MS)
    assert [time for _, time in notes] == [0, 1, 2]
    assert system.time == 3 * MS
    assert not system.run(until_ns=5 * MS)
    assert [time for _, time in notes] == [0, 1, 2, 3, 4]
    assert system.statistics("a").ticks == 5


def test_at_equal_instants_the_order_of_adding_decides() -> None:
    system, notes = ticking("b", "a", "c")
    system.context("a").set_rate(500.0)
    system.run(until_ns=4 * MS)
    assert notes == [
        ("b", 0), ("a", 0), ("c", 0),
        ("b", 1), ("c", 1),
        ("b", 2), ("a", 2), ("c", 2),
        ("b", 3), ("c", 3),
    ]  # fmt: skip


def test_periods_are_whole_nanoseconds_and_do_not_drift() -> None:
    system = System()
    times: list[int] = []
    system.add(Actor("third", lambda: times.append(system.time)), 3.0)
    system.activate("third")
    system.run(until_ns=10 * SECOND)
    assert times == [tick * 333_333_333 for tick in range(31)]


def test_now_and_stamp_go_by_simulated_time() -> None:
    system = System()
    actor = Actor("a")
    stamps: list[tuple[int, int, int]] = []

    def execute() -> None:
        sample = long(1)
        actor.stamp(sample)
        stamps.append((actor.now(), sample.tm.sec, sample.tm.nsec))

    actor.execute = execute
    activated(system, actor, rate_hz=0.8)
    system.run(until_ns=2 * SECOND)
    assert stamps == [(0, 0, 0), (1_250_000_000, 1, 250_000_000)]
    assert Actor("alone").now() == 0


def test_a_condition_ends_a_run_after_all_ticks_of_the_instant() -> None:
    system, notes = ticking("a", "b")
    assert system.run(until=lambda s: ("a", 1) in notes)
    assert notes == [("a", 0), ("b", 0), ("a", 1), ("b", 1)]
    assert system.run(SECOND, lambda s: s.state("a") is ACTIVE_STATE)
    assert len(notes) == 4
    assert not system.run(2 * MS, lambda s: False)


def test_a_run_needs_an_end_and_something_to_do() -> None:
    with pytest.raises(ValueError, match="run needs an end"):
        System().run()
    assert not System().run(until=lambda s: False)


def test_a_request_takes_effect_at_the_next_tick() -> None:
    system, notes = ticking("a")
    assert system.state("a") is INACTIVE_STATE
    assert system.activate("a") is RTC_OK
    assert system.state("a") is INACTIVE_STATE
    assert system.deactivate("a") is PRECONDITION_NOT_MET
    system.run(until_ns=2 * MS)
    assert system.state("a") is ACTIVE_STATE
    assert system.deactivate("a") is RTC_OK
    system.run(until_ns=4 * MS)
    assert (system.state("a"), len(notes)) == (INACTIVE_STATE, 2)
    assert system.reset("a") is PRECONDITION_NOT_MET


def test_a_callback_may_ask_for_its_own_component() -> None:
    system = System()
    actor = Actor("a", lambda: None if system.time else system.deactivate("a"))
    activated(system, actor)
    system.run(until_ns=1)
    assert system.state("a") is ACTIVE_STATE
    system.run(until_ns=2 * MS)
    assert system.state("a") is INACTIVE_STATE
    assert system.statistics("a").ticks == 1


def test_on_error_may_ask_for_a_reset() -> None:
    class Recovering(Actor):
        def on_error(self, ec_id: int) -> ReturnCode_t:
            context = self.get_context(ec_id)
            assert context is not None
            return context.reset_component(self)

    system = activated(System(), Recovering("a", lambda: RTC_ERROR))
    states = []
    for tick in range(1, 5):
        system.run(until_ns=tick * MS)
        states.append(system.state("a"))
    assert states == [ERROR_STATE, ERROR_STATE, INACTIVE_STATE, INACTIVE_STATE]


def test_timeline_goes_before_and_watchers_after_the_ticks() -> None:
    system, notes = ticking("a")
    system.at(1 * MS, lambda: notes.append(("at", system.time // MS)))
    end = system.every(2 * MS, lambda: notes.append(("every", system.time // MS)))
    system.at(3 * MS, end)
    system.run(until_ns=5 * MS)
    assert notes == [
        ("a", 0), ("every", 0),
        ("at", 1), ("a", 1),
        ("a", 2), ("every", 2),
        ("a", 3), ("a", 4),
    ]  # fmt: skip


def test_an_action_of_the_past_happens_at_once_and_may_add_others() -> None:
    system, notes = ticking("a")
    system.run(until_ns=2 * MS)
    system.at(0, lambda: system.at(system.time, lambda: notes.append(("at", 2))))
    system.run(until_ns=3 * MS)
    assert notes[2:] == [("at", 2), ("a", 2)]


def test_a_rate_change_counts_from_the_last_tick() -> None:
    system, notes = ticking("a")
    context = system.context("a")
    system.at(2 * MS + 500_000, lambda: context.set_rate(250.0))
    system.at(10 * MS + 500_000, lambda: context.set_rate(4000.0))
    system.run(until_ns=11 * MS)
    assert [time for _, time in notes] == [0, 1, 2, 6, 10, 10, 10]
    assert system.statistics("a").overruns == 0


@pytest.mark.parametrize(
    ("kind", "executed"),
    [(ExecutionKind.EVENT_DRIVEN, []), (ExecutionKind.OTHER, [0, 4, 8])],
)
def test_only_a_periodic_context_takes_another_rate(
    kind: ExecutionKind, executed: list[int]
) -> None:
    """docs/life-cycle.md describes the other kinds."""
    system, notes = System(), []
    system.add(Actor("a", lambda: notes.append(system.time // MS)), 1000.0)
    context = system.add_context(250.0, kind=kind)
    context.add_component(system.component("a"))
    assert context.set_rate(500.0) is UNSUPPORTED
    assert context.set_rate(0.0) is UNSUPPORTED
    assert (context.get_rate(), context.get_kind()) == (250.0, kind)
    context.start()
    context.activate_component(system.component("a"))
    system.run(until_ns=9 * MS)
    # One of kind OTHER is executed at its own rate, like a periodic one.
    assert notes == executed


def test_a_callback_may_change_its_own_rate() -> None:
    changed: list[int] = []

    class Slowing(Actor):
        def on_rate_changed(self, ec_id: int) -> ReturnCode_t:
            changed.append(system.time // MS)
            return RTC_OK

    system = System()
    times: list[int] = []

    def execute() -> None:
        times.append(system.time // MS)
        if system.time == MS:
            assert system.context("a").set_rate(100.0) is RTC_OK

    activated(system, Slowing("a", execute))
    system.run(until_ns=25 * MS)
    assert times == [0, 1, 11, 21]
    assert changed == [11]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_rates(rate: float) -> None:
    system, _ = ticking("a")
    assert system.context("a").set_rate(rate) is BAD_PARAMETER
    assert system.context("a").get_rate() == 1000.0
    with pytest.raises(RateError, match="must be a number of Hz above 0"):
        system.add(Actor("b"), rate)


def test_a_context_stops_and_starts() -> None:
    system, notes = ticking("a")
    context = system.context("a")
    system.run(until_ns=2 * MS)
    assert context.stop() is RTC_OK
    assert not context.is_running()
    system.run(until_ns=5 * MS)
    assert len(notes) == 2
    assert context.start() is RTC_OK
    system.run(until_ns=6 * MS)
    assert notes[2:] == [("a", 5)]
    assert context.get_kind() is ExecutionKind.PERIODIC


def test_a_context_restarted_in_its_own_tick_does_not_tick_twice_at_one_instant() -> (
    None
):
    system = System()
    times: list[int] = []

    def execute() -> None:
        times.append(system.time // MS)
        context = system.context("a")
        context.stop()
        context.start()

    activated(system, Actor("a", execute))
    system.run(until_ns=3 * MS)
    assert times == [0, 1, 2]


def test_a_component_may_take_part_in_a_further_context() -> None:
    handles: list[int] = []

    class Double(Actor):
        def on_execute(self, ec_id: int) -> ReturnCode_t:
            handles.append(ec_id)
            return RTC_OK

    system = System()
    one, two = Double("one"), Actor("two")
    activated(system, one, two, rate_hz=100.0)
    shared = system.add_context(200.0)
    assert shared.add_component(one) is RTC_OK
    assert shared.add_component(two) is RTC_OK
    assert shared.add_component(two) is PRECONDITION_NOT_MET
    assert shared.start() is RTC_OK
    assert shared.activate_component(one) is RTC_OK
    system.run(until_ns=11 * MS)
    assert handles == [0, 1000, 1000, 0, 1000]
    assert shared.get_component_state(two) is INACTIVE_STATE
    assert one.get_participating_contexts() == [shared]
    assert one.get_owned_contexts() == [system.context("one")]
    assert one.get_context_handle(shared) == 1000
    assert two.get_context_handle(system.context("one")) == -1
    assert shared.remove_component(one) is PRECONDITION_NOT_MET
    shared.deactivate_component(one)
    system.run(until_ns=16 * MS)
    assert shared.remove_component(one) is RTC_OK
    assert shared.get_component_state(one) is CREATED_STATE
    assert one.is_active
    system.close()
    assert shared.participants == ()


def test_phases_run_over_all_participants_in_turn() -> None:
    calls: list[str] = []

    class Phased(Actor):
        def on_activated(self, ec_id: int) -> ReturnCode_t:
            calls.append(f"{self.instance_name} activated")
            return RTC_OK

        def on_execute(self, ec_id: int) -> ReturnCode_t:
            calls.append(f"{self.instance_name} execute")
            return RTC_ERROR if self.instance_name == "b" else RTC_OK

        def on_state_update(self, ec_id: int) -> ReturnCode_t:
            calls.append(f"{self.instance_name} update")
            return RTC_OK

        def on_aborting(self, ec_id: int) -> ReturnCode_t:
            calls.append(f"{self.instance_name} aborting")
            return RTC_OK

        def on_error(self, ec_id: int) -> ReturnCode_t:
            calls.append(f"{self.instance_name} error")
            return RTC_OK

    system = System()
    shared = system.add_context(1000.0)
    for name in ("a", "b"):
        component = Phased(name)
        system.add(component)
        shared.add_component(component)
        shared.activate_component(component)
    shared.start()
    system.run(until_ns=2 * MS)
    assert calls == [
        "a activated", "b activated",
        "a execute", "b execute", "b aborting",
        "a update",
        "a execute", "b error",
        "a update",
    ]  # fmt: skip
    assert shared.participants[1].ticks == 1


def test_adding_refuses_what_cannot_run() -> None:
    class Broken(Actor):
        def on_initialize(self) -> ReturnCode_t:
            return self.fail("no device")

    system, _ = ticking("a")
    with pytest.raises(DuplicateInstanceError, match="a component 'a' already"):
        system.add(Actor("a"))
    with pytest.raises(InitializationError, match="b cannot be initialized: no device"):
        system.add(Broken("b"))
    with pytest.raises(InitializationError, match="it is initialized already"):
        System().add(system.component("a"))
    assert system.instances == ("a",)
    for ask in (system.state, system.activate, system.component, system.statistics):
        with pytest.raises(UnknownComponentError, match="no component 'b'; known: a"):
            ask("b")
    with pytest.raises(TypeError, match="a SimulatedClock or a RealClock"):
        System(object())  # type: ignore[arg-type]


def test_components_come_and_go_while_a_system_runs() -> None:
    system, notes = ticking("a")
    system.at(
        MS,
        lambda: activated(system, Actor("b", lambda: notes.append(("b", 1)))) and None,
    )
    system.at(2 * MS, lambda: system.remove("b"))
    system.run(until_ns=4 * MS)
    assert notes == [("a", 0), ("a", 1), ("b", 1), ("a", 2), ("a", 3)]


def test_closing_goes_backwards_and_calls_what_ends_a_life() -> None:
    calls: list[str] = []

    class Ending(Actor):
        def on_deactivated(self, ec_id: int) -> ReturnCode_t:
            calls.append(f"{self.instance_name} deactivated")
            return RTC_OK

        def on_shutdown(self, ec_id: int) -> ReturnCode_t:
            calls.append(f"{self.instance_name} shutdown")
            return RTC_OK

        def on_finalize(self) -> ReturnCode_t:
            calls.append(f"{self.instance_name} finalize")
            return RTC_OK

    with System() as system:
        activated(system, Ending("a"), Ending("b"))
        system.deactivate("b")
        system.run(until_ns=1)
        system.deactivate("b")
        system.run(until_ns=2 * MS)
    assert calls == [
        "b deactivated", "b shutdown", "b finalize",
        "a deactivated", "a shutdown", "a finalize",
    ]  # fmt: skip
    assert system.instances == ()


def test_observables_by_name() -> None:
    system, _ = ticking("a")
    system.component("a").observables["truth"] = lambda: (1.0, 2.0, 3.0)
    assert system.observable("a.truth") == (1.0, 2.0, 3.0)
    with pytest.raises(
        UnknownObservableError, match="a has no observable 'lie'; known: truth"
    ):
        system.observable("a.lie")
    with pytest.raises(UnknownComponentError):
        system.observable("b.truth")


def test_a_chain_passes_a_sample_on_within_one_instant() -> None:
    system = System()
    first, second = Actor("1", outputs=("out",)), Actor(
        "2", inputs=("in",), outputs=("out",)
    )
    third = Actor("3", inputs=("in",))

    def write() -> None:
        first.outputs["out"].write(long(system.time // MS))

    def relay() -> None:
        for value in drained(second.inputs["in"]):
            second.outputs["out"].write(long(value + 100))

    got: list[tuple[int, int]] = []
    first.execute = write
    second.execute = relay
    third.execute = lambda: got.extend(
        (system.time // MS, value) for value in drained(third.inputs["in"])
    )
    activated(system, first, second, third)
    system.connect(("1", "out"), ("2", "in"))
    system.connect(("2", "out"), ("3", "in"))
    system.run(until_ns=3 * MS)
    assert got == [(0, 100), (1, 101), (2, 102)]


def test_a_request_that_has_become_illegal_is_dropped(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Fragile(Actor):
        def on_rate_changed(self, ec_id: int) -> ReturnCode_t:
            return RTC_ERROR

    system = System()
    system.add(Fragile("a"))
    system.context("a").set_rate(500.0)
    assert system.activate("a") is RTC_OK
    system.run(until_ns=1)
    assert system.state("a") is ERROR_STATE
    assert "a: activate is ignored: the state is already ERROR" in caplog.messages
