"""The life cycle of a behaviour in OpenRTM: OMG's, with OpenRTM's return codes and times."""

from __future__ import annotations

import logging
import re
import threading
from collections.abc import Iterator
from typing import Any

import middleware
import pytest
from hosting import Relay
from openrtm_lab import Lab
from patience import until

from rtgen.runtime import BAD_PARAMETER, RTC_ERROR, RTC_OK, ReturnCode_t
from rtgen.runtime.rtc.life_cycle import Request

CYCLE = ["on_execute", "on_state_update"]


def raising() -> ReturnCode_t:
    raise ValueError("broken")


def test_callbacks_come_one_to_one(relay: Relay, lab: Lab) -> None:
    assert relay.behaviour.calls == [("on_initialize",), ("on_startup", 0)]
    lab.activate(relay.rtc)
    assert relay.behaviour.calls[2] == ("on_activated", 0)
    assert relay.tick() == CYCLE
    assert relay.behaviour.calls[-1] == ("on_state_update", 0)
    lab.deactivate(relay.rtc)
    assert "on_deactivated" in relay.calls
    relay.behaviour.calls.clear()
    relay.rtc.exit()
    assert relay.calls == ["on_shutdown", "on_finalize"]
    lab.made.remove(relay.rtc)


def test_a_behaviour_that_has_ended_is_not_called(relay: Relay, lab: Lab) -> None:
    """OpenRTM finalizes a component before it stops its context, which goes on ticking."""
    relay.activate()
    relay.answer("on_execute", RTC_ERROR)
    relay.tick()
    relay.tick()
    assert relay.state == "ERROR_STATE"
    relay.behaviour.calls.clear()
    assert str(relay.rtc.onFinalize()) == "RTC_OK"
    assert relay.calls == ["on_shutdown", "on_finalize"]
    relay.behaviour.calls.clear()
    assert relay.tick() == []
    for name in (
        *("onStartup", "onActivated", "onExecute", "onStateUpdate", "onDeactivated"),
        *("onAborting", "onError", "onReset", "onRateChanged", "onShutdown"),
    ):
        assert str(getattr(relay.rtc, name)(0)) == "RTC_OK"
    assert relay.calls == []


def test_the_component_has_the_instance_name_and_real_time(relay: Relay) -> None:
    assert relay.behaviour.instance_name == relay.rtc.getInstanceName()
    assert relay.behaviour.network is None
    assert relay.behaviour.now() > 1_600_000_000 * 10**9


def test_of_two_components_each_has_its_own_behaviour(relay: Relay, lab: Lab) -> None:
    other = lab.create("Relay?instance_name=Other&rtgen.folder=/somewhere")
    assert other._host.behaviour is not relay.behaviour
    assert other._host.behaviour.instance_name == "Other"
    assert str(other._host.behaviour.folder) == "/somewhere"


@pytest.mark.parametrize("answer", [RTC_ERROR, BAD_PARAMETER, None, raising])
@pytest.mark.parametrize("callback", CYCLE)
def test_an_error_goes_omgs_way(relay: Relay, callback: str, answer: Any) -> None:
    relay.activate()
    relay.answer(callback, answer)
    assert relay.tick()[-2:] == [callback, "on_aborting"]
    assert relay.behaviour.reason.startswith(callback)
    # OpenRTM's onDeactivated and onAborting do not get through.
    assert relay.tick() == ["on_error"]
    assert relay.state == "ERROR_STATE"
    assert relay.tick() == ["on_error"]
    assert "on_deactivated" not in relay.calls


@pytest.mark.parametrize(
    ("answer", "code"),
    [
        (RTC_OK, "RTC_OK"),
        (RTC_ERROR, "RTC_ERROR"),
        (BAD_PARAMETER, "BAD_PARAMETER"),
        (None, "RTC_ERROR"),
        (raising, "RTC_ERROR"),
        (5, "RTC_ERROR"),
    ],
)
@pytest.mark.parametrize(
    "callback", ["on_activated", "on_execute", "on_state_update", "on_rate_changed"]
)
def test_return_codes_are_those_of_the_behaviour(
    relay: Relay, callback: str, answer: Any, code: str
) -> None:
    if callback in CYCLE:
        relay.activate()
    relay.answer("on_aborting", RTC_ERROR)
    relay.answer(callback, answer)
    name = f"on{''.join(word.capitalize() for word in callback.split('_')[1:])}"
    assert str(getattr(relay.rtc, name)(0)) == code


def test_reset_may_fail(relay: Relay, lab: Lab) -> None:
    relay.activate()
    relay.answer("on_execute", RTC_ERROR)
    relay.tick()
    relay.tick()
    relay.answer("on_reset", RTC_ERROR)
    lab.reset(relay.rtc)
    relay.tick()
    assert relay.state == "ERROR_STATE"
    assert "on_reset" in relay.calls
    relay.answer("on_reset", RTC_OK)
    lab.reset(relay.rtc)
    assert relay.state == "INACTIVE_STATE"
    assert relay.behaviour.reason == ""


def test_a_component_that_is_not_activated_is_in_error(relay: Relay, lab: Lab) -> None:
    relay.answer("on_activated", raising)
    lab.activate(relay.rtc)
    relay.tick()
    assert relay.state == "ERROR_STATE"
    assert relay.behaviour.reason.startswith("on_activated (tests/openrtm/")
    assert relay.behaviour.reason.endswith("): ValueError: broken")
    assert relay.calls.count("on_aborting") == 1
    assert "on_deactivated" not in relay.calls


@pytest.mark.sampled(1)
def test_what_fails_at_the_beginning_is_no_component(
    relay_module: Any, lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    behaviour = relay_module.RelayBehaviour

    class Failing(behaviour):  # type: ignore[misc, valid-type]
        def on_initialize(self) -> ReturnCode_t:
            code: ReturnCode_t = self.fail("no such device")
            return code

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(relay_module, "RelayBehaviour", Failing)
        with caplog.at_level(logging.WARNING, "rtgen.runtime"):
            assert lab.create("Relay?instance_name=Failing0") is None
    assert re.search(r"Failing0.on_initialize at .* s: no such device", caplog.text)


def test_the_end_comes_in_order(relay: Relay, lab: Lab) -> None:
    relay.activate()
    relay.rtc.exit()
    lab.made.remove(relay.rtc)
    assert [name for name in relay.calls if name not in CYCLE] == [
        "on_deactivated",
        "on_shutdown",
        "on_finalize",
    ]


def test_a_rate_is_notified_at_a_tick(relay: Relay, lab: Lab) -> None:
    rates = []

    def changed() -> ReturnCode_t:
        context = relay.behaviour.get_context(0)
        rates.append(context.get_rate())
        return RTC_OK

    relay.activate()
    relay.answer("on_rate_changed", changed)
    assert str(lab.context(relay.rtc).set_rate(20.0)) == "RTC_OK"
    assert "on_rate_changed" not in relay.calls
    assert relay.tick() == ["on_rate_changed", *CYCLE]
    assert rates == [20.0]
    relay.answer("on_rate_changed", RTC_ERROR)
    lab.context(relay.rtc).set_rate(30.0)
    assert relay.tick()[:2] == ["on_rate_changed", "on_aborting"]


def test_an_inactive_component_is_notified_of_a_rate_at_once(
    relay: Relay, lab: Lab
) -> None:
    lab.context(relay.rtc).set_rate(20.0)
    assert relay.calls[-1] == "on_rate_changed"


def test_start_and_stop_of_the_context(relay: Relay, lab: Lab) -> None:
    relay.activate()
    context = lab.context(relay.rtc)
    assert str(context.stop()) == "RTC_OK"
    assert not relay.behaviour.get_context(0).is_running()
    assert str(context.start()) == "RTC_OK"
    assert relay.behaviour.get_context(0).is_running()
    assert [c for c in relay.calls if c not in CYCLE] == ["on_shutdown", "on_startup"]
    assert relay.state == "ACTIVE_STATE"


def test_a_failure_from_outside(relay: Relay) -> None:
    relay.activate()
    relay.behaviour._request_failure("the cable is cut")
    assert relay.tick() == ["on_aborting"]
    relay.tick()
    assert relay.state == "ERROR_STATE"
    assert relay.behaviour.reason == "the cable is cut"


@pytest.fixture
def ticking(relay: Relay) -> Iterator[None]:
    """Tick the component's context meanwhile, as a periodic one does."""
    ended = threading.Event()

    def run() -> None:
        while not ended.wait(0.002):
            relay.lab.tick(relay.rtc)

    thread = threading.Thread(target=run)
    thread.start()
    yield
    ended.set()
    thread.join()


def test_a_failure_of_an_inactive_component(relay: Relay, ticking: None) -> None:
    relay.behaviour._request_failure("the cable is cut")
    until(lambda: relay.state == "ERROR_STATE")
    assert relay.behaviour.reason == "the cable is cut"
    assert "on_activated" not in relay.calls


def test_openrtm_follows_the_behaviour(relay: Relay, ticking: None) -> None:
    context = relay.behaviour.get_context(0)
    context.activate_component(relay.behaviour)
    until(lambda: relay.state == "ACTIVE_STATE")
    assert relay.calls.count("on_activated") == 1
    context.deactivate_component(relay.behaviour)
    until(lambda: relay.state == "INACTIVE_STATE")
    assert relay.calls.count("on_deactivated") == 1
    relay.behaviour._request_failure("wanted")
    until(lambda: relay.state == "ERROR_STATE")
    context.reset_component(relay.behaviour)
    until(lambda: relay.state == "INACTIVE_STATE")
    assert relay.calls.count("on_reset") == 1


class Gate:
    """A gate that lets a request pass on command."""

    def __init__(self, relay: Relay) -> None:
        self.code: ReturnCode_t | None = None
        self.asked: list[Request] = []
        relay.behaviour._gate = self

    def __call__(self, request: Request) -> ReturnCode_t | None:
        self.asked.append(request)
        return self.code


def test_what_takes_long_goes_on_behind_openrtm(relay: Relay, lab: Lab) -> None:
    gate = Gate(relay)
    lab.activate(relay.rtc)
    assert relay.state == "ACTIVE_STATE"
    assert not relay.behaviour.is_active
    assert relay.tick() == []
    gate.code = RTC_OK
    assert relay.tick()[:1] == ["on_activated"]
    assert relay.behaviour.is_active
    gate.code = None
    lab.deactivate(relay.rtc)
    assert relay.state == "INACTIVE_STATE"
    assert relay.behaviour.is_active
    gate.code = RTC_OK
    until(lambda: not relay.behaviour.is_active)
    assert relay.calls[-1] == "on_deactivated"


def test_what_does_not_come_to_pass_is_an_error(relay: Relay, ticking: None) -> None:
    gate = Gate(relay)
    relay.lab.activate(relay.rtc)
    gate.code = RTC_ERROR
    until(lambda: relay.state == "ERROR_STATE")
    assert "on_activated" not in relay.calls


def test_a_wait_for_activation_can_be_ended(relay: Relay, lab: Lab) -> None:
    gate = Gate(relay)
    lab.activate(relay.rtc)
    lab.deactivate(relay.rtc)
    asked = len(gate.asked)
    gate.code = RTC_OK
    assert relay.tick() == []
    assert relay.state == "INACTIVE_STATE"
    assert not relay.behaviour.is_active
    assert len(gate.asked) == asked


@pytest.mark.skipif(middleware.REAL, reason="the stub's log is Python's")
def test_reasons_go_to_the_managers_log(
    relay: Relay, caplog: pytest.LogCaptureFixture
) -> None:
    relay.activate()
    relay.answer("on_execute", lambda: relay.behaviour.fail("100 % wrong"))
    relay.tick()
    [record] = [r for r in caplog.records if r.name == "openrtm.rtgen"]
    what = rf"{relay.behaviour.instance_name}\.on_execute at [\d.]+ s: 100 % wrong"
    assert re.fullmatch(what, record.getMessage())


@pytest.mark.skipif(middleware.REAL, reason="the stub's log is Python's")
@pytest.mark.parametrize("error", [ValueError("broken"), SystemExit(3)])
def test_tracebacks_go_to_the_managers_log(
    relay: Relay, caplog: pytest.LogCaptureFixture, error: BaseException
) -> None:
    def fail() -> ReturnCode_t:
        raise error

    relay.activate()
    relay.answer("on_execute", fail)
    relay.tick()
    assert not relay.behaviour.is_active
    log = "\n".join(r.getMessage() for r in caplog.records if r.name == "openrtm.rtgen")
    assert f'File "{__file__}", line ' in log
    assert f"{type(error).__name__}: {error}" in log
