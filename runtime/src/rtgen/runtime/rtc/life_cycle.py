"""The life cycle of OMG RTC 1.0 as a table from state and request to callback and next state.

`docs/life-cycle.md` has the same table with return codes; tests compare them.
"""

from __future__ import annotations

from enum import StrEnum

import msgspec

from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    LifeCycleState,
)


class Request(StrEnum):
    """Requests to a component in an execution context, and events in it."""

    INITIALIZE = "initialize"
    STARTUP = "start"
    SHUTDOWN = "stop"
    ACTIVATE = "activate"
    DEACTIVATE = "deactivate"
    RESET = "reset"
    RATE_CHANGE = "set_rate"
    EXECUTE = "tick"
    STATE_UPDATE = "state_update"
    FINALIZE = "finalize"
    FAIL = "fail"


GATED = frozenset({Request.ACTIVATE, Request.DEACTIVATE, Request.RESET})
"""Requests that wait until the component's gate allows them (`Component._gate`)."""


class Transition(msgspec.Struct, frozen=True, gc=False):
    """The callback of a legal request, and the states after success and failure.

    Without a callback the request succeeds.
    """

    callback: str
    success: LifeCycleState
    failure: LifeCycleState


_ALIVE = (INACTIVE_STATE, ACTIVE_STATE, ERROR_STATE)

TRANSITIONS: dict[tuple[LifeCycleState, Request], Transition] = {
    (CREATED_STATE, Request.INITIALIZE): Transition(
        "on_initialize", INACTIVE_STATE, CREATED_STATE
    ),
    (INACTIVE_STATE, Request.ACTIVATE): Transition(
        "on_activated", ACTIVE_STATE, ERROR_STATE
    ),
    (ACTIVE_STATE, Request.EXECUTE): Transition(
        "on_execute", ACTIVE_STATE, ERROR_STATE
    ),
    (ACTIVE_STATE, Request.STATE_UPDATE): Transition(
        "on_state_update", ACTIVE_STATE, ERROR_STATE
    ),
    (ACTIVE_STATE, Request.DEACTIVATE): Transition(
        "on_deactivated", INACTIVE_STATE, INACTIVE_STATE
    ),
    (ERROR_STATE, Request.EXECUTE): Transition("on_error", ERROR_STATE, ERROR_STATE),
    (ERROR_STATE, Request.RESET): Transition("on_reset", INACTIVE_STATE, ERROR_STATE),
    **{
        (state, Request.RATE_CHANGE): Transition("on_rate_changed", state, ERROR_STATE)
        for state in _ALIVE
    },
    **{
        (state, Request.STARTUP): Transition("on_startup", state, state)
        for state in _ALIVE
    },
    **{
        (state, Request.SHUTDOWN): Transition("on_shutdown", state, state)
        for state in _ALIVE
    },
    **{
        (state, Request.FAIL): Transition("", ERROR_STATE, ERROR_STATE)
        for state in (INACTIVE_STATE, ACTIVE_STATE)
    },
    (INACTIVE_STATE, Request.FINALIZE): Transition(
        "on_finalize", CREATED_STATE, CREATED_STATE
    ),
}
"""Legal requests; all others are rejected with PRECONDITION_NOT_MET and without effect.

Entering ERROR from another state calls `on_aborting`. A rejecting gate leads to ERROR.
"""
