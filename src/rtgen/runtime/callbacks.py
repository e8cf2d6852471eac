"""Calling a component's callback: what counts as success, and where a failure is noted."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from rtgen.runtime.return_codes import RTC_ERROR, RTC_OK, ReturnCode_t

if TYPE_CHECKING:
    from rtgen.runtime.component import Component

log = logging.getLogger("rtgen.runtime")
log.addHandler(logging.NullHandler())


def succeeds(component: Component, callback: str, *arguments: int) -> bool:
    """Calls it; False if it returned anything but RTC_OK, or raised. The reason is noted."""
    try:
        code = getattr(component, callback)(*arguments)
    except Exception as error:
        note_exception(component, callback, error)
        return False
    if is_ok(code):
        return True
    note_answer(component, callback, code)
    return False


def is_ok(code: object) -> bool:
    """Whether a callback's answer is RTC_OK. None is not: whoever forgets the answer has failed."""
    return code is RTC_OK or (type(code) is int and code == RTC_OK)


def note_exception(component: Component, callback: str, error: Exception) -> None:
    """Notes that a callback raised."""
    log.debug("%s.%s", component.instance_name, callback, exc_info=error)
    told = str(error)
    _keep_answer(component, callback, RTC_ERROR)
    kind = type(error).__name__
    component._note_failure(callback, f"{kind}: {told}" if told else kind, forced=True)


def note_answer(component: Component, callback: str, code: object) -> None:
    """Notes that a callback returned something else than RTC_OK."""
    _keep_answer(component, callback, code)
    shown = getattr(code, "name", repr(code))
    component._note_failure(callback, f"returned {shown}")


def _keep_answer(component: Component, callback: str, code: object) -> None:
    # on_aborting follows upon another failure, which is the one to be told.
    if callback != "on_aborting":
        component._last_code = code if isinstance(code, ReturnCode_t) else RTC_ERROR
