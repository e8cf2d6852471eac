"""Execution contexts with several components, components in several contexts, and schedulers."""

from __future__ import annotations

import logging
import math
import threading
from collections.abc import Callable
from typing import Any

import pytest
from patience import PATIENCE
from runtime_samples import placeless

from rtgen.runtime import (
    ACTIVE_STATE,
    BAD_PARAMETER,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    Component,
    ExecutionContext,
    ExecutionKind,
    LifeCycleState,
    RealClock,
    ReturnCode_t,
)
from rtgen.runtime.errors import RateError
from rtgen.runtime.rtc.execution_context import Undriven
from rtgen.runtime.rtc.life_cycle import Request
from rtgen.runtime.system.runner import MACHINE, Runner, Task
from rtgen.runtime.timing.clocks import SECOND

Calls = list[tuple[str, str, int]]


class Noting(Component):
    """Records its callbacks in the list that the components share."""

    def __init__(self, name: str, calls: Calls) -> None:
        super().__init__(name)
        self.calls = calls
        self.failing = ""
        self.gate: ReturnCode_t | None = RTC_OK
        self.during: Callable[[str], None] = lambda callback: None
        assert self.initialize() is RTC_OK

    def note(self, callback: str, handle: int) -> ReturnCode_t:
        self.calls.append((self.instance_name, callback, handle))
        self.during(callback)
        return self.fail("on purpose") if callback == self.failing else RTC_OK

    def _gate(self, request: Request) -> ReturnCode_t | None:
        return self.gate

    def _arrived(self) -> None:
        if self.note("arrived", 0) is not RTC_OK:
            raise ValueError("bad input")


def _noting(name: str) -> Callable[..., ReturnCode_t]:
    return lambda self, handle: self.note(name, handle)


for _name in (n for n in vars(Component) if n.startswith("on_")):
    if _name not in ("on_initialize", "on_finalize"):
        setattr(Noting, _name, _noting(_name))


class Driver(Undriven):
    """A scheduler that records its notifications."""

    def __init__(self) -> None:
        self.seen: list[tuple[str, ExecutionContext]] = []
        self.ends = True

    def started(self, context: ExecutionContext) -> None:
        assert context.is_running()
        self.seen.append(("started", context))

    def stopped(self, context: ExecutionContext) -> bool:
        assert context.is_running() is False
        self.seen.append(("stopped", context))
        return self.ends

    def rate_changed(self, context: ExecutionContext) -> None:
        self.seen.append(("rate", context))

    def cycle_changed(self, context: ExecutionContext) -> None:
        self.seen.append(("cycle", context))

    def woken(self, context: ExecutionContext) -> None:
        self.seen.append(("woken", context))


def of_two(**options: Any) -> tuple[ExecutionContext, Noting, Noting, Calls]:
    """Return a running context of two components, both INACTIVE."""
    calls: Calls = []
    one, two = Noting("one", calls), Noting("two", calls)
    context = ExecutionContext(**options)
    for component in (one, two):
        assert context.add_component(component) is RTC_OK
    assert context.start() is RTC_OK
    calls.clear()
    return context, one, two, calls


def activated(context: ExecutionContext, *components: Component) -> None:
    for component in components:
        assert context.activate_component(component) is RTC_OK
    context.tick()


def test_a_new_context() -> None:
    context = ExecutionContext()
    assert context.get_rate() == 1000.0
    assert (context.overruns, context.longest) == (0, 0)
    assert context.is_running() is False
    assert context.participants == ()


def test_each_phase_runs_for_all_before_the_next() -> None:
    context, one, two, calls = of_two()
    activated(context, one, two)
    assert calls == [
        ("one", "on_activated", 1000),
        ("two", "on_activated", 1000),
        ("one", "on_execute", 1000),
        ("two", "on_execute", 1000),
        ("one", "on_state_update", 1000),
        ("two", "on_state_update", 1000),
    ]
    calls.clear()
    context.set_rate(10.0)
    two.failing = "on_execute"
    context.tick()
    assert calls == [
        ("one", "on_rate_changed", 1000),
        ("two", "on_rate_changed", 1000),
        ("one", "on_execute", 1000),
        ("two", "on_execute", 1000),
        ("two", "on_aborting", 1000),
        ("one", "on_state_update", 1000),
    ]
    assert two.reason == "on purpose"
    calls.clear()
    one.failing = "on_state_update"
    context.tick()
    assert calls == [
        ("one", "on_execute", 1000),
        ("two", "on_error", 1000),
        ("one", "on_state_update", 1000),
        ("one", "on_aborting", 1000),
    ]
    assert [p.state for p in context.participants] == [ERROR_STATE, ERROR_STATE]


def test_a_request_that_leads_into_error_ends_that_components_tick() -> None:
    context, one, two, calls = of_two()
    one.failing = "on_activated"
    activated(context, one, two)
    assert [call[:2] for call in calls] == [
        ("one", "on_activated"),
        ("one", "on_aborting"),
        ("two", "on_activated"),
        ("two", "on_execute"),
        ("two", "on_state_update"),
    ]


def test_ticks_are_calls_of_on_execute() -> None:
    context, one, two, _ = of_two()
    participants = context.participants
    activated(context, one)
    for _ in range(3):
        context.tick()
    assert [p.ticks for p in participants] == [4, 0]
    one.failing = "on_execute"
    for _ in range(3):
        context.tick()
    assert [p.ticks for p in participants] == [5, 0]
    context.remove_component(two)
    context.reset_component(one)
    context.tick()
    activated(context, one)
    assert [p.ticks for p in participants] == [6, 0]
    one.failing = ""
    context.reset_component(one)
    context.tick()
    activated(context, one)
    context.tick()
    assert [p.ticks for p in participants] == [8, 0]


def test_deferred_work_is_done_at_the_end_of_a_tick() -> None:
    context, one, two, calls = of_two()
    activated(context, one, two)
    calls.clear()

    def defer(callback: str) -> None:
        if callback == "on_execute":
            one._at_end_of_cycle(lambda: calls.append(("one", "chore", 0)))

    one.during = defer
    context.tick()
    assert context.remove_component(two) is PRECONDITION_NOT_MET
    assert [call[:2] for call in calls] == [
        ("one", "on_execute"),
        ("two", "on_execute"),
        ("one", "on_state_update"),
        ("two", "on_state_update"),
        ("one", "chore"),
    ]
    context.deactivate_component(two)
    context.tick()
    assert context.remove_component(two) is RTC_OK
    calls.clear()
    context.tick()
    assert [call[1] for call in calls] == ["on_execute", "on_state_update", "chore"]


def test_only_a_sole_component_of_one_context_is_ticked_without_a_loop() -> None:
    context, one, two, _ = of_two()
    loop = context.cycle
    assert context.remove_component(two) is RTC_OK
    [sole] = context.participants
    assert context.cycle == sole.cycle
    other = ExecutionContext()
    assert other.add_component(one) is RTC_OK
    assert context.cycle == loop
    assert other.cycle != other.participants[0].cycle


def test_a_context_learns_that_each_of_its_components_joined_another() -> None:
    calls: Calls = []
    one, two = Noting("one", calls), Noting("two", calls)
    first, second, both = (ExecutionContext() for _ in range(3))
    first.add_component(one)
    second.add_component(two)
    both.add_component(one)
    both.add_component(two)
    for context in (first, second):
        assert context.cycle != context.participants[0].cycle


def test_a_component_is_active_while_it_is_so_in_any_context() -> None:
    calls: Calls = []
    one = Noting("one", calls)
    contexts = [ExecutionContext() for _ in range(3)]
    for context in contexts:
        context.add_component(one)
        context.start()
    assert not one.is_active
    for context in contexts:
        activated(context, one)
        assert one.is_active
    contexts[0].deactivate_component(one)
    contexts[0].tick()
    assert one.is_active
    contexts[1].fail_component(one, "lost")
    contexts[1].tick()
    assert one.is_active
    contexts[2].deactivate_component(one)
    contexts[2].tick()
    assert not one.is_active
    contexts[1].reset_component(one)
    contexts[1].tick()
    assert not one.is_active
    activated(contexts[1], one)
    assert one.is_active


def test_what_is_put_around_ticks() -> None:
    context, one, two, calls = of_two()

    def around(cycle: Callable[[], None]) -> Callable[[], None]:
        def call() -> None:
            calls.append(("around", "begin", 0))
            cycle()
            calls.append(("around", "end", 0))

        return call

    context.put_around_ticks(around)
    activated(context, one)
    frame = [("around", "begin"), ("one", "on_activated"), ("one", "on_execute")]
    frame += [("one", "on_state_update"), ("around", "end")]
    assert [call[:2] for call in calls] == frame
    # Adding and removing components changes the calls in between.
    context.remove_component(two)
    calls.clear()
    context.tick()
    assert [call[:2] for call in calls] == [frame[0], *frame[2:]]


def test_a_scheduler_is_notified() -> None:
    driver = Driver()
    context, _, _, _ = of_two(driver=driver)
    assert {what for what, _ in driver.seen[:-1]} == {"cycle"}
    assert driver.seen[-1] == ("started", context)
    driver.seen.clear()
    context.set_rate(10.0)
    context.wake()
    context.put_around_ticks(lambda cycle: cycle)
    context.stop()
    context.wake()
    assert driver.seen == [
        (what, context) for what in ("rate", "woken", "cycle", "stopped")
    ]


def test_a_tick_that_does_not_end_keeps_on_shutdown_away() -> None:
    driver = Driver()
    context, _, _, calls = of_two(driver=driver)
    driver.ends = False
    assert context.stop() is RTC_ERROR
    assert calls == []
    assert context.is_running() is False
    assert context.stop() is PRECONDITION_NOT_MET


def test_input_between_ticks_is_for_active_components() -> None:
    context, _, two, calls = of_two()
    activated(context, two)
    calls.clear()
    context.between_ticks()
    assert calls == [("two", "arrived", 0)]


def test_input_between_ticks_that_fails() -> None:
    context, one, two, calls = of_two()
    activated(context, one, two)
    calls.clear()
    one.failing = "arrived"

    def defer(callback: str) -> None:
        one._at_end_of_cycle(lambda: calls.append(("one", "chore", 0)))

    one.during = defer
    context.between_ticks()
    assert [call[:2] for call in calls] == [
        ("one", "arrived"),
        ("one", "on_aborting"),
        ("one", "chore"),
        ("one", "chore"),
        ("two", "arrived"),
    ]
    assert context.get_component_state(one) is ERROR_STATE
    assert placeless(one.reason) == "on_execute: ValueError: bad input"


def test_listeners_get_both_states() -> None:
    seen: list[tuple[str, LifeCycleState, LifeCycleState]] = []
    context, one, _, _ = of_two(
        listener=lambda participant, before, now: seen.append(
            (participant.component.instance_name, before, now)
        )
    )
    activated(context, one)
    context.fail_component(one, "lost")
    context.tick()
    context.reset_component(one)
    context.tick()
    assert seen == [
        ("one", INACTIVE_STATE, ACTIVE_STATE),
        ("one", ACTIVE_STATE, ERROR_STATE),
        ("one", ERROR_STATE, INACTIVE_STATE),
    ]


def test_an_activation_is_pending_until_it_is_carried_out() -> None:
    context, one, _, _ = of_two()
    [first, second] = context.participants
    assert first.activating is False
    context.set_rate(10.0)
    assert first.activating is False
    context.activate_component(one)
    assert (first.activating, second.activating) == (True, False)
    one.gate = None
    context.tick()
    assert first.activating is True
    one.gate = RTC_OK
    context.set_rate(20.0)
    context.tick()
    assert first.activating is False
    context.deactivate_component(one)
    assert first.activating is False


def test_a_refused_activation_is_not_pending() -> None:
    context, one, _, _ = of_two()
    first = context.participants[0]
    one.gate = RTC_ERROR
    activated(context, one)
    assert first.state is ERROR_STATE
    assert first.activating is False


def test_an_activation_waits_for_its_provider_and_others_do_not() -> None:
    context, one, _, calls = of_two()
    first = context.participants[0]
    first.provider_awaited = lambda: "Server0"
    context.set_rate(10.0)
    activated(context, one)
    assert one._awaited == "Server0 to be activated"
    assert ("one", "on_rate_changed", 1000) in calls
    context.tick()
    assert first.state is INACTIVE_STATE
    assert first.activating
    first.provider_awaited = lambda: ""
    context.tick()
    assert first.state is ACTIVE_STATE
    assert one._awaited == ""


def test_what_is_awaited_is_forgotten_when_the_gate_is_asked_again() -> None:
    context, one, _, _ = of_two()
    one._awaited = "the bus"
    one.gate = None
    activated(context, one)
    assert one._awaited == ""


def test_a_gated_request_that_has_become_illegal_says_so(
    caplog: pytest.LogCaptureFixture,
) -> None:
    context, one, _, _ = of_two()
    activated(context, one)
    context.deactivate_component(one)
    context.fail_component(one, "lost")
    one.failing = "on_execute"
    one.gate = None
    with caplog.at_level(logging.WARNING, "rtgen.runtime"):
        context.tick()
        context.tick()
    # The deactivation waited for its gate; then the component was in ERROR.
    assert [r.getMessage() for r in caplog.records] == [
        "one: lost",
        "one: deactivate is ignored: the state is already ERROR",
    ]
    assert context.get_component_state(one) is ERROR_STATE


def test_a_request_whose_goal_is_reached_is_not_late(
    caplog: pytest.LogCaptureFixture,
) -> None:
    context, one, _, calls = of_two()
    participant = context.participants[0]
    context.activate_component(one)
    participant.enter(ACTIVE_STATE)
    with caplog.at_level(logging.WARNING, "rtgen.runtime"):
        context.tick()
        context.deactivate_component(one)
        participant.enter(INACTIVE_STATE)
        context.tick()
    assert caplog.records == []
    assert [call[1] for call in calls] == ["on_execute", "on_state_update"]


def test_a_failure_without_a_callback_has_no_reason_before() -> None:
    context, one, _, _ = of_two()
    [participant, _] = context.participants
    participant.request(Request.FAIL)
    context.tick()
    assert one.reason == ""
    assert participant.state is ERROR_STATE


def test_on_state_update_put_on_an_instance_is_called() -> None:
    calls: Calls = []

    class Plain(Component):
        pass

    plain = Plain("plain")
    plain.initialize()

    def update(handle: int) -> ReturnCode_t:
        calls.append(("plain", "on_state_update", handle))
        return RTC_OK

    plain.on_state_update = update  # type: ignore[method-assign]
    context = ExecutionContext(owner=plain)
    context.add_component(plain)
    context.start()
    activated(context, plain)
    assert calls == [("plain", "on_state_update", 0)]


def test_a_component_that_exits_leaves_a_context_of_others_running() -> None:
    context, one, two, calls = of_two()
    activated(context, one, two)
    calls.clear()
    assert one.exit() is RTC_OK
    assert calls == [("one", "on_deactivated", 1000), ("one", "on_shutdown", 1000)]
    assert context.is_running()
    assert [p.component for p in context.participants] == [two]
    calls.clear()
    context.tick()
    assert [call[0] for call in calls] == ["two", "two"]
    context.stop()
    calls.clear()
    assert two.exit() is RTC_OK
    assert calls == [("two", "on_deactivated", 1000)]


def test_an_owner_that_exits_stops_its_context_for_all() -> None:
    calls: Calls = []
    driver = Driver()
    owner, guest = Noting("owner", calls), Noting("guest", calls)
    context = ExecutionContext(owner=owner, driver=driver)
    for component in (owner, guest):
        context.add_component(component)
    context.start()
    activated(context, owner, guest)
    calls.clear()
    driver.seen.clear()
    assert owner.exit() is RTC_OK
    assert driver.seen[0] == ("stopped", context)
    assert calls == [
        ("owner", "on_deactivated", 0),
        ("owner", "on_shutdown", 0),
        ("guest", "on_shutdown", 1000),
    ]
    assert context.is_running() is False
    assert [p.component for p in context.participants] == [guest]
    assert context.tick() is PRECONDITION_NOT_MET


def test_an_owner_whose_tick_does_not_end() -> None:
    calls: Calls = []
    driver = Driver()
    owner = Noting("owner", calls)
    context = ExecutionContext(owner=owner, driver=driver)
    context.add_component(owner)
    context.start()
    activated(context, owner)
    calls.clear()
    driver.ends = False
    assert owner.exit() is RTC_ERROR
    assert calls == []
    assert not owner.is_alive()


def test_an_owner_outside_of_its_context_exits() -> None:
    calls: Calls = []
    owner = Noting("owner", calls)
    context = ExecutionContext(owner=owner)
    context.add_component(owner)
    context.start()
    assert context.remove_component(owner) is RTC_OK
    assert context._expel(owner) is True
    assert context.is_running()


@pytest.mark.parametrize("rate", [0.0, -1.0, math.inf, math.nan])
def test_a_rate_that_is_none(rate: float) -> None:
    with pytest.raises(RateError, match=f"the rate {rate!r} must be a number of Hz"):
        ExecutionContext(rate)
    assert ExecutionContext().set_rate(rate) is BAD_PARAMETER


@pytest.mark.parametrize("rate", [0.25, 1.0, 2, 1e6])
def test_any_rate_above_0(rate: float) -> None:
    context = ExecutionContext(rate)
    assert context.get_rate() == rate
    assert context.period == round(1e9 / rate)
    assert context.set_rate(rate / 2) is RTC_OK
    assert context.get_rate() == rate / 2


@pytest.mark.parametrize("kind", [ExecutionKind.EVENT_DRIVEN, ExecutionKind.OTHER])
def test_only_a_periodic_context_has_a_rate(kind: ExecutionKind) -> None:
    context = ExecutionContext(kind=kind)
    assert context.set_rate(10.0) is ReturnCode_t.UNSUPPORTED
    assert context.get_kind() is kind


def test_work_that_waits_at_the_end_of_a_run_is_removed_with_its_task() -> None:
    inside, go_on = threading.Event(), threading.Event()
    busy = Task("busy", SECOND, lambda: (inside.set(), go_on.wait(PATIENCE)))
    other = Task("other", SECOND, lambda: None)
    owner: Any = None
    runner = Runner("runner", RealClock(), owner)
    runner.add(busy, 0)
    runner.add(other, 10**6 * SECOND)
    runner.start()
    assert inside.wait(PATIENCE)
    runner.wake(other)
    runner.halt()
    go_on.set()
    assert runner.stop()
    assert runner.remove(other)
    assert runner.remove(busy)


def test_a_task_whose_work_takes_long_keeps_its_tick_of_that_instant() -> None:
    """The tick is due when the other tasks go on in a new thread: it is not called there."""
    inside, go_on, passed, ticked = (threading.Event() for _ in range(4))
    threads: list[int] = []

    def tick() -> None:
        threads.append(threading.get_ident())
        ticked.set()

    def work() -> None:
        inside.set()
        go_on.wait(PATIENCE)

    owner: Any = None
    runner = Runner("runner", RealClock(), owner)
    long = 10**6 * SECOND
    busy = Task("busy", long, tick, order=1, between=work)
    waker = Task("waker", long, lambda: runner.wake(busy), order=0)
    other = Task("other", long, passed.set, order=2)
    for task in (waker, busy, other):
        runner.add(task, 0)
    runner.start()
    assert inside.wait(PATIENCE)
    assert runner.busy is not None
    new = runner.hand_over(runner.busy, "busy", once=False)
    assert new is not None
    assert passed.wait(PATIENCE)
    assert not threads
    go_on.set()
    assert ticked.wait(PATIENCE)
    assert threads == [runner.ident]
    for each in (runner, new):
        assert each.stop()


def test_a_thread_that_wakes_late_leaves_out_what_passed_meanwhile() -> None:
    """Of the instants of 1, 2 and 3 ms at 3.5 ms, the first one is late, and the last made up."""
    ms = 1_000_000
    times = iter([0])
    ticks: list[int] = []
    overruns: list[tuple[int, str]] = []
    done = threading.Event()

    class Stalled(RealClock):
        def elapsed(self) -> int:
            return next(times, 3 * ms + ms // 2)

    def tick() -> None:
        assert task.lane is not None
        ticks.append(task.lane.due - ms)
        if len(ticks) == 2:
            done.set()

    task = Task("a", ms, tick, overrun=lambda *each: overruns.append(each))
    owner: Any = None
    runner = Runner("stalled", Stalled(), owner)
    runner.add(task, ms)
    runner.start()
    try:
        assert done.wait(PATIENCE)
    finally:
        assert runner.stop()
    assert ticks == [1 * ms, 3 * ms]
    assert overruns == [(1, MACHINE)]
