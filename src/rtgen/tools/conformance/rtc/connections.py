"""Checks that connect ports of a running component with a port of this process."""

from __future__ import annotations

import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

from msgspec.structs import replace

from rtgen.facts.connector_properties import STRICTNESS
from rtgen.facts.openrtm_ports import known_name
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.wire import (
    IN_PORT_CDR,
    PORT_SERVICE,
    ConnectorProfile,
    PortProfile,
    texts,
    values,
)
from rtgen.runtime.return_codes import RTC_OK, PortStatus, ReturnCode_t
from rtgen.tools.conformance.check import ACTUATE, Problems, SkipError, check
from rtgen.tools.conformance.rtc.component import CONNECTOR, RtcUnderTest
from rtgen.tools.conformance.rtc.expected import ExpectedInterface
from rtgen.tools.conformance.rtc.port_checks import PORTS

_IN_IOR: Final = "dataport.corba_cdr.inport_ior"
_WISHES: Final = {
    "dataport.interface_type": "corba_cdr",
    "dataport.dataflow_type": "push",
    "dataport.subscription_type": "flush",
}
_STRICT: Final = {STRICTNESS: "strict"}
_NO_SERVICE: Final = "rtgen::Conformance::NoType"
"""The name of an interface that no port has."""
_NO_TYPE: Final = {"dataport.data_type": "IDL:rtgen/Conformance/NoType:1.0"}
_NO_INTERFACE: Final = {"dataport.interface_type": "rtgen-conformance-none"}


class _Sink:
    """Receives the samples of an OutPort."""

    def put(self, data: object) -> PortStatus:
        """See `OpenRTM::InPortCdr`."""
        return PortStatus.PORT_OK


class _Partner:
    """The port of this process: the last one of a connector, which accepts everything.

    For each instance of `offered` it offers an object of an interface that no port has.
    """

    def __init__(self, exported: Exported, offered: Iterable[str] = ()) -> None:
        self.ended: list[str] = []
        """The ids of connections that the component has ended at this port."""
        self._offered = tuple(offered)
        self._exported = exported
        self._sink = exported.serve(IN_PORT_CDR, _Sink())
        self.reference = exported.serve(PORT_SERVICE, self)

    def close(self) -> None:
        """Deactivate the objects."""
        self._exported.withdraw(self.reference)
        self._exported.withdraw(self._sink)

    def get_port_profile(self) -> PortProfile:
        """See `RTC::PortService`."""
        return PortProfile("conformance", [], self.reference, [], None, [])

    def get_connector_profiles(self) -> list[ConnectorProfile]:
        """See `RTC::PortService`."""
        return []

    def notify_connect(self, profile: ConnectorProfile) -> tuple[ReturnCode_t, Any]:
        """Offer an InPort for pushed samples, unless the component offers one."""
        own = self._exported.text(self._sink)
        added = {f"port.{_NO_SERVICE}.{instance}": own for instance in self._offered}
        if _IN_IOR not in texts(profile.properties):
            added[_IN_IOR] = own
        properties = [*profile.properties, *values(added)]
        return RTC_OK, replace(profile, properties=properties)

    def notify_disconnect(self, connector_id: str) -> ReturnCode_t:
        """Record the end of a connection."""
        self.ended.append(connector_id)
        return RTC_OK


@contextmanager
def _partner(rtc: RtcUnderTest, offered: Iterable[str] = ()) -> Iterator[_Partner]:
    partner = _Partner(rtc.exported, offered)
    try:
        yield partner
    finally:
        partner.close()


def _profile(
    port: Any, partner: _Partner, properties: Mapping[str, str]
) -> ConnectorProfile:
    name = f"{CONNECTOR}{uuid.uuid4()}"
    own = texts(port.properties)
    stated = dict(properties)
    if "dataport.data_type" in own:
        type_ = {"dataport.data_type": own["dataport.data_type"]}
        stated = {**_WISHES, **type_, **properties}
    ends = [port.port_ref, partner.reference]
    return ConnectorProfile(name, name, ends, values(stated))


@check("connections", "ports are connected and disconnected", PORTS, ACTUATE)
def connected(rtc: RtcUnderTest) -> Problems:
    """Check that each port can be connected, lists the connector, and can be disconnected."""
    rtc.inactive()
    with _partner(rtc) as partner:
        for port in rtc.profile.port_profiles:
            problems = _connected(rtc, port, partner)
            name = known_name(port.name)
            yield from (None if p is None else f"{name}: {p}" for p in problems)


def _connected(rtc: RtcUnderTest, port: Any, partner: _Partner) -> Problems:
    def call(operation: str, *arguments: Any) -> Any:
        return rtc.at_port(port, operation, *arguments)

    asked = _profile(port, partner, {})
    identity = asked.connector_id
    code, profile_made = call("connect", asked)
    if code is not RTC_OK:
        yield f"connect returned {code.name}"
        return
    same = (profile_made.name, profile_made.connector_id, len(profile_made.ports)) == (
        identity,
        identity,
        2,
    )
    yield None if same else "connect changed name, id or ports"
    if texts(port.properties).get("port.port_type") == "DataInPort":
        yield _offered(rtc, texts(profile_made.properties))
    yield _changed("connect", asked, profile_made)
    listed = [each.connector_id for each in call("get_connector_profiles")]
    yield None if identity in listed else "its connector is not listed"
    own = call("get_port_profile").connector_profiles
    shown = identity in [each.connector_id for each in own]
    yield None if shown else "its connector is not in its profile"
    profile = call("get_connector_profile", identity)
    is_same = profile.connector_id == identity and profile.name == identity
    yield None if is_same else "get_connector_profile returned another profile"
    yield _changed("get_connector_profile", asked, profile)
    code = call("disconnect", identity)
    yield None if code is RTC_OK else f"disconnect returned {code.name}"
    listed = [each.connector_id for each in call("get_connector_profiles")]
    yield "its connector is still listed" if identity in listed else None
    notified = identity in partner.ended
    yield None if notified else "it did not notify the other port of the disconnection"


def _offered(rtc: RtcUnderTest, properties: Mapping[str, str]) -> str | None:
    """Return the problem of the object that an InPort offers for its samples."""
    if _IN_IOR not in properties:
        return f"it has offered no {_IN_IOR}"
    reference = rtc.exported.reference(properties[_IN_IOR])
    is_one = reference is not None and reference._is_a(IN_PORT_CDR.repository_id)
    return None if is_one else f"its {_IN_IOR} is not that of an InPort"


def _changed(
    operation: str, asked: ConnectorProfile, actual: ConnectorProfile
) -> str | None:
    """Return the problem of a profile that states another transfer of data."""
    expected, stated = texts(asked.properties), texts(actual.properties)
    for key in ("dataport.interface_type", "dataport.dataflow_type"):
        if key in expected and stated.get(key) != expected[key]:
            return f"{operation}: {key} is {stated.get(key)!r}, not {expected[key]!r}"
    return None


@check("connections.all", "all connections of a port are ended", PORTS, ACTUATE)
def all_ended(rtc: RtcUnderTest) -> Problems:
    """Check that `disconnect_all` ends a connection; ports with others are left out."""
    rtc.inactive()
    ports = rtc.profile.port_profiles
    free = [port for port in ports if not rtc.at_port(port, "get_connector_profiles")]
    if ports and not free:
        raise SkipError("each port has other connections")
    with _partner(rtc) as partner:
        for port in free:
            name = known_name(port.name)
            asked = _profile(port, partner, {})
            code, _ = rtc.at_port(port, "connect", asked)
            if code is not RTC_OK:
                continue  # `connections` reports it.
            code = rtc.at_port(port, "disconnect_all")
            yield None if code is RTC_OK else f"{name}: it returned {code.name}"
            remains = _dropped(rtc, port, asked.connector_id)
            yield f"{name}: the connector is still listed" if remains else None
            notified = asked.connector_id in partner.ended
            yield None if notified else f"{name}: the other port was not notified"


def _refused(rtc: RtcUnderTest, properties: Mapping[str, str]) -> Problems:
    """Check that data ports reject a connection with wrong properties, and keep none."""
    rtc.inactive()
    with _partner(rtc) as partner:
        for port in rtc.profile.port_profiles:
            if "dataport.data_type" not in texts(port.properties):
                continue
            name = known_name(port.name)
            asked = _profile(port, partner, properties)
            code, _ = rtc.at_port(port, "connect", asked)
            yield f"{name}: it was not refused" if code is RTC_OK else None
            remains = _dropped(rtc, port, asked.connector_id)
            yield f"{name}: its connector is listed" if remains else None


def _dropped(rtc: RtcUnderTest, port: Any, connector_id: str) -> bool:
    """Return whether an unwanted connection exists, and end it."""
    profiles = rtc.at_port(port, "get_connector_profiles")
    stood = connector_id in [each.connector_id for each in profiles]
    if stood:
        rtc.at_port(port, "disconnect", connector_id)
    return stood


@check(
    "connections.types",
    "samples of other types are refused",
    "docs/openrtm.md",
    ACTUATE,
)
def other_types(rtc: RtcUnderTest) -> Problems:
    """Check that data ports reject samples of another type."""
    if not rtc.is_of_rtgen:
        raise SkipError("OpenRTM does not compare types of data")
    yield from _refused(rtc, _NO_TYPE)


@check(
    "connections.interfaces",
    "unknown interface types are refused",
    "docs/openrtm.md",
    ACTUATE,
)
def other_interfaces(rtc: RtcUnderTest) -> Problems:
    """Check that data ports reject an unknown interface type."""
    yield from _refused(rtc, _NO_INTERFACE)


@check(
    "connections.services",
    "provided interfaces have their types, required ones accept only theirs",
    PORTS,
    ACTUATE,
)
def services(rtc: RtcUnderTest) -> Problems:
    """Check that provided interfaces have their types, and required ones reject other types.

    A strict connection must be rejected if a required interface has no provider of its type.
    """
    rtc.inactive()
    for port in rtc.profile.port_profiles:
        name = known_name(port.name)
        expected = rtc.expected.ports.get(name)
        interfaces = {} if expected is None else expected.interfaces or {}
        for (instance, is_provided), interface in interfaces.items():
            if not is_provided and (instance, True) in interfaces:
                continue  # OpenRTM connects it with the provider of its own port.
            check = _provided if is_provided else _required
            problem = check(rtc, port, instance, interface)
            yield None if problem is None else f"{name}.{instance}: {problem}"


def _provided(
    rtc: RtcUnderTest, port: Any, instance: str, interface: ExpectedInterface
) -> str | None:
    with _partner(rtc) as partner:
        asked = _profile(port, partner, {})
        code, profile = rtc.at_port(port, "connect", asked)
        if code is not RTC_OK:
            return f"connect returned {code.name}"
        try:
            offered = texts(profile.properties)
            keys = (f"port.{name}.{instance}" for name in interface.names)
            text = next((offered[key] for key in keys if key in offered), None)
            if text is None:
                return "the connector has no reference of it"
            reference = rtc.exported.reference(text)
            is_one = reference is not None and reference._is_a(interface.identity)
            return None if is_one else f"its object is no {interface.names[0]}"
        finally:
            rtc.at_port(port, "disconnect", asked.connector_id)


def _required(
    rtc: RtcUnderTest, port: Any, instance: str, _interface: ExpectedInterface
) -> str | None:
    with _partner(rtc, [instance]) as partner:
        asked = _profile(port, partner, _STRICT)
        code, _ = rtc.at_port(port, "connect", asked)
        _dropped(rtc, port, asked.connector_id)
        return "it accepts another type" if code is RTC_OK else None
