"""The component base: ports, reasons of failures, and the size of the runtime."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path
from typing import ClassVar

import pytest
from runtime_samples import MS, SECOND, Actor, TimedLong, activated, placeless

from rtgen import runtime
from rtgen.runtime import (
    BAD_PARAMETER,
    ERROR_STATE,
    RTC_ERROR,
    RTC_OK,
    Component,
    ComponentProfile,
    DuplicatePortError,
    ReturnCode_t,
    System,
)
from rtgen.runtime.errors import RtcError


class Named(Component):
    profile: ClassVar[ComponentProfile] = ComponentProfile("Named")


def test_names_and_folder() -> None:
    assert Named().instance_name == "Named0"
    assert Named("n7").instance_name == "n7"
    assert Named().folder == Path()
    assert repr(Named()) == "<Named Named0>"


def test_ports_of_one_name_and_kind_are_refused() -> None:
    component = Named()
    port = component.add_in_port("status", TimedLong)
    component.add_out_port("status", TimedLong)
    assert component.in_ports == {"status": port}
    with pytest.raises(
        DuplicatePortError, match=r"Named0 has a port Named0.status already"
    ):
        component.add_in_port("status", TimedLong)
    with pytest.raises(DuplicatePortError):
        component.add_out_port("status", TimedLong)
    assert repr(port) == "<InPort Named0.status: TimedLong>"


def failing_by(execute: object) -> str:
    actor = Actor("a", execute)  # type: ignore[arg-type]
    actor.on_execute = lambda ec_id: actor.execute()  # type: ignore
    system = activated(System(), actor)
    system.run(until_ns=2 * MS)
    return system.statistics("a").reason


def raising(error: Exception) -> object:
    def execute() -> None:
        raise error

    return execute


def test_the_reason_of_a_failure() -> None:
    assert failing_by(lambda: RTC_ERROR) == "on_execute: returned RTC_ERROR"
    assert failing_by(lambda: BAD_PARAMETER) == "on_execute: returned BAD_PARAMETER"
    assert placeless(failing_by(lambda: None)) == "on_execute: returned None"
    assert placeless(failing_by(lambda: 7)) == "on_execute: returned 7"
    assert (
        placeless(failing_by(raising(ValueError("x")))) == "on_execute: ValueError: x"
    )
    assert failing_by(lambda: 0) == ""
    place = f"({Path(__file__).relative_to(Path.cwd())}:{raising.__code__.co_firstlineno + 2})"
    assert failing_by(raising(KeyError())) == f"on_execute {place}: KeyError"


def test_a_told_reason_is_kept_until_the_reset() -> None:
    actor = Actor("a")
    actor.execute = lambda: actor.fail("the goal is reached")
    system = activated(System(), actor)
    system.run(until_ns=3 * MS)
    assert system.statistics("a").reason == "the goal is reached"
    system.reset("a")
    system.run(until_ns=4 * MS)
    assert system.statistics("a").reason == ""


def test_what_fails_in_error_does_not_hide_the_reason() -> None:
    class Hopeless(Actor):
        def on_aborting(self, ec_id: int) -> ReturnCode_t:
            return RTC_ERROR

        def on_error(self, ec_id: int) -> ReturnCode_t:
            return self.fail("still broken")

    system = activated(System(), Hopeless("a", lambda: RTC_ERROR))
    system.run(until_ns=5 * MS)
    assert system.statistics("a").reason == "on_execute: returned RTC_ERROR"


def test_an_exception_after_a_told_reason_is_the_reason() -> None:
    actor = Actor("a")

    def execute() -> ReturnCode_t:
        actor.fail("told")
        raise ValueError("raised")

    actor.execute = execute
    system = activated(System(), actor)
    system.run(until_ns=MS)
    reason = placeless(system.statistics("a").reason)
    assert reason == "on_execute: ValueError: raised"


def test_a_failure_is_logged_with_its_traceback_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Stuck(Actor):
        def on_deactivated(self, ec_id: int) -> ReturnCode_t:
            raise ValueError("stuck")

    system = activated(System(), Stuck("a"))
    for _ in range(2):
        system.run(until_ns=system.time + MS)
        system.deactivate("a")
        system.run(until_ns=system.time + MS)
        system.activate("a")
    first, again = caplog.records
    assert first.getMessage() == "a.on_deactivated at 0.001 s: ValueError: stuck"
    assert (first.levelno, again.levelno) == (logging.ERROR, logging.WARNING)
    assert first.exc_info
    assert first.exc_info[1]
    assert not again.exc_info


def test_a_failure_at_every_tick_is_logged_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Stuck(Actor):
        def on_error(self, ec_id: int) -> ReturnCode_t:
            raise ValueError("stuck")

    system = activated(System(), Stuck("a", lambda: RTC_ERROR))
    with caplog.at_level(logging.INFO, "rtgen.runtime"):
        system.run(until_ns=100 * MS)
    assert [r.getMessage() for r in caplog.records] == [
        "a.on_execute at 0.000 s: on_execute: returned RTC_ERROR",
        "a.on_error at 0.001 s: ValueError: stuck",
    ]


def test_an_interrupt_in_a_callback_ends_the_run_and_is_its_reason() -> None:
    def interrupt() -> None:
        raise KeyboardInterrupt

    system = activated(System(), Actor("a", interrupt))
    with pytest.raises(KeyboardInterrupt):
        system.run(until_ns=MS)
    statistics = system.statistics("a")
    assert statistics.state is ERROR_STATE
    assert placeless(statistics.reason) == "on_execute: KeyboardInterrupt"
    assert not system.run(until_ns=2 * MS)


def test_a_component_outside_of_a_context() -> None:
    component = Named()
    assert component.exit() is not RTC_OK
    assert component.initialize() is RTC_OK
    assert component.is_alive()
    assert component.get_context(0) is None
    assert component.detach_context(3) is BAD_PARAMETER
    assert component.exit() is RTC_OK
    assert not component.is_alive()


def test_seconds_are_nanoseconds() -> None:
    assert runtime.SECOND == SECOND


def test_every_error_has_one_base() -> None:
    names = [
        name
        for name in runtime.__all__
        if name.endswith("Error") and name != "ServiceError"
    ]
    assert len(names) > 15
    for name in names:
        error = getattr(runtime, name)
        assert issubclass(error, RtcError)
        assert error.__doc__


def test_importing_the_runtime_is_light() -> None:
    heavy = "asyncio black click jinja2 lark lxml platformdirs rich rtgen.model rtgen.frontends"
    code = (
        "import sys, rtgen.runtime\n"
        f"print([name for name in {heavy.split()} if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"
