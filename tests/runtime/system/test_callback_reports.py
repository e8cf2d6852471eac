"""Reports of failing callbacks, and the return code that OpenRTM's answer has."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from runtime_samples import placeless

from rtgen.runtime import (
    BAD_PARAMETER,
    RTC_ERROR,
    RTC_OK,
    ParametersError,
    ReturnCode_t,
    ReturnValueError,
)
from rtgen.runtime.rtc.callbacks import succeeds


class Owner:
    """Has callbacks, and stores the reports."""

    def __init__(self) -> None:
        self._last_code = RTC_OK
        self.reports: list[tuple[str, str, BaseException | None]] = []
        self.answer: object = RTC_OK

    def _failed(
        self, callback: str, what: str, error: BaseException | None = None
    ) -> None:
        self.reports.append((callback, what, error))

    def on_execute(self, ec_id: int) -> object:
        if isinstance(self.answer, BaseException):
            raise self.answer
        return self.answer

    on_aborting = on_execute

    def on_error(self) -> ReturnCode_t:
        return RTC_OK

    on_reset = dict
    """A callback without Python code; it rejects a number."""


def _line(function: Callable[..., object]) -> int:
    return function.__code__.co_firstlineno


@pytest.mark.parametrize("answer", [RTC_OK, 0])
def test_success(answer: object) -> None:
    owner = Owner()
    owner.answer = answer
    assert succeeds(owner, "on_execute", 0)
    assert owner.reports == []
    assert owner._last_code is RTC_OK


@pytest.mark.parametrize(
    ("answer", "kept", "name"),
    [
        (BAD_PARAMETER, BAD_PARAMETER, "BAD_PARAMETER"),
        (RTC_ERROR, RTC_ERROR, "RTC_ERROR"),
        (2, RTC_ERROR, "BAD_PARAMETER"),
    ],
)
def test_another_code(answer: object, kept: ReturnCode_t, name: str) -> None:
    owner = Owner()
    owner.answer = answer
    assert not succeeds(owner, "on_execute", 0)
    assert owner.reports == [("on_execute", f"on_execute: returned {name}", None)]
    assert owner._last_code is kept


@pytest.mark.parametrize("answer", [None, False, 99, "RTC_OK", 2.0])
def test_no_code(answer: object) -> None:
    owner = Owner()
    owner.answer = answer
    assert not succeeds(owner, "on_execute", 0)
    [(callback, what, error)] = owner.reports
    place = f"(tests/runtime/system/{Path(__file__).name}:{_line(Owner.on_execute)})"
    assert callback == "on_execute"
    assert what == f"on_execute {place}: returned {answer!r}"
    assert isinstance(error, ReturnValueError)
    assert repr(answer) in str(error)
    assert error.code is Owner.on_execute.__code__
    assert owner._last_code is RTC_ERROR


def test_an_exception() -> None:
    owner = Owner()
    owner.answer = TypeError("of the callback itself")
    assert not succeeds(owner, "on_execute", 0)
    [(callback, what, error)] = owner.reports
    assert callback == "on_execute"
    assert placeless(what) == "on_execute: TypeError: of the callback itself"
    assert error is owner.answer
    assert owner._last_code is RTC_ERROR


@pytest.mark.parametrize("answer", [BAD_PARAMETER, None, ValueError("x")])
def test_the_code_of_the_failure_before_on_aborting_is_kept(answer: object) -> None:
    owner = Owner()
    owner.answer = answer
    owner._last_code = ReturnCode_t.UNSUPPORTED
    assert not succeeds(owner, "on_aborting", 0)
    assert len(owner.reports) == 1
    assert owner._last_code is ReturnCode_t.UNSUPPORTED


def test_parameters_that_do_not_fit_lead_to_the_callback() -> None:
    owner = Owner()
    assert not succeeds(owner, "on_error", 0)
    [(callback, what, error)] = owner.reports
    assert callback == "on_error"
    assert isinstance(error, ParametersError)
    assert str(error) == "Owner.on_error() takes 1 positional argument but 2 were given"
    assert placeless(what) == f"on_error: ParametersError: {error}"
    assert error.code is Owner.on_error.__code__


def test_a_callback_without_code_of_its_own() -> None:
    owner = Owner()
    assert not succeeds(owner, "on_reset", 0)
    [(_, what, error)] = owner.reports
    assert what == "on_reset: ParametersError: 'int' object is not iterable"
    assert isinstance(error, ParametersError)
    assert error.code is None


def test_another_exception_of_the_call_itself_is_reported_as_it_is() -> None:
    owner = Owner()
    assert not succeeds(owner, "on_missing", 0)
    [(_, _, error)] = owner.reports
    assert type(error) is AttributeError
