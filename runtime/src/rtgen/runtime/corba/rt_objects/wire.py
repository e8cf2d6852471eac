"""Types and interfaces of SDO 1.1, RTC 1.0 and OpenRTM-aist 2.x as descriptors of omniORBpy.

References have no interface of their own on the wire, so all of them are `Object` here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import IntEnum
from typing import Any

import msgspec
from omniORB import CORBA, tcInternal
from omniORB import any as anys

from rtgen.runtime.return_codes import (
    ExecutionKind,
    LifeCycleState,
    PortStatus,
    ReturnCode_t,
)

_SDO = "IDL:org.omg/SDOPackage/"
_RTC = "IDL:omg.org/RTC/"
_OPENRTM = "IDL:OpenRTM/"

_STRING = tcInternal.tv_string, 0
_ANY = tcInternal.tv_any
_LONG = tcInternal.tv_long
_DOUBLE = tcInternal.tv_double
_BOOLEAN = tcInternal.tv_boolean
_OBJECT = CORBA._d_Object


def _sequence(item: Any) -> Any:
    return tcInternal.tv_sequence, item, 0


def _enum(class_: Any, repository_id: str, count: int) -> Any:
    items: Any = tuple(class_)[:count]
    for item in items:
        item._n, item._v, item._parent_id = item.name, int(item), repository_id
    return tcInternal.tv_enum, repository_id, class_.__name__, items


def _struct(class_: type[Any], scope: str, *types: Any) -> Any:
    members = class_.__struct_fields__
    flat = [part for pair in zip(members, types, strict=True) for part in pair]
    name = class_.__name__
    return tcInternal.tv_struct, class_, f"{scope}{name}:1.0", name, *flat


class PortInterfacePolarity(IntEnum):
    """Whether a service port provides or requires an interface."""

    PROVIDED = 0
    REQUIRED = 1


class NameValue(msgspec.Struct):
    """A property; the value is an `any`."""

    name: str
    value: Any


class DeviceProfile(msgspec.Struct):
    """`SDOPackage::DeviceProfile`."""

    device_type: str = ""
    manufacturer: str = ""
    model: str = ""
    version: str = ""
    properties: list[NameValue] = msgspec.field(default_factory=list)


class ServiceProfile(msgspec.Struct):
    """`SDOPackage::ServiceProfile`."""

    id: str
    interface_type: str
    properties: list[NameValue]
    service: Any


class ConfigurationSet(msgspec.Struct):
    """`SDOPackage::ConfigurationSet`."""

    id: str
    description: str
    configuration_data: list[NameValue]


class PortInterfaceProfile(msgspec.Struct):
    """`RTC::PortInterfaceProfile`."""

    instance_name: str
    type_name: str
    polarity: PortInterfacePolarity


class ConnectorProfile(msgspec.Struct):
    """`RTC::ConnectorProfile`; `ports` are references to port services."""

    name: str
    connector_id: str
    ports: list[Any]
    properties: list[NameValue]


class PortProfile(msgspec.Struct):
    """`RTC::PortProfile`."""

    name: str
    interfaces: list[PortInterfaceProfile]
    port_ref: Any
    connector_profiles: list[ConnectorProfile]
    owner: Any
    properties: list[NameValue]


class ExecutionContextProfile(msgspec.Struct):
    """`RTC::ExecutionContextProfile`; the rate is in Hz."""

    kind: ExecutionKind
    rate: float
    owner: Any
    participants: list[Any]
    properties: list[NameValue]


class ComponentProfile(msgspec.Struct):
    """`RTC::ComponentProfile`."""

    instance_name: str
    type_name: str
    description: str
    version: str
    vendor: str
    category: str
    port_profiles: list[PortProfile]
    parent: Any
    properties: list[NameValue]


_NV = _struct(NameValue, _SDO, _STRING, _ANY)
_NV_LIST = _sequence(_NV)
_DEVICE = _struct(DeviceProfile, _SDO, _STRING, _STRING, _STRING, _STRING, _NV_LIST)
_SERVICE = _struct(ServiceProfile, _SDO, _STRING, _STRING, _NV_LIST, _OBJECT)
_SET = _struct(ConfigurationSet, _SDO, _STRING, _STRING, _NV_LIST)
_CODE = _enum(ReturnCode_t, f"{_RTC}ReturnCode_t:1.0", 6)
_STATE = _enum(LifeCycleState, f"{_RTC}LifeCycleState:1.0", 4)
_KIND = _enum(ExecutionKind, f"{_RTC}ExecutionKind:1.0", 3)
_POLARITY = _enum(PortInterfacePolarity, f"{_RTC}PortInterfacePolarity:1.0", 2)
_STATUS = _enum(PortStatus, f"{_OPENRTM}PortStatus:1.0", 6)
_INTERFACE = _struct(PortInterfaceProfile, _RTC, _STRING, _STRING, _POLARITY)
_OBJECTS = _sequence(_OBJECT)
_CONNECTOR = _struct(ConnectorProfile, _RTC, _STRING, _STRING, _OBJECTS, _NV_LIST)
_PORT = _struct(
    PortProfile,
    _RTC,
    *(_STRING, _sequence(_INTERFACE), _OBJECT),
    *(_sequence(_CONNECTOR), _OBJECT, _NV_LIST),
)
_CONTEXT = _struct(
    ExecutionContextProfile, _RTC, _KIND, _DOUBLE, _OBJECT, _OBJECTS, _NV_LIST
)
_COMPONENT = _struct(
    ComponentProfile, _RTC, *[_STRING] * 6, _sequence(_PORT), _OBJECT, _NV_LIST
)
_OCTETS = tcInternal.tv_sequence, tcInternal.tv_octet, 0


class SdoError(CORBA.UserException):  # type: ignore[misc]
    """An exception of SDOPackage."""

    def __init__(self, description: str) -> None:
        CORBA.UserException.__init__(self, description)
        self.description = description


class NotAvailable(SdoError):
    """`SDOPackage::NotAvailable`."""

    _NP_RepositoryId = f"{_SDO}NotAvailable:1.0"


class InterfaceNotImplemented(SdoError):
    """`SDOPackage::InterfaceNotImplemented`."""

    _NP_RepositoryId = f"{_SDO}InterfaceNotImplemented:1.0"


class InvalidParameter(SdoError):
    """`SDOPackage::InvalidParameter`."""

    _NP_RepositoryId = f"{_SDO}InvalidParameter:1.0"


class InternalError(SdoError):
    """`SDOPackage::InternalError`."""

    _NP_RepositoryId = f"{_SDO}InternalError:1.0"


def _exceptions(*classes: Any) -> Mapping[str, Any]:
    return {
        each._NP_RepositoryId: (
            *(tcInternal.tv_except, each, each._NP_RepositoryId, each.__name__),
            *("description", _STRING),
        )
        for each in classes
    }


_COMMON = _exceptions(NotAvailable, InternalError)
_PARAMETER = _exceptions(InvalidParameter, NotAvailable, InternalError)
_OPTIONAL = _exceptions(InterfaceNotImplemented, NotAvailable, InternalError)


class Interface(msgspec.Struct, frozen=True, eq=False):
    """An interface: its operations as `(arguments, results, exceptions)`, and its bases."""

    repository_id: str
    own: Mapping[str, Any] = msgspec.field(default_factory=dict)
    bases: tuple[Interface, ...] = ()

    @property
    def operations(self) -> dict[str, Any]:
        """All operations, including inherited ones."""
        found: dict[str, Any] = {}
        for base in self.bases:
            found |= base.operations
        return found | dict(self.own)


def _codes(names: str, *arguments: Any) -> dict[str, Any]:
    return dict.fromkeys(names.split(), (arguments, (_CODE,), None))


def _sdo(result: Any, *arguments: Any, raises: Mapping[str, Any] = _PARAMETER) -> Any:
    return arguments, (result,), raises


_SDO_SERVICE = Interface(f"{_SDO}SDOService:1.0")
_SYSTEM_ELEMENT = Interface(
    f"{_SDO}SDOSystemElement:1.0",
    {"get_owned_organizations": _sdo(_OBJECTS, raises=_COMMON)},
)
_SDO_ITSELF = Interface(
    f"{_SDO}SDO:1.0",
    {
        "get_sdo_id": _sdo(_STRING, raises=_COMMON),
        "get_sdo_type": _sdo(_STRING, raises=_COMMON),
        "get_device_profile": _sdo(_DEVICE, raises=_COMMON),
        "get_service_profiles": _sdo(_sequence(_SERVICE), raises=_COMMON),
        "get_service_profile": _sdo(_SERVICE, _STRING),
        "get_sdo_service": _sdo(_OBJECT, _STRING),
        "get_configuration": _sdo(_OBJECT, raises=_OPTIONAL),
        "get_monitoring": _sdo(_OBJECT, raises=_OPTIONAL),
        "get_organizations": _sdo(_OBJECTS, raises=_COMMON),
        "get_status_list": _sdo(_NV_LIST, raises=_COMMON),
        "get_status": _sdo(_ANY, _STRING),
    },
    (_SYSTEM_ELEMENT,),
)
CONFIGURATION = Interface(
    f"{_SDO}Configuration:1.0",
    {
        "set_device_profile": _sdo(_BOOLEAN, _DEVICE),
        "add_service_profile": _sdo(_BOOLEAN, _SERVICE),
        "add_organization": _sdo(_BOOLEAN, _OBJECT),
        "remove_service_profile": _sdo(_BOOLEAN, _STRING),
        "remove_organization": _sdo(_BOOLEAN, _STRING),
        "get_configuration_parameter_values": _sdo(_NV_LIST, raises=_COMMON),
        "get_configuration_parameter_value": _sdo(_ANY, _STRING),
        "set_configuration_parameter": _sdo(_BOOLEAN, _STRING, _ANY),
        "get_configuration_sets": _sdo(_sequence(_SET), raises=_COMMON),
        "get_configuration_set": _sdo(_SET, _STRING, raises=_COMMON),
        "set_configuration_set_values": _sdo(_BOOLEAN, _SET),
        "get_active_configuration_set": _sdo(_SET, raises=_COMMON),
        "add_configuration_set": _sdo(_BOOLEAN, _SET),
        "remove_configuration_set": _sdo(_BOOLEAN, _STRING),
        "activate_configuration_set": _sdo(_BOOLEAN, _STRING),
    },
)
_EXECUTION_CONTEXT = Interface(
    f"{_RTC}ExecutionContext:1.0",
    {
        "is_running": ((), (_BOOLEAN,), None),
        **_codes("start stop"),
        "get_rate": ((), (_DOUBLE,), None),
        **_codes("set_rate", _DOUBLE),
        **_codes(
            "add_component remove_component activate_component deactivate_component "
            "reset_component",
            _OBJECT,
        ),
        "get_component_state": ((_OBJECT,), (_STATE,), None),
        "get_kind": ((), (_KIND,), None),
    },
)
EXECUTION_CONTEXT = Interface(
    f"{_RTC}ExecutionContextService:1.0",
    {"get_profile": ((), (_CONTEXT,), None)},
    (_EXECUTION_CONTEXT, _SDO_SERVICE),
)
_ACTION = Interface(
    f"{_RTC}ComponentAction:1.0",
    {
        **_codes("on_initialize on_finalize"),
        **_codes(
            "on_startup on_shutdown on_activated on_deactivated on_aborting on_error on_reset",
            _LONG,
        ),
    },
)
_LIGHTWEIGHT = Interface(
    f"{_RTC}LightweightRTObject:1.0",
    {
        **_codes("initialize finalize exit"),
        "is_alive": ((_OBJECT,), (_BOOLEAN,), None),
        "attach_context": ((_OBJECT,), (_LONG,), None),
        **_codes("detach_context", _LONG),
        "get_context": ((_LONG,), (_OBJECT,), None),
        "get_owned_contexts": ((), (_OBJECTS,), None),
        "get_participating_contexts": ((), (_OBJECTS,), None),
        "get_context_handle": ((_OBJECT,), (_LONG,), None),
    },
    (_ACTION,),
)
RT_OBJECT = Interface(
    f"{_RTC}RTObject:1.0",
    {
        "get_component_profile": ((), (_COMPONENT,), None),
        "get_ports": ((), (_OBJECTS,), None),
    },
    (_LIGHTWEIGHT, _SDO_ITSELF),
)
_DATA_FLOW_ACTION = Interface(
    f"{_RTC}DataFlowComponentAction:1.0",
    _codes("on_execute on_state_update on_rate_changed", _LONG),
)
_DATA_FLOW = Interface(
    f"{_RTC}DataFlowComponent:1.0", {}, (_LIGHTWEIGHT, _DATA_FLOW_ACTION)
)
DATA_FLOW_COMPONENT = Interface(
    "IDL:openrtm.aist.go.jp/OpenRTM/DataFlowComponent:1.0", {}, (RT_OBJECT, _DATA_FLOW)
)
PORT_SERVICE = Interface(
    f"{_RTC}PortService:1.0",
    {
        "get_port_profile": ((), (_PORT,), None),
        "get_connector_profiles": ((), (_sequence(_CONNECTOR),), None),
        "get_connector_profile": ((_STRING,), (_CONNECTOR,), None),
        "connect": ((_CONNECTOR,), (_CODE, _CONNECTOR), None),
        "notify_connect": ((_CONNECTOR,), (_CODE, _CONNECTOR), None),
        **_codes("disconnect notify_disconnect", _STRING),
        **_codes("disconnect_all"),
    },
    (_SDO_SERVICE,),
)
IN_PORT_CDR = Interface(
    f"{_OPENRTM}InPortCdr:1.0", {"put": ((_OCTETS,), (_STATUS,), None)}
)
OUT_PORT_CDR = Interface(
    f"{_OPENRTM}OutPortCdr:1.0", {"get": ((), (_STATUS, _OCTETS), None)}
)


def values(properties: Mapping[str, str]) -> list[NameValue]:
    """Return properties with texts as values."""
    return [NameValue(name, anys.to_any(text)) for name, text in properties.items()]


def texts(properties: Iterable[NameValue]) -> dict[str, str]:
    """Return the properties whose values are texts, numbers or booleans, as texts."""
    found: dict[str, str] = {}
    for each in properties:
        text = text_of(each.value)
        if text is not None:
            found[each.name] = text
    return found


def text_of(value: Any) -> str | None:
    """Return the text of an `any`; None for a value of another kind."""
    # `from_any` of omniORBpy calls itself for each `any` within another one.
    type_, plain = value.typecode(), value.value()
    while type_.kind() in (CORBA.tk_any, CORBA.tk_alias):
        if type_.kind() == CORBA.tk_any:
            type_, plain = plain.typecode(), plain.value()
        else:
            type_ = type_.content_type()
    if type_.kind() == CORBA.tk_boolean:
        return "true" if plain else "false"
    return str(plain) if isinstance(plain, str | int | float) else None
