"""Checks of the configuration sets of a running component."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Final

from omniORB import CORBA
from omniORB import any as anys

from rtgen.runtime.corba.rt_objects.wire import SdoError, texts
from rtgen.tools.conformance.check import (
    ACTUATE,
    Permission,
    Problems,
    SkipError,
    check,
    unequal,
)
from rtgen.tools.conformance.rtc.component import UNKNOWN, RtcUnderTest
from rtgen.tools.conformance.rtc.expected import ExpectedParameter

_SETS: Final = "OMG SDO, Configuration"


@check("configuration.names", "the parameters are those of the definition", _SETS)
def parameter_names(rtc: RtcUnderTest) -> Problems:
    """Check that the set `default` has the parameters of the definition."""
    actual, expected = rtc.sets().get("default", {}), rtc.expected.parameters
    for name in expected:
        yield None if name in actual else f"there is no parameter {name}"
    for name in actual:
        if name not in expected:
            yield f"the definition has no parameter {name}"


@check(
    "configuration.values", "values are of their types and within their limits", _SETS
)
def parameter_values(rtc: RtcUnderTest) -> Problems:
    """Check that values of all sets have their types and are within their limits."""
    for set_id, values in rtc.sets().items():
        for name, text in values.items():
            if name in rtc.expected.parameters:
                problem = rtc.expected.parameters[name].problem(text)
                yield None if problem is None else f"set {set_id}: {problem}"


@check(
    "configuration.defaults",
    "values are the defaults of the definition",
    _SETS,
    Permission.DEFAULTS,
)
def default_values(rtc: RtcUnderTest) -> Problems:
    """Check that the active set has the default values of the definition."""
    active = rtc.active_set()
    values = rtc.sets().get(active, {})
    for name, parameter in rtc.expected.parameters.items():
        if name in values and parameter.problem(values[name]) is None:
            problem = (
                f"set {active}: {name} is {values[name]!r}, not {parameter.default!r}"
            )
            yield None if parameter.is_default(values[name]) else problem


@check("configuration.active", "the active set is there", _SETS)
def active_set(rtc: RtcUnderTest) -> Problems:
    """Check that the active set is one of the sets."""
    active = rtc.active_set()
    exists = active in rtc.sets()
    yield None if exists else f"the active set {active!r} is none of the sets"


@check("configuration.reads", "operations that read values agree", _SETS)
def read_values(rtc: RtcUnderTest) -> Problems:
    """Check that all operations that read values return the same ones."""
    sets, active = rtc.sets(), rtc.active_set()
    for set_id, values_ in sets.items():
        read = texts(rtc.configure("get_configuration_set", set_id).configuration_data)
        yield unequal(f"get_configuration_set({set_id})", read, values_)
    if active not in sets:
        return
    configuration_set = rtc.configure("get_active_configuration_set")
    read = texts(configuration_set.configuration_data)
    yield unequal("get_active_configuration_set", read, sets[active])
    if not rtc.is_of_rtgen:
        return  # OpenRTM's operations for single parameters have no values.
    read = texts(rtc.configure("get_configuration_parameter_values"))
    yield unequal("get_configuration_parameter_values", read, sets[active])
    for name, text in sets[active].items():
        one = rtc.configure("get_configuration_parameter_value", name).value()
        yield unequal(f"get_configuration_parameter_value({name})", one, text)


def _refused(rtc: RtcUnderTest, what: str, operation: str, name: str) -> str | None:
    try:
        answer = rtc.configure(operation, name)
    except (
        SdoError,
        CORBA.BAD_PARAM,
    ):  # this from OpenRTM-aist-Python, which has no value
        return None
    return None if answer is False else f"{what} was not refused"


@check("configuration.unknown", "unknown sets are refused", _SETS)
def unknown_sets(rtc: RtcUnderTest) -> Problems:
    """Check that requests for unknown sets are rejected."""
    yield _refused(rtc, "an unknown set", "get_configuration_set", UNKNOWN)


@check("configuration.unknown-parameters", "unknown parameters are refused", _SETS)
def unknown_parameters(rtc: RtcUnderTest) -> Problems:
    """Check that a request for an unknown parameter is rejected."""
    operation = "get_configuration_parameter_value"
    if not rtc.is_of_rtgen and not _reads_parameters(rtc):
        raise SkipError("it has no values of single parameters, like OpenRTM")
    yield _refused(rtc, "an unknown parameter", operation, UNKNOWN)


def _reads_parameters(rtc: RtcUnderTest) -> bool:
    """Return whether the component returns the values of its single parameters."""
    parameter = next(iter(rtc.sets().get(rtc.active_set(), {})), None)
    if parameter is None:
        return False
    try:
        values = rtc.configure("get_configuration_parameter_value", parameter)
    except (SdoError, CORBA.SystemException):
        return False
    return values.value() is not None


def _parameters(rtc: RtcUnderTest) -> Iterator[tuple[str, ExpectedParameter, str]]:
    """Yield the parameters both defined and present, with their values."""
    values = rtc.sets().get("default", {})
    for name, parameter in rtc.expected.parameters.items():
        if name in values and parameter.problem(values[name]) is None:
            yield name, parameter, values[name]


@check("configuration.set", "parameters accept other values", _SETS, ACTUATE)
def set_values(rtc: RtcUnderTest) -> Problems:
    """Check that parameters accept other values, and their former ones again."""
    for name, parameter, text in _parameters(rtc):
        other = next(parameter.others(text), None)
        if other is None:
            continue
        for value in (other, text):
            before = rtc.sets()
            if not rtc.set_value("default", name, value):
                yield f"{name} = {value} was refused"
                continue
            after = rtc.sets()
            now = after["default"].pop(name, "")
            del before["default"][name]
            problem = parameter.problem(now)
            if problem is None and parameter.value(now) != parameter.value(value):
                problem = f"it is {now}"
            elif after != before:
                problem = "other values have changed, too"
            yield None if problem is None else f"{name} = {value}: {problem}"


@check(
    "configuration.parameters",
    "single parameters of the active set are set",
    _SETS,
    ACTUATE,
)
def set_parameters(rtc: RtcUnderTest) -> Problems:
    """Check that single parameters of the active set can be set, and set again."""
    if not rtc.is_of_rtgen:
        raise SkipError("OpenRTM sets parameters by their set only")
    for name, parameter, _ in _parameters(rtc):
        text = rtc.sets()[rtc.active_set()][name]
        for value in (*islice(parameter.others(text), 1), text):
            taken = rtc.configure(
                "set_configuration_parameter", name, anys.to_any(value)
            )
            now = rtc.sets()[rtc.active_set()][name]
            same = parameter.problem(now) is None
            same = same and parameter.value(now) == parameter.value(value)
            yield None if taken and same else f"{name} = {value}: it is {now}"


@check("configuration.added", "a set is added and removed", _SETS, ACTUATE)
def added_set(rtc: RtcUnderTest) -> Problems:
    """Check that a set can be added, and removed again; other sets are as before."""
    if not rtc.is_of_rtgen:
        raise SkipError("OpenRTM might keep the set")
    before = rtc.sets()
    name, _, text = next(_parameters(rtc), ("", None, ""))
    if not name:
        return
    try:
        taken = rtc.set_value(UNKNOWN, name, text, add=True)
        sets = rtc.sets()
        there = sets.pop(UNKNOWN, {}).get(name) == text
        yield None if taken and there else "an added set is not there"
        yield None if sets == before else "other sets have changed"
    finally:
        taken = rtc.configure("remove_configuration_set", UNKNOWN)
    yield None if taken else "it was not removed"
    yield None if rtc.sets() == before else "after its removal the sets are others"


def _wrong_value(rtc: RtcUnderTest, name: str, text: str, before: str) -> str | None:
    """Return the problem unless a value is rejected; one that was accepted is restored."""
    try:
        taken = rtc.set_value("default", name, text)
    except SdoError:
        taken = False
    now = rtc.sets()["default"].get(name)
    if now != before:
        rtc.set_value("default", name, before)
    if taken or now != before:
        return f"{name} = {text!r} was not refused"
    return None


def _wrong_values(
    rtc: RtcUnderTest, wrong: Callable[[ExpectedParameter], str | None]
) -> Problems:
    """Check that a wrong value of each parameter is rejected, if there is one."""
    if not rtc.is_of_rtgen:
        raise SkipError(
            "OpenRTM's configuration accepts any text, and validates it later"
        )
    for name, parameter, before in _parameters(rtc):
        text = wrong(parameter)
        if text is not None:
            yield _wrong_value(rtc, name, text, before)


@check("configuration.limits", "values beyond their limits are refused", _SETS, ACTUATE)
def values_beyond(rtc: RtcUnderTest) -> Problems:
    """Check that values beyond limits and constraints are rejected, and the former ones kept."""
    return _wrong_values(rtc, ExpectedParameter.beyond)


@check("configuration.types", "values of other types are refused", _SETS, ACTUATE)
def values_of_no_type(rtc: RtcUnderTest) -> Problems:
    """Check that texts that are not values of the type are rejected, and the former values kept."""
    return _wrong_values(rtc, ExpectedParameter.of_no_type)


@check("configuration.sets", "each set becomes the active one", _SETS, ACTUATE)
def activated_sets(rtc: RtcUnderTest) -> Problems:
    """Check that each set can be activated, and an unknown one is rejected."""
    before = rtc.before.active if rtc.before is not None else rtc.active_set()
    for set_id in (*rtc.sets(), before):
        if not rtc.configure("activate_configuration_set", set_id):
            yield f"set {set_id} was refused"
            continue
        yield unequal("the active set", rtc.active_set(), set_id)
    operation = "activate_configuration_set"
    yield _refused(rtc, "an unknown set", operation, UNKNOWN)
    yield unequal("the active set after that", rtc.active_set(), before)
