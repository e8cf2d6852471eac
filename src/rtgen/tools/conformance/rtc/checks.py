"""All checks of a running component, in the order of execution, and those of its profile."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.corba.rt_objects.wire import texts
from rtgen.runtime.return_codes import RTC_OK, UNSUPPORTED
from rtgen.tools.conformance.check import (
    ACTUATE,
    Permission,
    Problems,
    SkipError,
    check,
    unequal,
)
from rtgen.tools.conformance.rtc import (
    configuration_checks,
    connections,
    life_cycle_checks,
    port_checks,
)
from rtgen.tools.conformance.rtc.component import RtcUnderTest

_PROFILE: Final = "OMG RTC 1.0, RTObject, ComponentProfile"


@check("profile", "the profile is that of the definition", _PROFILE)
def profile(rtc: RtcUnderTest) -> Problems:
    """Check that type name, category, vendor, version and description match the definition."""
    for name, expected in rtc.expected.texts.items():
        actual = getattr(rtc.profile, name)
        yield unequal(name.replace("_", " "), actual, expected)


@check(
    "profile.properties",
    "activity and number of instances are as described",
    "docs/openrtm.md",
)
def properties(rtc: RtcUnderTest) -> Problems:
    """Check that properties of the profile match the definition, if the component has them."""
    actual = texts(rtc.profile.properties)
    for name, expected in rtc.expected.properties.items():
        if name in actual:
            is_expected = actual[name] in expected
            hint = rtc.expected.saying(name, actual[name])
            problem = f"{name} is {actual[name]!r}, not {expected[0]!r}{hint}"
            yield None if is_expected else problem


@check("profile.identity", "it is alive, and its names agree", _PROFILE)
def identity(rtc: RtcUnderTest) -> Problems:
    """Check that the component is alive, and its SDO id is its instance name."""
    yield None if rtc.is_alive() else "is_alive returned false"
    expected = rtc.profile.instance_name
    yield unequal("the SDO id", rtc.call("get_sdo_id"), expected)


@check("exit", "it exits, and is gone", _PROFILE, Permission.EXIT)
def exits(rtc: RtcUnderTest) -> Problems:
    """Check that a component is gone in time after `exit`."""
    code = rtc.call("exit")
    if code is UNSUPPORTED and rtc.is_alive():
        raise SkipError("it ends only with its process: exit returned UNSUPPORTED")
    yield unequal("exit", code.name, RTC_OK.name)
    yield None if rtc.ends() else "it is still alive"


@check("left", "its state is as before the test", "docs/conformance.md", ACTUATE)
def left(rtc: RtcUnderTest) -> Problems:
    """Check that values, active set, rate and state are as before the test."""
    yield from rtc.restore()


CHECKS: Final = (
    profile,
    properties,
    identity,
    port_checks.port_names,
    port_checks.directions,
    port_checks.data_types,
    port_checks.interfaces,
    port_checks.port_references,
    port_checks.unknown_connectors,
    configuration_checks.parameter_names,
    configuration_checks.parameter_values,
    configuration_checks.default_values,
    configuration_checks.active_set,
    configuration_checks.read_values,
    configuration_checks.unknown_sets,
    configuration_checks.unknown_parameters,
    life_cycle_checks.context_kinds,
    life_cycle_checks.context_profiles,
    life_cycle_checks.default_rate,
    life_cycle_checks.context_handles,
    life_cycle_checks.states,
    life_cycle_checks.refused_in_error,
    life_cycle_checks.refused_inactive,
    life_cycle_checks.activation,
    life_cycle_checks.refused_active,
    life_cycle_checks.strangers,
    life_cycle_checks.running,
    life_cycle_checks.rates,
    configuration_checks.set_values,
    configuration_checks.set_parameters,
    configuration_checks.added_set,
    configuration_checks.values_beyond,
    configuration_checks.values_of_no_type,
    configuration_checks.activated_sets,
    connections.connected,
    connections.all_ended,
    connections.services,
    connections.other_types,
    connections.other_interfaces,
    left,
    life_cycle_checks.initialization,
    exits,
)
