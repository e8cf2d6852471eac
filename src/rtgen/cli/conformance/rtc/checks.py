"""Checks of a running component: a function each, in the order of execution."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, islice
from math import isclose
from typing import Any, Final

from omniORB import CORBA
from omniORB import any as anys

from rtgen.cli.conformance.check import Check, Permission, Problems, SkipError
from rtgen.cli.conformance.rtc import connections
from rtgen.cli.conformance.rtc.component import RtcUnderTest
from rtgen.cli.conformance.rtc.expected import ExpectedParameter, ExpectedPort
from rtgen.facts.openrtm_ports import known_name
from rtgen.runtime.corba.rt_objects.wire import (
    DATA_FLOW_COMPONENT,
    PortInterfacePolarity,
    SdoError,
    texts,
)
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    BAD_PARAMETER,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_OK,
    UNSUPPORTED,
    ExecutionKind,
    ReturnCode_t,
)

_RTC: Final = "OMG RTC 1.0, "
_SDO: Final = "OMG SDO, "
_UNKNOWN: Final = "rtgen-conformance-unknown"
"""A name that no set, parameter or connector has."""

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


def _unequal(what: str, found: object, wanted: object) -> str | None:
    return None if found == wanted else f"{what} is {found!r}, not {wanted!r}"


# Profile


def profile(rtc: RtcUnderTest) -> Problems:
    """Check that type name, category, vendor, version and description match the definition."""
    for name, wanted in rtc.expected.texts.items():
        found = getattr(rtc.profile, name)
        yield _unequal(name.replace("_", " "), found, wanted)


def properties(rtc: RtcUnderTest) -> Problems:
    """Check that properties of the profile match the definition, if the component has them."""
    found = texts(rtc.profile.properties)
    for name, wanted in rtc.expected.properties.items():
        if name in found:
            known = found[name] in wanted
            yield None if known else f"{name} is {found[name]!r}, not {wanted[0]!r}"


def identity(rtc: RtcUnderTest) -> Problems:
    """Check that the component is alive, and its SDO id is its instance name."""
    yield None if rtc.is_alive() else "is_alive returned false"
    wanted = rtc.profile.instance_name
    yield _unequal("the SDO id", rtc.call("get_sdo_id"), wanted)


# Ports


def _found(rtc: RtcUnderTest) -> dict[str, Any]:
    """Return the profiles of ports by name."""
    return {known_name(port.name): port for port in rtc.profile.port_profiles}


def _common(rtc: RtcUnderTest) -> Iterator[tuple[str, ExpectedPort, Any]]:
    """Yield the ports both defined and present; `ports.names` reports others."""
    found = _found(rtc)
    for name, expected in rtc.expected.ports.items():
        if name in found:
            yield name, expected, found[name]


def port_names(rtc: RtcUnderTest) -> Problems:
    """Check that the ports are those of the definition."""
    found, wanted = _found(rtc), rtc.expected.ports
    for name in wanted:
        yield None if name in found else f"there is no port {name}"
    for name in found:
        if name not in wanted:
            yield f"the definition has no port {name}"
    names = [known_name(port.name) for port in rtc.profile.port_profiles]
    for name in found:
        yield None if names.count(name) == 1 else f"port {name} is there twice"


def directions(rtc: RtcUnderTest) -> Problems:
    """Check that ports are inputs, outputs and service ports as declared."""
    for name, expected, port in _common(rtc):
        type_ = texts(port.properties).get("port.port_type")
        yield _unequal(f"{name}: port.port_type", type_, expected.port_type)


def data_types(rtc: RtcUnderTest) -> Problems:
    """Check that data ports have the declared types."""
    for name, expected, port in _common(rtc):
        if expected.data_types:
            type_ = texts(port.properties).get("dataport.data_type", "")
            known = type_ in expected.data_types
            wanted = expected.data_types[0]
            yield None if known else f"{name}: its type is {type_!r}, not {wanted!r}"


def interfaces(rtc: RtcUnderTest) -> Problems:
    """Check that service ports have the declared interfaces: name, type and polarity."""
    for name, expected, port in _common(rtc):
        if expected.interfaces is None:
            continue
        found = {
            (i.instance_name, i.polarity == PortInterfacePolarity.PROVIDED): i.type_name
            for i in port.interfaces
        }
        for key, interface in expected.interfaces.items():
            types = interface.names
            what = f"{name}: {'provided' if key[1] else 'required'} {key[0]}"
            if key not in found:
                yield f"{what} is missing"
            else:
                known = found[key] in types
                yield None if known else f"{what} has type {found[key]}, not {types[0]}"
        for instance, _ in found.keys() - expected.interfaces.keys():
            yield f"{name}: the definition has no such {instance}"
        once = len(found) == len(port.interfaces)
        yield None if once else f"{name}: an interface is there twice"


def port_references(rtc: RtcUnderTest) -> Problems:
    """Check that `get_ports` returns the ports of the profile, with equal profiles."""
    references = rtc.call("get_ports")
    yield _unequal("the number of ports", len(references), len(_found(rtc)))
    for name, port in _found(rtc).items():
        own = rtc.at_port(port, "get_port_profile")
        listed = any(port.port_ref._is_equivalent(each) for each in references)
        yield None if listed else f"{name} is not among get_ports"
        yield _unequal("the port's own name", own.name, port.name)
        owned = own.owner is not None and own.owner._is_equivalent(rtc.reference)
        yield None if owned else f"{name}: the owner is another one"


def unknown_connectors(rtc: RtcUnderTest) -> Problems:
    """Check that ports refuse to end an unknown connection."""
    for name, port in _found(rtc).items():
        code = rtc.at_port(port, "disconnect", _UNKNOWN)
        wanted = f"{name}: disconnect of an unknown id returned {code.name}"
        yield None if code is BAD_PARAMETER else f"{wanted}, not BAD_PARAMETER"
        unknown = rtc.at_port(port, "get_connector_profile", _UNKNOWN).connector_id
        yield f"{name}: an unknown id leads to connector {unknown}" if unknown else None


# Configuration


def parameter_names(rtc: RtcUnderTest) -> Problems:
    """Check that the set `default` has the parameters of the definition."""
    found, wanted = rtc.sets().get("default", {}), rtc.expected.parameters
    for name in wanted:
        yield None if name in found else f"there is no parameter {name}"
    for name in found:
        if name not in wanted:
            yield f"the definition has no parameter {name}"


def parameter_values(rtc: RtcUnderTest) -> Problems:
    """Check that values of all sets have their types and are within their limits."""
    for set_id, values in rtc.sets().items():
        for name, text in values.items():
            if name in rtc.expected.parameters:
                problem = rtc.expected.parameters[name].problem(text)
                yield None if problem is None else f"set {set_id}: {problem}"


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


def active_set(rtc: RtcUnderTest) -> Problems:
    """Check that the active set is one of the sets."""
    active = rtc.active_set()
    known = active in rtc.sets()
    yield None if known else f"the active set {active!r} is none of the sets"


def read_values(rtc: RtcUnderTest) -> Problems:
    """Check that all operations that read values return the same ones."""
    sets, active = rtc.sets(), rtc.active_set()
    for set_id, values_ in sets.items():
        read = texts(rtc.configure("get_configuration_set", set_id).configuration_data)
        yield _unequal(f"get_configuration_set({set_id})", read, values_)
    if active not in sets:
        return
    found = rtc.configure("get_active_configuration_set")
    read = texts(found.configuration_data)
    yield _unequal("get_active_configuration_set", read, sets[active])
    if not rtc.is_of_rtgen:
        return  # OpenRTM's operations for single parameters have no values.
    read = texts(rtc.configure("get_configuration_parameter_values"))
    yield _unequal("get_configuration_parameter_values", read, sets[active])
    for name, text in sets[active].items():
        one = rtc.configure("get_configuration_parameter_value", name).value()
        yield _unequal(f"get_configuration_parameter_value({name})", one, text)


def _refused(rtc: RtcUnderTest, what: str, operation: str, name: str) -> str | None:
    try:
        answer = rtc.configure(operation, name)
    except (
        SdoError,
        CORBA.BAD_PARAM,
    ):  # this from OpenRTM-aist-Python, which has no value
        return None
    return None if answer is False else f"{what} was not refused"


def unknown_names(rtc: RtcUnderTest) -> Problems:
    """Check that requests for unknown sets and parameters are rejected."""
    yield _refused(rtc, "an unknown set", "get_configuration_set", _UNKNOWN)
    operation = "get_configuration_parameter_value"
    yield _refused(rtc, "an unknown parameter", operation, _UNKNOWN)


def _parameters(rtc: RtcUnderTest) -> Iterator[tuple[str, ExpectedParameter, str]]:
    """Yield the parameters both defined and present, with their values."""
    values = rtc.sets().get("default", {})
    for name, parameter in rtc.expected.parameters.items():
        if name in values and parameter.problem(values[name]) is None:
            yield name, parameter, values[name]


def set_values(rtc: RtcUnderTest) -> Problems:
    """Check that parameters accept other values, and their former ones again."""
    for name, parameter, text in _parameters(rtc):
        other = next(parameter.others(text), None)
        if other is None:
            continue
        for given in (other, text):
            before = rtc.sets()
            if not rtc.set_value("default", name, given):
                yield f"{name} = {given} was refused"
                continue
            after = rtc.sets()
            now = after["default"].pop(name, "")
            del before["default"][name]
            problem = parameter.problem(now)
            if problem is None and parameter.value(now) != parameter.value(given):
                problem = f"it is {now}"
            elif after != before:
                problem = "other values have changed, too"
            yield None if problem is None else f"{name} = {given}: {problem}"


def set_parameters(rtc: RtcUnderTest) -> Problems:
    """Check that single parameters of the active set can be set, and set again."""
    if not rtc.is_of_rtgen:
        raise SkipError("OpenRTM sets parameters by their set only")
    for name, parameter, _ in _parameters(rtc):
        text = rtc.sets()[rtc.active_set()][name]
        for given in (*islice(parameter.others(text), 1), text):
            taken = rtc.configure(
                "set_configuration_parameter", name, anys.to_any(given)
            )
            now = rtc.sets()[rtc.active_set()][name]
            same = parameter.problem(now) is None
            same = same and parameter.value(now) == parameter.value(given)
            yield None if taken and same else f"{name} = {given}: it is {now}"


def added_set(rtc: RtcUnderTest) -> Problems:
    """Check that a set can be added, and removed again; other sets are as before."""
    if not rtc.is_of_rtgen:
        raise SkipError("OpenRTM might keep the set")
    before = rtc.sets()
    name, _, text = next(_parameters(rtc), ("", None, ""))
    if not name:
        return
    try:
        taken = rtc.set_value(_UNKNOWN, name, text, add=True)
        found = rtc.sets()
        there = found.pop(_UNKNOWN, {}).get(name) == text
        yield None if taken and there else "an added set is not there"
        yield None if found == before else "other sets have changed"
    finally:
        taken = rtc.configure("remove_configuration_set", _UNKNOWN)
    yield None if taken else "it was not removed"
    yield None if rtc.sets() == before else "after its removal the sets are others"


def _requires_texts_checked(rtc: RtcUnderTest) -> None:
    """Raise SkipError for a component of OpenRTM, whose configuration accepts any text."""
    if not rtc.is_of_rtgen:
        raise SkipError(
            "OpenRTM's configuration accepts any text, and validates it later"
        )


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


def values_beyond(rtc: RtcUnderTest) -> Problems:
    """Check that values beyond limits and constraints are rejected, and the former ones kept."""
    _requires_texts_checked(rtc)
    for name, parameter, before in _parameters(rtc):
        text = parameter.beyond()
        if text is not None:
            yield _wrong_value(rtc, name, text, before)


def values_of_no_type(rtc: RtcUnderTest) -> Problems:
    """Check that texts that are not values of the type are rejected, and the former values kept."""
    _requires_texts_checked(rtc)
    for name, parameter, before in _parameters(rtc):
        text = parameter.of_no_type()
        if text is not None:
            yield _wrong_value(rtc, name, text, before)


def activated_sets(rtc: RtcUnderTest) -> Problems:
    """Check that each set can be activated, and an unknown one is rejected."""
    before = rtc.before.active if rtc.before is not None else rtc.active_set()
    for set_id in (*rtc.sets(), before):
        if not rtc.configure("activate_configuration_set", set_id):
            yield f"set {set_id} was refused"
            continue
        yield _unequal("the active set", rtc.active_set(), set_id)
    operation = "activate_configuration_set"
    yield _refused(rtc, "an unknown set", operation, _UNKNOWN)
    yield _unequal("the active set after that", rtc.active_set(), before)


# Contexts and life cycle


def context_kinds(rtc: RtcUnderTest) -> Problems:
    """Check that the component owns a context of the declared kind, and its profile agrees."""
    if not rtc.contexts:
        yield "it owns no execution context"
    for number, context in enumerate(rtc.contexts):
        kind = rtc.ask(context, "get_kind")
        if number == 0 and rtc.expected.is_periodic:
            yield _unequal("the kind", kind.name, ExecutionKind.PERIODIC.name)
        if kind is ExecutionKind.PERIODIC:
            rate = rtc.ask(context, "get_rate")
            yield None if rate > 0 else f"the rate is {rate} Hz"


def context_profiles(rtc: RtcUnderTest) -> Problems:
    """Check that the profile of a context has its kind, its rate and its owner."""
    for context in rtc.contexts:
        found = rtc.ask(context, "get_profile")
        yield _unequal("its kind", found.kind, rtc.ask(context, "get_kind"))
        yield _unequal("its rate", found.rate, rtc.ask(context, "get_rate"))
        owned = found.owner is not None and found.owner._is_equivalent(rtc.reference)
        yield None if owned else "its owner is another component"
        others = [each for each in found.participants if each is not None]
        once = all(
            not one._is_equivalent(other) for one, other in combinations(others, 2)
        )
        yield None if once else "it has a participant twice"
    for context in rtc.call("get_participating_contexts"):
        found = rtc.ask(context, "get_profile")
        listed = any(
            each is not None and each._is_equivalent(rtc.reference)
            for each in found.participants
        )
        yield None if listed else "a context of another component does not list it"


def default_rate(rtc: RtcUnderTest) -> Problems:
    """Check that the first context has the rate of the definition, if it is periodic."""
    context = rtc.context
    if rtc.ask(context, "get_kind") is not ExecutionKind.PERIODIC:
        raise SkipError("its execution context is not of PERIODIC kind")
    rate = rtc.ask(context, "get_rate")
    same = isclose(rate, rtc.expected.rate, rel_tol=_RATE_TOLERANCE)
    yield None if same else f"the rate is {rate} Hz, not {rtc.expected.rate} Hz"


def context_handles(rtc: RtcUnderTest) -> Problems:
    """Check that a context has a handle, by which the component finds it."""
    handles: set[int] = set()
    for context in (*rtc.contexts, *rtc.call("get_participating_contexts")):
        handle = rtc.call("get_context_handle", context)
        yield f"it has context {handle} twice" if handle in handles else None
        handles.add(handle)
        found = rtc.call("get_context", handle)
        same = found is not None and found._is_equivalent(context)
        yield None if same else f"get_context({handle}) returned another context"
        alive = rtc.call("is_alive", context)
        yield None if alive else f"it is not alive in context {handle}"
    unknown = next(each for each in range(_MAX_HANDLES, 0, -1) if each not in handles)
    found = rtc.call("get_context", unknown)
    yield f"get_context({unknown}) returned a context" if found is not None else None


def states(rtc: RtcUnderTest) -> Problems:
    """Check that the component has a state in each of its contexts."""
    for context in (*rtc.contexts, *rtc.call("get_participating_contexts")):
        state = rtc.ask(context, "get_component_state", rtc.reference)
        yield "its state is CREATED" if state is CREATED_STATE else None


def _rows(rtc: RtcUnderTest, rows: tuple[_Row, ...]) -> Problems:
    """Yield problems of calls with expected return codes, none of which changes the state."""
    context, before = rtc.context, rtc.state()
    for operation, wanted in rows:
        code = rtc.ask(context, operation, rtc.reference)
        same = code is wanted
        problem = f"{before.name}: {operation} returned {code.name}, not {wanted.name}"
        yield None if same else problem
    # A request takes effect at the next tick.
    rtc.remains(before, ticks=_TICKS)
    yield _unequal("the state after refused calls", rtc.state().name, before.name)


def _change(rtc: RtcUnderTest, context: Any, operation: str, state: Any) -> str | None:
    """Return the problem of a request that should lead to a state."""
    code = rtc.ask(context, operation, rtc.reference)
    if code is not RTC_OK:
        return f"{operation} returned {code.name}, not RTC_OK"
    if not rtc.becomes(state):
        return f"{operation} leads to {rtc.state().name}, not to {state.name}"
    return None


def activation(rtc: RtcUnderTest) -> Problems:
    """Check that activation leads to ACTIVE, deactivation to INACTIVE."""
    context = rtc.inactive()
    yield _change(rtc, context, "activate_component", ACTIVE_STATE)
    yield _change(rtc, context, "deactivate_component", INACTIVE_STATE)


def refused_inactive(rtc: RtcUnderTest) -> Problems:
    """Check that an INACTIVE component is neither deactivated nor reset."""
    rtc.inactive()
    yield from _rows(rtc, _FIRST)


def refused_active(rtc: RtcUnderTest) -> Problems:
    """Check that an ACTIVE component is neither activated again nor reset."""
    context = rtc.inactive()
    rtc.ask(context, "activate_component", rtc.reference)
    if not rtc.becomes(ACTIVE_STATE):
        raise SkipError("it does not become ACTIVE")
    yield from _rows(rtc, _WHILE_ACTIVE)
    rtc.inactive()


def refused_in_error(rtc: RtcUnderTest) -> Problems:
    """Check that a component in ERROR is neither activated nor deactivated."""
    if rtc.state() is not ERROR_STATE:
        raise SkipError("it is not in ERROR, and no request leads there")
    yield from _rows(rtc, _IN_ERROR)


def initialization(rtc: RtcUnderTest) -> Problems:
    """Check that the component is not initialized again, nor finalized while in a context."""
    if not rtc.is_of_rtgen:
        raise SkipError("OpenRTM initializes a component again")
    for operation in ("initialize", "finalize"):
        code = rtc.call(operation)
        yield _unequal(operation, code.name, PRECONDITION_NOT_MET.name)
    yield None if rtc.is_alive() else "it is no longer alive"


class _Stranger:
    """A component without operations that participates in no context."""


def strangers(rtc: RtcUnderTest) -> Problems:
    """Check that a context rejects requests for a component that does not participate in it."""
    stranger = rtc.exported.serve(DATA_FLOW_COMPONENT, _Stranger())
    try:
        for operation in (
            *("activate_component", "deactivate_component"),
            *("reset_component", "remove_component"),
        ):
            code = rtc.ask(rtc.context, operation, stranger)
            yield _unequal(operation, code.name, BAD_PARAMETER.name)
    finally:
        rtc.exported.withdraw(stranger)


def running(rtc: RtcUnderTest) -> Problems:
    """Check that a context stops and starts, each only once."""
    context = rtc.inactive()
    for operation, wanted, runs in (
        ("start", PRECONDITION_NOT_MET, True),
        ("stop", RTC_OK, False),
        ("stop", PRECONDITION_NOT_MET, False),
        ("start", RTC_OK, True),
    ):
        code = rtc.ask(context, operation)
        yield _unequal(operation, code.name, wanted.name)
        yield _unequal("is_running", bool(rtc.ask(context, "is_running")), runs)


def rates(rtc: RtcUnderTest) -> Problems:
    """Check that a periodic context accepts another rate, and rejects one that is not above 0."""
    context = rtc.inactive()
    if rtc.ask(context, "get_kind") is not ExecutionKind.PERIODIC:
        raise SkipError("its execution context is not of PERIODIC kind")
    before = rtc.ask(context, "get_rate")
    for rate, wanted, after in (
        (before / 2, RTC_OK, before / 2),
        (0.0, BAD_PARAMETER, before / 2),
        (-1.0, BAD_PARAMETER, before / 2),
        (before, RTC_OK, before),
    ):
        code = rtc.ask(context, "set_rate", rate)
        yield _unequal(f"set_rate({rate})", code.name, wanted.name)
        yield _unequal("the rate", rtc.ask(context, "get_rate"), after)


def exits(rtc: RtcUnderTest) -> Problems:
    """Check that a component is gone in time after `exit`."""
    code = rtc.call("exit")
    if code is UNSUPPORTED and rtc.is_alive():
        raise SkipError("it ends only with its process: exit returned UNSUPPORTED")
    yield _unequal("exit", code.name, RTC_OK.name)
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
    Check("ports.names", "the ports are those of the definition", _PORTS, port_names),
    Check("ports.directions", "ports have their directions", _PORTS, directions),
    Check("ports.types", "data ports have their types", _PORTS, data_types),
    Check(
        "ports.interfaces",
        "service ports have their interfaces",
        _PORTS,
        interfaces,
    ),
    Check(
        "ports.references",
        "each port is listed with its profile",
        _PORTS,
        port_references,
    ),
    Check(
        "ports.unknown",
        "an unknown connector is not disconnected",
        _PORTS,
        unknown_connectors,
    ),
    Check(
        "configuration.names",
        "the parameters are those of the definition",
        _SETS,
        parameter_names,
    ),
    Check(
        "configuration.values",
        "values are of their types and within their limits",
        _SETS,
        parameter_values,
    ),
    Check(
        "configuration.defaults",
        "values are the defaults of the definition",
        _SETS,
        default_values,
        Permission.DEFAULTS,
    ),
    Check("configuration.active", "the active set is there", _SETS, active_set),
    Check(
        "configuration.reads",
        "operations that read values agree",
        _SETS,
        read_values,
    ),
    Check(
        "configuration.unknown",
        "unknown sets and parameters are refused",
        _SETS,
        unknown_names,
    ),
    Check(
        "contexts.kind",
        "it owns a context of the declared kind",
        _CONTEXTS,
        context_kinds,
    ),
    Check(
        "contexts.profile",
        "contexts report kind, rate and owner",
        _CONTEXTS,
        context_profiles,
    ),
    Check(
        "contexts.defaults",
        "the rate is that of the definition",
        _CONTEXTS,
        default_rate,
        Permission.DEFAULTS,
    ),
    Check("contexts.handles", "contexts have handles", _CONTEXTS, context_handles),
    Check("contexts.state", "it has a state in each context", _LIFE, states),
    Check(
        "life-cycle.error",
        "in ERROR it is neither activated nor deactivated",
        _LIFE,
        refused_in_error,
        ACTUATE,
    ),
    Check(
        "life-cycle.inactive",
        "while INACTIVE it is neither deactivated nor reset",
        _LIFE,
        refused_inactive,
        ACTUATE,
    ),
    Check(
        "life-cycle.activation",
        "it becomes ACTIVE, and INACTIVE again",
        _LIFE,
        activation,
        ACTUATE,
    ),
    Check(
        "life-cycle.active",
        "while ACTIVE it is neither activated nor reset",
        _LIFE,
        refused_active,
        ACTUATE,
    ),
    Check(
        "contexts.strangers",
        "requests for other components are refused",
        _CONTEXTS,
        strangers,
        ACTUATE,
    ),
    Check(
        "contexts.running",
        "its context starts and stops",
        _CONTEXTS,
        running,
        ACTUATE,
    ),
    Check(
        "contexts.rate",
        "its context accepts only rates above 0",
        _CONTEXTS,
        rates,
        ACTUATE,
    ),
    Check(
        "configuration.set",
        "parameters accept other values",
        _SETS,
        set_values,
        ACTUATE,
    ),
    Check(
        "configuration.parameters",
        "single parameters of the active set are set",
        _SETS,
        set_parameters,
        ACTUATE,
    ),
    Check(
        "configuration.added",
        "a set is added and removed",
        _SETS,
        added_set,
        ACTUATE,
    ),
    Check(
        "configuration.limits",
        "values beyond their limits are refused",
        _SETS,
        values_beyond,
        ACTUATE,
    ),
    Check(
        "configuration.types",
        "values of other types are refused",
        _SETS,
        values_of_no_type,
        ACTUATE,
    ),
    Check(
        "configuration.sets",
        "each set becomes the active one",
        _SETS,
        activated_sets,
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
        initialization,
        Permission.EXIT,
    ),
    Check("exit", "it exits, and is gone", _PROFILE, exits, Permission.EXIT),
)
