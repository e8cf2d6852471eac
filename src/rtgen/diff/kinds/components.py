"""Kinds of changes of components, their ports, parameters and profiles (DIF03..)."""

from __future__ import annotations

from rtgen.diff.changes import Break, Kind, Wire

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

COMPONENT_ADDED = Kind(
    "DIF0301",
    "component added",
    _NONE,
    "no system had the component before",
)
COMPONENT_REMOVED = Kind(
    "DIF0302",
    "component removed",
    _BOTH,
    "behaviours have no base class, and systems no definition",
)
COMPONENT_RENAMED = Kind(
    "DIF0303",
    "component renamed",
    _BOTH,
    "behaviours, profiles and systems name the component",
)
COMPONENT_PROFILE = Kind(
    "DIF0304",
    "vendor, category or version changed",
    _STORED,
    "the id of the component in profiles and systems consists of them",
)
COMPONENT_RATE = Kind(
    "DIF0305",
    "rate of a component changed",
    _SOURCE,
    "on_execute is called at another period",
)
COMPONENT_KIND = Kind(
    "DIF0306",
    "kind or execution of a component changed",
    _SOURCE,
    "other callbacks run, or at other times",
)
COMPONENT_INSTANCES = Kind(
    "DIF0307",
    "number of instances lowered",
    _STORED,
    "systems with more instances cannot be created",
)
COMPONENT_INSTANCES_MORE = Kind(
    "DIF0308",
    "number of instances raised",
    _NONE,
    "former numbers of instances are still possible",
)
COMPONENT_TEXTS = Kind(
    "DIF0309",
    "description of a component changed",
    _NONE,
    "only people read the text",
)
COMPONENT_BASE = Kind(
    "DIF0310",
    "base or supported interfaces of a component changed",
    _SOURCE,
    "behaviours inherit from other classes",
)
PORT_ADDED = Kind(
    "DIF0320",
    "port added",
    _NONE,
    "nothing was connected to the port",
)
PORT_REMOVED = Kind(
    "DIF0321",
    "port removed",
    _BOTH,
    "behaviours use the port, and systems connect it",
)
PORT_RENAMED = Kind(
    "DIF0322",
    "port renamed",
    _BOTH,
    "behaviours and systems name the port",
)
PORT_KIND = Kind(
    "DIF0323",
    "port of another kind",
    _BOTH,
    "data flows in the other direction, or the port provides the interface that it called",
)
PORT_TYPE = Kind(
    "DIF0324",
    "port of another type",
    _BOTH,
    "ports of two types are not connected",
    (
        Wire.CDR,
        Wire.XCDR1,
        Wire.XCDR2,
    ),
)
PORT_INTERFACE = Kind(
    "DIF0325",
    "service port with another interface",
    _BOTH,
    "a consumer needs the interface that the provider has",
    (Wire.GIOP,),
)
PORT_UNIT = Kind(
    "DIF0326",
    "unit of a port changed",
    _BOTH,
    "the same number means another quantity",
)
PORT_SERVICE = Kind(
    "DIF0327",
    "interface moved to another service port or instance",
    _STORED,
    "connectors of systems name service port, type and instance",
)
PORT_TYPE_NAME = Kind(
    "DIF0328",
    "type name of a service port changed",
    _STORED,
    "OpenRTM pairs interfaces by type name",
    (Wire.GIOP,),
)
PORTS_REORDERED = Kind(
    "DIF0329",
    "ports in another order",
    _NONE,
    "ports are found by name",
)
PARAMETER_ADDED = Kind(
    "DIF0340",
    "configuration parameter added",
    _NONE,
    "sets that leave the parameter out get its default",
)
PARAMETER_REMOVED = Kind(
    "DIF0341",
    "configuration parameter removed",
    _BOTH,
    "behaviours read the parameter, and stored sets contain it",
)
PARAMETER_RENAMED = Kind(
    "DIF0342",
    "configuration parameter renamed",
    _BOTH,
    "behaviours and stored sets name the parameter",
)
PARAMETER_TYPE = Kind(
    "DIF0343",
    "configuration parameter of another type",
    _BOTH,
    "stored texts may not be values of the type",
)
PARAMETER_DEFAULT = Kind(
    "DIF0344",
    "default of a configuration parameter changed",
    _STORED,
    "sets that leave the parameter out get another value",
)
PARAMETER_NARROWED = Kind(
    "DIF0345",
    "range of a configuration parameter narrowed",
    _STORED,
    "stored values can lie outside of it",
)
PARAMETER_WIDENED = Kind(
    "DIF0346",
    "range of a configuration parameter widened",
    _SOURCE,
    "behaviours meet values that were not possible before",
)
PARAMETER_CONSTRAINT = Kind(
    "DIF0347",
    "constraint of a configuration parameter changed",
    _STORED,
    "stored values may violate the constraint",
)
PARAMETER_UNIT = Kind(
    "DIF0348",
    "unit of a configuration parameter changed",
    _BOTH,
    "stored numbers mean another quantity",
)
PARAMETER_WIDGET = Kind(
    "DIF0349",
    "widget of a configuration parameter changed",
    _NONE,
    "only tools show the widget",
)
ADAPTER_ADDED = Kind(
    "DIF0360",
    "adapter added",
    _NONE,
    "no connection used the adapter",
)
ADAPTER_REMOVED = Kind(
    "DIF0361",
    "adapter removed",
    _STORED,
    "systems connect through the adapter",
)
ADAPTER_TYPES = Kind(
    "DIF0362",
    "adapter between other types",
    _STORED,
    "the ports of the adapter have other types",
    (
        Wire.CDR,
        Wire.XCDR1,
        Wire.XCDR2,
    ),
)
ADAPTER_COPIES = Kind(
    "DIF0363",
    "adapter copies other members",
    _SOURCE,
    "receivers get other values",
)

KINDS = (
    COMPONENT_ADDED,
    COMPONENT_REMOVED,
    COMPONENT_RENAMED,
    COMPONENT_PROFILE,
    COMPONENT_RATE,
    COMPONENT_KIND,
    COMPONENT_INSTANCES,
    COMPONENT_INSTANCES_MORE,
    COMPONENT_TEXTS,
    COMPONENT_BASE,
    PORT_ADDED,
    PORT_REMOVED,
    PORT_RENAMED,
    PORT_KIND,
    PORT_TYPE,
    PORT_INTERFACE,
    PORT_UNIT,
    PORT_SERVICE,
    PORT_TYPE_NAME,
    PORTS_REORDERED,
    PARAMETER_ADDED,
    PARAMETER_REMOVED,
    PARAMETER_RENAMED,
    PARAMETER_TYPE,
    PARAMETER_DEFAULT,
    PARAMETER_NARROWED,
    PARAMETER_WIDENED,
    PARAMETER_CONSTRAINT,
    PARAMETER_UNIT,
    PARAMETER_WIDGET,
    ADAPTER_ADDED,
    ADAPTER_REMOVED,
    ADAPTER_TYPES,
    ADAPTER_COPIES,
)
