"""Failing callbacks: every callback, every kind of failure, both clocks."""

from __future__ import annotations

import logging
import re
from bdb import BdbQuit
from collections.abc import Callable
from pathlib import Path

import pytest
from patience import until

from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    RTC_ERROR,
    RTC_OK,
    Clock,
    Component,
    ComponentProfile,
    Failure,
    InitializationError,
    RealClock,
    ReturnCode_t,
    ReturnValueError,
    SimulatedClock,
    System,
)

MS = 1_000_000


class Odd(BaseException):
    pass


class UnprintableError(Exception):
    def __str__(self) -> str:
        raise RuntimeError("no text")


KINDS: dict[str, BaseException | str] = {
    "Exception": ValueError("bad luck"),
    "unprintable": UnprintableError(),
    "SystemExit": SystemExit(3),
    "BaseException": Odd("odd"),
    "KeyboardInterrupt": KeyboardInterrupt(),
    "BdbQuit": BdbQuit(),
    "answer": "RTC_OK",
}
INTO_ERROR = ("on_activated", "on_execute", "on_state_update", "on_rate_changed")
CALLBACKS = (
    "on_initialize",
    "on_startup",
    *INTO_ERROR,
    "on_aborting",
    "on_error",
    "on_reset",
    "on_deactivated",
    "on_shutdown",
    "on_finalize",
)

AT_THE_END = ("on_deactivated", "on_shutdown", "on_finalize")
MAX_DURATION = 120_000 * MS


class Naughty(Component):
    """A component that fails in one callback; for a callback of ERROR it enters ERROR first."""

    profile = ComponentProfile("Naughty", rate=1000.0)

    def __init__(self, callback: str, kind: BaseException | str) -> None:
        super().__init__("n0")
        self.callback = callback
        self.called: list[str] = []
        self.kind = kind

    def fails(self, callback: str) -> object:
        self.called.append(callback)
        if callback == self.callback:
            if isinstance(self.kind, BaseException):
                raise self.kind
            return self.kind
        into_error = self.callback in ("on_aborting", "on_error", "on_reset")
        if callback == "on_execute" and into_error:
            return RTC_ERROR
        if callback == "on_execute" and self.callback == "on_rate_changed":
            context = self.get_context(0)
            assert context is not None
            context.set_rate(500.0)
        return RTC_OK


def _calling(callback: str) -> Callable[..., object]:
    def call(self: Naughty, *_: int) -> object:
        return self.fails(callback)

    return call


for _name in CALLBACKS:
    setattr(Naughty, _name, _calling(_name))


@pytest.mark.parametrize("clock", [SimulatedClock, RealClock])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("callback", CALLBACKS)
def test_a_failure_is_reported_once_and_only_interrupts_end_the_run(
    callback: str, kind: str, clock: type[Clock], caplog: pytest.LogCaptureFixture
) -> None:
    what = KINDS[kind]
    component = Naughty(callback, what)
    failures: list[Failure] = []
    system = System(clock())
    system.on_failure = failures.append
    interrupts = kind in ("KeyboardInterrupt", "BdbQuit")
    if callback == "on_initialize":
        expected = type(what) if interrupts else InitializationError
        with pytest.raises(expected) as caught:
            system.add(component)
        if not interrupts:
            assert isinstance(
                caught.value.__cause__,
                type(what) if what != "RTC_OK" else ReturnValueError,
            )
        return
    system.add(component)
    system.activate("n0")
    in_run = callback not in AT_THE_END

    def has_failed(_: System) -> bool:
        """Return whether it has; an interrupt ends the run instead."""
        if not in_run:
            return "on_execute" in component.called
        return not interrupts and any(f.callback == callback for f in failures)

    raised: BaseException | None = None
    try:
        if callback == "on_reset":
            system.run(MAX_DURATION, lambda _: "on_error" in component.called)
            system.reset("n0")
        system.run(MAX_DURATION, has_failed)
        system.run(system.time + 3 * MS)
    except BaseException as error:
        raised = error
    if callback in (*INTO_ERROR, "on_reset"):
        until(lambda: system.state("n0") is ERROR_STATE)
    reason = system.statistics("n0").reason
    system.close()
    assert callback in component.called
    if interrupts and in_run:
        assert raised is what
    else:
        assert raised is None
    own = [f for f in failures if f.callback == callback]
    assert [f.repeated for f in own] == [False] + [True] * (len(own) - 1)
    assert own[0].instance == "n0"
    if isinstance(what, BaseException):
        assert own[0].error is what
    else:
        assert isinstance(own[0].error, ReturnValueError)
        assert own[0].error.code is not None
        assert own[0].error.code.co_filename == __file__
    if callback in INTO_ERROR:
        place = rf"\(\S*{Path(__file__).name}:\d+\)"
        assert re.match(rf"{callback} {place}: ", reason)
    assert not component.is_alive()
    assert component.called[-1] == "on_finalize"


def test_the_logger_gets_a_failure_that_nobody_else_takes(
    caplog: pytest.LogCaptureFixture,
) -> None:
    system = System()
    system.add(Naughty("on_execute", KINDS["SystemExit"]))
    system.activate("n0")
    system.run(until_ns=3 * MS)
    [record] = caplog.records
    assert record.levelno == logging.ERROR
    assert record.getMessage() == "n0.on_execute at 0.000 s: SystemExit: 3"
    assert record.exc_info
    assert record.exc_info[1] is KINDS["SystemExit"]


def test_the_logger_gets_the_place_where_a_callback_without_an_answer_is(
    caplog: pytest.LogCaptureFixture,
) -> None:
    system = System()
    system.add(Naughty("on_execute", "nothing"))
    system.activate("n0")
    system.run(until_ns=3 * MS)
    [record] = caplog.records
    assert "returned 'nothing', which is not a ReturnCode_t" in record.getMessage()
    assert f"({__file__}, line " in record.getMessage()


@pytest.mark.parametrize("clock", [SimulatedClock, RealClock])
def test_a_listener_that_raises_ends_the_run_and_no_component_is_blamed(
    clock: type[Clock],
) -> None:
    def listen(record: object) -> None:
        raise OSError("disk full")

    system = System(clock())
    system.add(Naughty("", ""))
    system.activate("n0")
    system.add_listener(listen)
    with pytest.raises(OSError, match="disk full"):
        system.run(until_ns=500 * MS)
    assert system.state("n0") is ACTIVE_STATE
    system.remove_listener(listen)
    system.close()


def test_a_context_without_a_system_raises_an_interrupt_after_its_tick() -> None:
    from rtgen.runtime import ExecutionContext

    component = Naughty("on_execute", KINDS["KeyboardInterrupt"])
    component.initialize()
    context = ExecutionContext()
    context.add_component(component)
    context.start()
    context.activate_component(component)
    with pytest.raises(KeyboardInterrupt):
        context.tick()
    assert context.get_component_state(component) is ERROR_STATE
    assert context.tick() is ReturnCode_t.RTC_OK
