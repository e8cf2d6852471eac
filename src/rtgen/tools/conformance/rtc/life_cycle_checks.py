"""Checks of the execution contexts and the life cycle of a running component."""

from __future__ import annotations

from itertools import combinations
from math import isclose
from typing import Any, Final

from rtgen.runtime.corba.rt_objects.wire import DATA_FLOW_COMPONENT
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    BAD_PARAMETER,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_OK,
    ExecutionKind,
    ReturnCode_t,
)
from rtgen.tools.conformance.check import (
    ACTUATE,
    Permission,
    Problems,
    SkipError,
    check,
    unequal,
)
from rtgen.tools.conformance.rtc.component import RtcUnderTest

_CONTEXTS: Final = "OMG RTC 1.0, 5.2.2.6 (ExecutionContext)"
_LIFE: Final = "OMG RTC 1.0, 5.2.2.3 (LifeCycleState)"
_MAX_HANDLES: Final = 999
"""The highest handle of an own context in OpenRTM."""
_RATE_TOLERANCE: Final = 1e-3
"""OpenRTM computes rates from periods."""
_TICKS: Final = 3
"""Ticks of a context within which a request takes effect."""
_Row = tuple[str, ReturnCode_t]
"""An operation of an execution context, with the expected return code."""
_FIRST: Final[tuple[_Row, ...]] = (
    ("deactivate_component", PRECONDITION_NOT_MET),
    ("reset_component", PRECONDITION_NOT_MET),
)
_WHILE_ACTIVE: Final[tuple[_Row, ...]] = (
    ("activate_component", PRECONDITION_NOT_MET),
    ("reset_component", PRECONDITION_NOT_MET),
)
_IN_ERROR: Final[tuple[_Row, ...]] = (
    ("activate_component", PRECONDITION_NOT_MET),
    ("deactivate_component", PRECONDITION_NOT_MET),
)


@check("contexts.kind", "it owns a context of the declared kind", _CONTEXTS)
def context_kinds(rtc: RtcUnderTest) -> Problems:
    """Check that the component owns a context of the declared kind, and its profile agrees."""
    if not rtc.contexts:
        yield "it owns no execution context"
    for number, context in enumerate(rtc.contexts):
        kind = rtc.ask(context, "get_kind")
        if number == 0 and rtc.expected.is_periodic:
            yield unequal("the kind", kind.name, ExecutionKind.PERIODIC.name)
        if kind is ExecutionKind.PERIODIC:
            rate = rtc.ask(context, "get_rate")
            yield None if rate > 0 else f"the rate is {rate} Hz"


@check("contexts.profile", "contexts report kind, rate and owner", _CONTEXTS)
def context_profiles(rtc: RtcUnderTest) -> Problems:
    """Check that the profile of a context has its kind, its rate and its owner."""
    for context in rtc.contexts:
        profile = rtc.ask(context, "get_profile")
        yield unequal("its kind", profile.kind, rtc.ask(context, "get_kind"))
        yield unequal("its rate", profile.rate, rtc.ask(context, "get_rate"))
        owned = profile.owner is not None and profile.owner._is_equivalent(
            rtc.reference
        )
        yield None if owned else "its owner is another component"
        others = [each for each in profile.participants if each is not None]
        once = all(
            not one._is_equivalent(other) for one, other in combinations(others, 2)
        )
        yield None if once else "it has a participant twice"
    for context in rtc.call("get_participating_contexts"):
        profile = rtc.ask(context, "get_profile")
        listed = any(
            each is not None and each._is_equivalent(rtc.reference)
            for each in profile.participants
        )
        yield None if listed else "a context of another component does not list it"


@check(
    "contexts.defaults",
    "the rate is that of the definition",
    _CONTEXTS,
    Permission.DEFAULTS,
)
def default_rate(rtc: RtcUnderTest) -> Problems:
    """Check that the first context has the rate of the definition, if it is periodic."""
    context = rtc.context
    if rtc.ask(context, "get_kind") is not ExecutionKind.PERIODIC:
        raise SkipError("its execution context is not of PERIODIC kind")
    rate = rtc.ask(context, "get_rate")
    same = isclose(rate, rtc.expected.rate, rel_tol=_RATE_TOLERANCE)
    yield None if same else f"the rate is {rate} Hz, not {rtc.expected.rate} Hz"


@check("contexts.handles", "contexts have handles", _CONTEXTS)
def context_handles(rtc: RtcUnderTest) -> Problems:
    """Check that a context has a handle, by which the component finds it."""
    handles: set[int] = set()
    for context in (*rtc.contexts, *rtc.call("get_participating_contexts")):
        handle = rtc.call("get_context_handle", context)
        yield f"it has context {handle} twice" if handle in handles else None
        handles.add(handle)
        actual = rtc.call("get_context", handle)
        same = actual is not None and actual._is_equivalent(context)
        yield None if same else f"get_context({handle}) returned another context"
        alive = rtc.call("is_alive", context)
        yield None if alive else f"it is not alive in context {handle}"
    unknown = next(each for each in range(_MAX_HANDLES, 0, -1) if each not in handles)
    actual = rtc.call("get_context", unknown)
    yield f"get_context({unknown}) returned a context" if actual is not None else None


@check("contexts.state", "it has a state in each context", _LIFE)
def states(rtc: RtcUnderTest) -> Problems:
    for context in (*rtc.contexts, *rtc.call("get_participating_contexts")):
        state = rtc.ask(context, "get_component_state", rtc.reference)
        yield "its state is CREATED" if state is CREATED_STATE else None


def _rows(rtc: RtcUnderTest, rows: tuple[_Row, ...]) -> Problems:
    """Yield problems of calls with expected return codes, none of which changes the state."""
    context, before = rtc.context, rtc.state()
    for operation, expected in rows:
        code = rtc.ask(context, operation, rtc.reference)
        same = code is expected
        problem = (
            f"{before.name}: {operation} returned {code.name}, not {expected.name}"
        )
        yield None if same else problem
    # A request takes effect at the next tick.
    rtc.remains(before, ticks=_TICKS)
    yield unequal("the state after refused calls", rtc.state().name, before.name)


def _change(rtc: RtcUnderTest, operation: str, state: Any) -> str | None:
    """Return the problem of a request that should lead to a state."""
    code = rtc.request(operation, state)
    if rtc.state() is not state:
        why = "" if code is RTC_OK else f" returned {code.name}, and"
        return f"{operation}{why} leads to {rtc.state().name}, not to {state.name}"
    if code is not RTC_OK:
        return f"{operation} returned {code.name}, not RTC_OK"
    return None


@check("life-cycle.activation", "it becomes ACTIVE, and INACTIVE again", _LIFE, ACTUATE)
def activation(rtc: RtcUnderTest) -> Problems:
    """Check that activation leads to ACTIVE, deactivation to INACTIVE."""
    if rtc.is_running() and rtc.state() is ACTIVE_STATE:
        problem = _change(rtc, "deactivate_component", INACTIVE_STATE)
        yield problem
        if problem is not None:
            return
    rtc.inactive()
    yield _change(rtc, "activate_component", ACTIVE_STATE)
    yield _change(rtc, "deactivate_component", INACTIVE_STATE)


@check(
    "life-cycle.inactive",
    "while INACTIVE it is neither deactivated nor reset",
    _LIFE,
    ACTUATE,
)
def refused_inactive(rtc: RtcUnderTest) -> Problems:
    rtc.inactive()
    yield from _rows(rtc, _FIRST)


@check(
    "life-cycle.active",
    "while ACTIVE it is neither activated nor reset",
    _LIFE,
    ACTUATE,
)
def refused_active(rtc: RtcUnderTest) -> Problems:
    rtc.inactive()
    rtc.request("activate_component", ACTIVE_STATE)
    if rtc.state() is not ACTIVE_STATE:
        raise SkipError("it does not become ACTIVE")
    yield from _rows(rtc, _WHILE_ACTIVE)
    rtc.inactive()


@check(
    "life-cycle.error",
    "in ERROR it is neither activated nor deactivated",
    _LIFE,
    ACTUATE,
)
def refused_in_error(rtc: RtcUnderTest) -> Problems:
    if rtc.state() is not ERROR_STATE:
        raise SkipError("it is not in ERROR, and no request leads there")
    yield from _rows(rtc, _IN_ERROR)


@check(
    "life-cycle.initialization",
    "it is neither initialized again nor finalized",
    _LIFE,
    Permission.EXIT,
)
def initialization(rtc: RtcUnderTest) -> Problems:
    """Check that the component is not initialized again, nor finalized while in a context."""
    if not rtc.is_of_rtgen:
        raise SkipError("OpenRTM initializes a component again")
    for operation in ("initialize", "finalize"):
        code = rtc.call(operation)
        yield unequal(operation, code.name, PRECONDITION_NOT_MET.name)
    yield None if rtc.is_alive() else "it is no longer alive"


class _Stranger:
    """A component without operations that participates in no context."""


@check(
    "contexts.strangers",
    "requests for other components are refused",
    _CONTEXTS,
    ACTUATE,
)
def strangers(rtc: RtcUnderTest) -> Problems:
    """Check that a context rejects requests for a component that does not participate in it."""
    stranger = rtc.exported.serve(DATA_FLOW_COMPONENT, _Stranger())
    try:
        for operation in (
            *("activate_component", "deactivate_component"),
            *("reset_component", "remove_component"),
        ):
            code = rtc.ask(rtc.context, operation, stranger)
            yield unequal(operation, code.name, BAD_PARAMETER.name)
    finally:
        rtc.exported.withdraw(stranger)


@check("contexts.running", "its context starts and stops", _CONTEXTS, ACTUATE)
def running(rtc: RtcUnderTest) -> Problems:
    """Check that a context stops and starts, each only once."""
    context = rtc.inactive()
    for operation, expected, runs in (
        ("start", PRECONDITION_NOT_MET, True),
        ("stop", RTC_OK, False),
        ("stop", PRECONDITION_NOT_MET, False),
        ("start", RTC_OK, True),
    ):
        code = rtc.ask(context, operation)
        yield unequal(operation, code.name, expected.name)
        yield unequal("is_running", bool(rtc.ask(context, "is_running")), runs)


@check("contexts.rate", "its context accepts only rates above 0", _CONTEXTS, ACTUATE)
def rates(rtc: RtcUnderTest) -> Problems:
    """Check that a periodic context accepts another rate, and rejects one that is not above 0."""
    context = rtc.inactive()
    if rtc.ask(context, "get_kind") is not ExecutionKind.PERIODIC:
        raise SkipError("its execution context is not of PERIODIC kind")
    before = rtc.ask(context, "get_rate")
    for rate, expected, after in (
        (before / 2, RTC_OK, before / 2),
        (0.0, BAD_PARAMETER, before / 2),
        (-1.0, BAD_PARAMETER, before / 2),
        (before, RTC_OK, before),
    ):
        code = rtc.ask(context, "set_rate", rate)
        yield unequal(f"set_rate({rate})", code.name, expected.name)
        yield unequal("the rate", rtc.ask(context, "get_rate"), after)
