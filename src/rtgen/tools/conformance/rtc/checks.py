"""All checks of a running component, in the order of execution, and those of its profile."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.corba.rt_objects.wire import texts
from rtgen.runtime.return_codes import RTC_OK, UNSUPPORTED
from rtgen.tools.conformance.check import (
    Check,
    Permission,
    Problems,
    SkipError,
    unequal,
)
from rtgen.tools.conformance.rtc import (
    configuration_checks,
    connections,
    life_cycle_checks,
    port_checks,
)
from rtgen.tools.conformance.rtc.component import RtcUnderTest

_RTC: Final = "OMG RTC 1.0, "
_SDO: Final = "OMG SDO, "


def profile(rtc: RtcUnderTest) -> Problems:
    """Check that type name, category, vendor, version and description match the definition."""
    for name, expected in rtc.expected.texts.items():
        actual = getattr(rtc.profile, name)
        yield unequal(name.replace("_", " "), actual, expected)


def properties(rtc: RtcUnderTest) -> Problems:
    """Check that properties of the profile match the definition, if the component has them."""
    actual = texts(rtc.profile.properties)
    for name, expected in rtc.expected.properties.items():
        if name in actual:
            is_expected = actual[name] in expected
            hint = rtc.expected.saying(name, actual[name])
            problem = f"{name} is {actual[name]!r}, not {expected[0]!r}{hint}"
            yield None if is_expected else problem


def identity(rtc: RtcUnderTest) -> Problems:
    """Check that the component is alive, and its SDO id is its instance name."""
    yield None if rtc.is_alive() else "is_alive returned false"
    expected = rtc.profile.instance_name
    yield unequal("the SDO id", rtc.call("get_sdo_id"), expected)


def exits(rtc: RtcUnderTest) -> Problems:
    """Check that a component is gone in time after `exit`."""
    code = rtc.call("exit")
    if code is UNSUPPORTED and rtc.is_alive():
        raise SkipError("it ends only with its process: exit returned UNSUPPORTED")
    yield unequal("exit", code.name, RTC_OK.name)
    yield None if rtc.ends() else "it is still alive"


def left(rtc: RtcUnderTest) -> Problems:
    """Check that values, active set, rate and state are as before the test."""
    yield from rtc.restore()


_PROFILE: Final = f"{_RTC}RTObject, ComponentProfile"
_PORTS: Final = f"{_RTC}PortService, PortProfile"
_CONTEXTS: Final = f"{_RTC}5.2.2.6 (ExecutionContext)"
_LIFE: Final = f"{_RTC}5.2.2.3 (LifeCycleState)"
_SETS: Final = f"{_SDO}Configuration"

ACTUATE: Final = Permission.ACTUATE

CHECKS: Final = (
    Check("profile", "the profile is that of the definition", _PROFILE, profile),
    Check(
        "profile.properties",
        "activity and number of instances are as described",
        "docs/openrtm.md",
        properties,
    ),
    Check("profile.identity", "it is alive, and its names agree", _PROFILE, identity),
    Check(
        "ports.names",
        "the ports are those of the definition",
        _PORTS,
        port_checks.port_names,
    ),
    Check(
        "ports.directions",
        "ports have their directions",
        _PORTS,
        port_checks.directions,
    ),
    Check("ports.types", "data ports have their types", _PORTS, port_checks.data_types),
    Check(
        "ports.interfaces",
        "service ports have their interfaces",
        _PORTS,
        port_checks.interfaces,
    ),
    Check(
        "ports.references",
        "each port is listed with its profile",
        _PORTS,
        port_checks.port_references,
    ),
    Check(
        "ports.unknown",
        "an unknown connector is not disconnected",
        _PORTS,
        port_checks.unknown_connectors,
    ),
    Check(
        "configuration.names",
        "the parameters are those of the definition",
        _SETS,
        configuration_checks.parameter_names,
    ),
    Check(
        "configuration.values",
        "values are of their types and within their limits",
        _SETS,
        configuration_checks.parameter_values,
    ),
    Check(
        "configuration.defaults",
        "values are the defaults of the definition",
        _SETS,
        configuration_checks.default_values,
        Permission.DEFAULTS,
    ),
    Check(
        "configuration.active",
        "the active set is there",
        _SETS,
        configuration_checks.active_set,
    ),
    Check(
        "configuration.reads",
        "operations that read values agree",
        _SETS,
        configuration_checks.read_values,
    ),
    Check(
        "configuration.unknown",
        "unknown sets are refused",
        _SETS,
        configuration_checks.unknown_sets,
    ),
    Check(
        "configuration.unknown-parameters",
        "unknown parameters are refused",
        _SETS,
        configuration_checks.unknown_parameters,
    ),
    Check(
        "contexts.kind",
        "it owns a context of the declared kind",
        _CONTEXTS,
        life_cycle_checks.context_kinds,
    ),
    Check(
        "contexts.profile",
        "contexts report kind, rate and owner",
        _CONTEXTS,
        life_cycle_checks.context_profiles,
    ),
    Check(
        "contexts.defaults",
        "the rate is that of the definition",
        _CONTEXTS,
        life_cycle_checks.default_rate,
        Permission.DEFAULTS,
    ),
    Check(
        "contexts.handles",
        "contexts have handles",
        _CONTEXTS,
        life_cycle_checks.context_handles,
    ),
    Check(
        "contexts.state",
        "it has a state in each context",
        _LIFE,
        life_cycle_checks.states,
    ),
    Check(
        "life-cycle.error",
        "in ERROR it is neither activated nor deactivated",
        _LIFE,
        life_cycle_checks.refused_in_error,
        ACTUATE,
    ),
    Check(
        "life-cycle.inactive",
        "while INACTIVE it is neither deactivated nor reset",
        _LIFE,
        life_cycle_checks.refused_inactive,
        ACTUATE,
    ),
    Check(
        "life-cycle.activation",
        "it becomes ACTIVE, and INACTIVE again",
        _LIFE,
        life_cycle_checks.activation,
        ACTUATE,
    ),
    Check(
        "life-cycle.active",
        "while ACTIVE it is neither activated nor reset",
        _LIFE,
        life_cycle_checks.refused_active,
        ACTUATE,
    ),
    Check(
        "contexts.strangers",
        "requests for other components are refused",
        _CONTEXTS,
        life_cycle_checks.strangers,
        ACTUATE,
    ),
    Check(
        "contexts.running",
        "its context starts and stops",
        _CONTEXTS,
        life_cycle_checks.running,
        ACTUATE,
    ),
    Check(
        "contexts.rate",
        "its context accepts only rates above 0",
        _CONTEXTS,
        life_cycle_checks.rates,
        ACTUATE,
    ),
    Check(
        "configuration.set",
        "parameters accept other values",
        _SETS,
        configuration_checks.set_values,
        ACTUATE,
    ),
    Check(
        "configuration.parameters",
        "single parameters of the active set are set",
        _SETS,
        configuration_checks.set_parameters,
        ACTUATE,
    ),
    Check(
        "configuration.added",
        "a set is added and removed",
        _SETS,
        configuration_checks.added_set,
        ACTUATE,
    ),
    Check(
        "configuration.limits",
        "values beyond their limits are refused",
        _SETS,
        configuration_checks.values_beyond,
        ACTUATE,
    ),
    Check(
        "configuration.types",
        "values of other types are refused",
        _SETS,
        configuration_checks.values_of_no_type,
        ACTUATE,
    ),
    Check(
        "configuration.sets",
        "each set becomes the active one",
        _SETS,
        configuration_checks.activated_sets,
        ACTUATE,
    ),
    Check(
        "connections",
        "ports are connected and disconnected",
        _PORTS,
        connections.connected,
        ACTUATE,
    ),
    Check(
        "connections.all",
        "all connections of a port are ended",
        _PORTS,
        connections.all_ended,
        ACTUATE,
    ),
    Check(
        "connections.services",
        "provided interfaces have their types, required ones accept only theirs",
        _PORTS,
        connections.services,
        ACTUATE,
    ),
    Check(
        "connections.types",
        "samples of other types are refused",
        "docs/openrtm.md",
        connections.other_types,
        ACTUATE,
    ),
    Check(
        "connections.interfaces",
        "unknown interface types are refused",
        "docs/openrtm.md",
        connections.other_interfaces,
        ACTUATE,
    ),
    Check(
        "left", "its state is as before the test", "docs/conformance.md", left, ACTUATE
    ),
    Check(
        "life-cycle.initialization",
        "it is neither initialized again nor finalized",
        _LIFE,
        life_cycle_checks.initialization,
        Permission.EXIT,
    ),
    Check("exit", "it exits, and is gone", _PROFILE, exits, Permission.EXIT),
)
