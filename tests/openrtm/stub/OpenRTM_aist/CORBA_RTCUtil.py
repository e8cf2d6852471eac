"""Functions for clients of components, ports and configurations."""

from __future__ import annotations

from typing import Any

import RTC
from omniORB import CORBA

from .contexts import FOREIGN
from .NVUtil import list_of, properties_of
from .properties import Properties


def get_component_profile(rtc: Any) -> Properties:
    """Return the properties of a component's profile."""
    if CORBA.is_nil(rtc):
        return Properties()
    return properties_of(rtc.get_component_profile().properties)


def is_existing(rtc: Any) -> bool:
    try:
        return not rtc._non_existent()
    except CORBA.SystemException:
        return False


def get_actual_ec(rtc: Any, ec_id: int = 0) -> Any:
    if ec_id < 0 or CORBA.is_nil(rtc):
        return None
    if ec_id < FOREIGN:
        contexts, place = rtc.get_owned_contexts(), ec_id
    else:
        contexts, place = rtc.get_participating_contexts(), ec_id - FOREIGN
    return contexts[place] if place < len(contexts) else None


def get_ec_id(rtc: Any, ec: Any) -> int:
    if CORBA.is_nil(rtc) or CORBA.is_nil(ec):
        return -1
    for first, contexts in (
        (0, rtc.get_owned_contexts()),
        (FOREIGN, rtc.get_participating_contexts()),
    ):
        for place, known in enumerate(contexts):
            if known._is_equivalent(ec):
                return first + place
    return -1


def is_alive_in_default_ec(rtc: Any) -> bool:
    ec = get_actual_ec(rtc)
    return not CORBA.is_nil(ec) and bool(rtc.is_alive(ec))


def activate(rtc: Any, ec_id: int = 0) -> Any:
    ec = get_actual_ec(rtc, ec_id)
    return RTC.BAD_PARAMETER if CORBA.is_nil(ec) else ec.activate_component(rtc)


def deactivate(rtc: Any, ec_id: int = 0) -> Any:
    ec = get_actual_ec(rtc, ec_id)
    return RTC.BAD_PARAMETER if CORBA.is_nil(ec) else ec.deactivate_component(rtc)


def reset(rtc: Any, ec_id: int = 0) -> Any:
    ec = get_actual_ec(rtc, ec_id)
    return RTC.BAD_PARAMETER if CORBA.is_nil(ec) else ec.reset_component(rtc)


def get_state(rtc: Any, ec_id: int = 0) -> tuple[bool, Any]:
    """Return whether there is such a context, and the component's state in it."""
    ec = get_actual_ec(rtc, ec_id)
    if CORBA.is_nil(ec):
        return False, RTC.CREATED_STATE
    return True, ec.get_component_state(rtc)


def is_in_inactive(rtc: Any, ec_id: int = 0) -> bool:
    return get_state(rtc, ec_id) == (True, RTC.INACTIVE_STATE)


def is_in_active(rtc: Any, ec_id: int = 0) -> bool:
    return get_state(rtc, ec_id) == (True, RTC.ACTIVE_STATE)


def is_in_error(rtc: Any, ec_id: int = 0) -> bool:
    return get_state(rtc, ec_id) == (True, RTC.ERROR_STATE)


def get_default_rate(rtc: Any) -> float:
    return get_current_rate(rtc, 0)


def set_default_rate(rtc: Any, rate: float) -> Any:
    return set_current_rate(rtc, 0, rate)


def get_current_rate(rtc: Any, ec_id: int) -> float:
    rate: float = get_actual_ec(rtc, ec_id).get_rate()
    return rate


def set_current_rate(rtc: Any, ec_id: int, rate: float) -> Any:
    return get_actual_ec(rtc, ec_id).set_rate(rate)


def add_rtc_to_default_ec(localcomp: Any, othercomp: Any) -> Any:
    ec = get_actual_ec(localcomp)
    if CORBA.is_nil(ec) or CORBA.is_nil(othercomp):
        return RTC.BAD_PARAMETER
    return ec.add_component(othercomp)


def remove_rtc_to_default_ec(localcomp: Any, othercomp: Any) -> Any:
    ec = get_actual_ec(localcomp)
    if CORBA.is_nil(ec) or CORBA.is_nil(othercomp):
        return RTC.BAD_PARAMETER
    return ec.remove_component(othercomp)


def get_participants_rtc(rtc: Any) -> list[Any]:
    ec = get_actual_ec(rtc)
    participants: list[Any] = [] if CORBA.is_nil(ec) else ec.get_profile().participants
    return participants


def get_port_names(rtc: Any) -> list[str]:
    return _names_of(rtc, None)


def get_inport_names(rtc: Any) -> list[str]:
    return _names_of(rtc, "DataInPort")


def get_outport_names(rtc: Any) -> list[str]:
    return _names_of(rtc, "DataOutPort")


def get_svcport_names(rtc: Any) -> list[str]:
    return _names_of(rtc, "CorbaPort")


def _names_of(rtc: Any, kind: str | None) -> list[str]:
    profiles = (
        [] if CORBA.is_nil(rtc) else [p.get_port_profile() for p in rtc.get_ports()]
    )
    return [
        profile.name
        for profile in profiles
        if kind is None
        or properties_of(profile.properties).getProperty("port.port_type") == kind
    ]


def get_port_by_name(rtc: Any, port_name: str) -> Any:
    """Return the port of a full name, `<instance>.<port>`; None if there is none."""
    for port in [] if CORBA.is_nil(rtc) else rtc.get_ports():
        if port.get_port_profile().name == port_name:
            return port
    return None


def get_connector_names_by_portref(port: Any) -> list[str]:
    return [c.name for c in port.get_connector_profiles()]


def get_connector_ids_by_portref(port: Any) -> list[str]:
    return [c.connector_id for c in port.get_connector_profiles()]


def create_connector(name: str, prop_arg: Properties, port0: Any, port1: Any) -> Any:
    """Return a profile, by default pushed over CORBA."""
    for key, default in (
        ("dataport.dataflow_type", "push"),
        ("dataport.interface_type", "corba_cdr"),
    ):
        if not prop_arg.getProperty(key):
            prop_arg.setProperty(key, default)
    ports = [port0] if CORBA.is_nil(port1) else [port0, port1]
    return RTC.ConnectorProfile(name, "", ports, list_of(prop_arg))


def already_connected(localport: Any, otherport: Any) -> bool:
    return any(
        port._is_equivalent(otherport)
        for connection in localport.get_connector_profiles()
        for port in connection.ports
    )


def connect(name: str, prop: Properties, port0: Any, port1: Any) -> Any:
    if CORBA.is_nil(port0):
        return RTC.BAD_PARAMETER
    if not CORBA.is_nil(port1) and port0._is_equivalent(port1):
        return RTC.BAD_PARAMETER
    return port0.connect(create_connector(name, prop, port0, port1))[0]


def connect_multi(
    name: str, prop: Properties, port: Any, target_ports: list[Any]
) -> Any:
    if CORBA.is_nil(port):
        return RTC.BAD_PARAMETER
    code = RTC.RTC_OK
    for target in target_ports:
        if (
            CORBA.is_nil(target)
            or target._is_equivalent(port)
            or already_connected(port, target)
        ):
            continue
        if connect(name, prop, port, target) != RTC.RTC_OK:
            code = RTC.BAD_PARAMETER
    return code


def connect_by_name(
    name: str, prop: Properties, rtc0: Any, port_name0: str, rtc1: Any, port_name1: str
) -> Any:
    port0, port1 = get_port_by_name(rtc0, port_name0), get_port_by_name(
        rtc1, port_name1
    )
    if CORBA.is_nil(port0) or CORBA.is_nil(port1):
        return RTC.BAD_PARAMETER
    return connect(name, prop, port0, port1)


def disconnect(connector_prof: Any) -> Any:
    return connector_prof.ports[0].disconnect(connector_prof.connector_id)


def disconnect_by_portref_connector_id(port_ref: Any, conn_id: str) -> Any:
    return RTC.BAD_PARAMETER if CORBA.is_nil(port_ref) else port_ref.disconnect(conn_id)


def disconnect_by_portref_connector_name(port_ref: Any, conn_name: str) -> Any:
    for connection in (
        [] if CORBA.is_nil(port_ref) else port_ref.get_connector_profiles()
    ):
        if connection.name == conn_name:
            return disconnect(connection)
    return RTC.BAD_PARAMETER


def disconnect_all_by_ref(port_ref: Any) -> Any:
    return RTC.BAD_PARAMETER if CORBA.is_nil(port_ref) else port_ref.disconnect_all()


def get_configuration(rtc: Any, conf_name: str) -> Properties:
    found = rtc.get_configuration().get_configuration_set(conf_name)
    return properties_of(found.configuration_data)


def get_parameter_by_key(rtc: Any, confset_name: str, value_name: str) -> str:
    return get_configuration(rtc, confset_name).getProperty(value_name)


def get_active_configuration_name(rtc: Any) -> str:
    name: str = rtc.get_configuration().get_active_configuration_set().id
    return name


def get_active_configuration(rtc: Any) -> Properties:
    return get_configuration(rtc, get_active_configuration_name(rtc))


def set_configuration(rtc: Any, confset_name: str, value_name: str, value: str) -> bool:
    """Set a parameter and activate its set."""
    configuration = rtc.get_configuration()
    found = configuration.get_configuration_set(confset_name)
    changed = properties_of(found.configuration_data)
    changed.setProperty(value_name, value)
    found.configuration_data = list_of(changed)
    configuration.set_configuration_set_values(found)
    configuration.activate_configuration_set(confset_name)
    return True


def set_active_configuration(rtc: Any, value_name: str, value: str) -> bool:
    return set_configuration(rtc, get_active_configuration_name(rtc), value_name, value)
