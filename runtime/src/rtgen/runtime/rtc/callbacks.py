"""Calls a component's callbacks, and reports their failures."""

from __future__ import annotations

from types import CodeType
from typing import Protocol

from rtgen.runtime.errors import EndOfRunError, ParametersError, ReturnValueError
from rtgen.runtime.failures import failed_call
from rtgen.runtime.return_codes import RTC_ERROR, RTC_OK, ReturnCode_t

_CODES = frozenset(map(int, ReturnCode_t))


class CallbackOwner(Protocol):
    """The attributes of a component that callers of its callbacks use."""

    _last_code: ReturnCode_t

    def _failed(
        self, callback: str, what: str, error: BaseException | None = None
    ) -> None: ...


def succeeds(component: CallbackOwner, callback: str, *arguments: int) -> bool:
    """Call a callback; False, with a report, if it raised or returned anything but RTC_OK.

    One that the end of the run has cut short succeeds, so that what follows it at the end happens.
    """
    try:
        code = getattr(component, callback)(*arguments)
    except EndOfRunError:
        return True
    except BaseException as error:
        note_exception(component, callback, error)
        return False
    if is_ok(code):
        return True
    note_answer(component, callback, code)
    return False


def is_ok(code: object) -> bool:
    """Return whether a callback's result is RTC_OK; None, a forgotten return value, is not."""
    return code is RTC_OK or (type(code) is int and code == RTC_OK)


def note_exception(
    component: CallbackOwner, callback: str, error: BaseException
) -> None:
    """Report an exception of a callback."""
    _keep_answer(component, callback, RTC_ERROR)
    trace = error.__traceback__
    if isinstance(error, TypeError) and trace is not None and trace.tb_next is None:
        # The call itself failed, so there is no frame of the callback.
        error = ParametersError(str(error), _code(component, callback))
    component._failed(callback, failed_call(callback, error), error)


def note_answer(component: CallbackOwner, callback: str, code: object) -> None:
    """Report that a callback did not return RTC_OK."""
    _keep_answer(component, callback, code)
    if isinstance(code, ReturnCode_t) or (type(code) is int and code in _CODES):
        component._failed(callback, f"{callback}: returned {ReturnCode_t(code).name}")
        return
    error = ReturnValueError(repr(code), _code(component, callback))
    what = failed_call(callback, error, f"returned {code!r}")
    component._failed(callback, what, error)


def _code(component: CallbackOwner, callback: str) -> CodeType | None:
    function = getattr(component, callback, None)
    code: CodeType | None = getattr(function, "__code__", None)
    return code


def _keep_answer(component: CallbackOwner, callback: str, code: object) -> None:
    # on_aborting is called after another failure, which is the one to report.
    if callback != "on_aborting":
        component._last_code = code if isinstance(code, ReturnCode_t) else RTC_ERROR
