"""Checks of the ports of a running component."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from rtgen.facts.openrtm_ports import known_name
from rtgen.runtime.corba.rt_objects.wire import PortInterfacePolarity, texts
from rtgen.runtime.return_codes import BAD_PARAMETER
from rtgen.tools.conformance.check import Problems, check, unequal
from rtgen.tools.conformance.rtc.component import UNKNOWN, RtcUnderTest
from rtgen.tools.conformance.rtc.expected import ExpectedPort

PORTS: Final = "OMG RTC 1.0, PortService, PortProfile"


def _profiles(rtc: RtcUnderTest) -> dict[str, Any]:
    """Return the profiles of ports by name."""
    return {known_name(port.name): port for port in rtc.profile.port_profiles}


def _common(rtc: RtcUnderTest) -> Iterator[tuple[str, ExpectedPort, Any]]:
    """Yield the ports both defined and present; `ports.names` reports others."""
    ports = _profiles(rtc)
    for name, expected in rtc.expected.ports.items():
        if name in ports:
            yield name, expected, ports[name]


@check("ports.names", "the ports are those of the definition", PORTS)
def port_names(rtc: RtcUnderTest) -> Problems:
    ports, expected_ports = _profiles(rtc), rtc.expected.ports
    for name in expected_ports:
        yield None if name in ports else f"there is no port {name}"
    for name in ports:
        if name not in expected_ports:
            yield f"the definition has no port {name}"
    names = [known_name(port.name) for port in rtc.profile.port_profiles]
    for name in ports:
        yield None if names.count(name) == 1 else f"port {name} is there twice"


@check("ports.directions", "ports have their directions", PORTS)
def directions(rtc: RtcUnderTest) -> Problems:
    """Check that ports are inputs, outputs and service ports as declared."""
    for name, expected, port in _common(rtc):
        type_ = texts(port.properties).get("port.port_type")
        yield unequal(f"{name}: port.port_type", type_, expected.port_type)


@check("ports.types", "data ports have their types", PORTS)
def data_types(rtc: RtcUnderTest) -> Problems:
    """Check that data ports have the declared types."""
    for name, expected, port in _common(rtc):
        if expected.data_types:
            type_ = texts(port.properties).get("dataport.data_type", "")
            is_expected = type_ in expected.data_types
            data_type = expected.data_types[0]
            yield (
                None
                if is_expected
                else f"{name}: its type is {type_!r}, not {data_type!r}"
            )


@check("ports.interfaces", "service ports have their interfaces", PORTS)
def interfaces(rtc: RtcUnderTest) -> Problems:
    """Check that service ports have the declared interfaces: name, type and polarity."""
    for name, expected, port in _common(rtc):
        if expected.interfaces is None:
            continue
        actual = {
            (i.instance_name, i.polarity == PortInterfacePolarity.PROVIDED): i.type_name
            for i in port.interfaces
        }
        for key, interface in expected.interfaces.items():
            types = interface.names
            what = f"{name}: {'provided' if key[1] else 'required'} {key[0]}"
            if key not in actual:
                yield f"{what} is missing"
            else:
                is_expected = actual[key] in types
                yield (
                    None
                    if is_expected
                    else f"{what} has type {actual[key]}, not {types[0]}"
                )
        for instance, _ in actual.keys() - expected.interfaces.keys():
            yield f"{name}: the definition has no such {instance}"
        once = len(actual) == len(port.interfaces)
        yield None if once else f"{name}: an interface is there twice"


@check("ports.references", "each port is listed with its profile", PORTS)
def port_references(rtc: RtcUnderTest) -> Problems:
    """Check that `get_ports` returns the ports of the profile, with equal profiles."""
    references = rtc.call("get_ports")
    yield unequal("the number of ports", len(references), len(_profiles(rtc)))
    for name, port in _profiles(rtc).items():
        own = rtc.at_port(port, "get_port_profile")
        listed = any(port.port_ref._is_equivalent(each) for each in references)
        yield None if listed else f"{name} is not among get_ports"
        yield unequal("the port's own name", own.name, port.name)
        owned = own.owner is not None and own.owner._is_equivalent(rtc.reference)
        yield None if owned else f"{name}: the owner is another one"


@check("ports.unknown", "an unknown connector is not disconnected", PORTS)
def unknown_connectors(rtc: RtcUnderTest) -> Problems:
    """Check that ports refuse to end an unknown connection."""
    for name, port in _profiles(rtc).items():
        code = rtc.at_port(port, "disconnect", UNKNOWN)
        problem = f"{name}: disconnect of an unknown id returned {code.name}"
        yield None if code is BAD_PARAMETER else f"{problem}, not BAD_PARAMETER"
        unknown = rtc.at_port(port, "get_connector_profile", UNKNOWN).connector_id
        yield f"{name}: an unknown id leads to connector {unknown}" if unknown else None
