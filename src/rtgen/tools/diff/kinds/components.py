"""Kinds of changes of components, their ports, parameters and profiles (DIF03..)."""

from __future__ import annotations

from rtgen.tools.diff.changes import Break, Kind, Wire, kinds_of

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

COMPONENT_ADDED = Kind("DIF0301", "component added", _NONE)
COMPONENT_REMOVED = Kind("DIF0302", "component removed", _BOTH)
COMPONENT_RENAMED = Kind("DIF0303", "component renamed", _BOTH)
COMPONENT_PROFILE = Kind("DIF0304", "vendor, category or version changed", _STORED)
COMPONENT_RATE = Kind("DIF0305", "rate of a component changed", _SOURCE)
COMPONENT_KIND = Kind("DIF0306", "kind or execution of a component changed", _SOURCE)
COMPONENT_INSTANCES = Kind("DIF0307", "number of instances lowered", _STORED)
COMPONENT_INSTANCES_MORE = Kind("DIF0308", "number of instances raised", _NONE)
COMPONENT_TEXTS = Kind("DIF0309", "description of a component changed", _NONE)
COMPONENT_BASE = Kind(
    "DIF0310", "base or supported interfaces of a component changed", _SOURCE
)
PORT_ADDED = Kind("DIF0320", "port added", _NONE)
PORT_REMOVED = Kind("DIF0321", "port removed", _BOTH)
PORT_RENAMED = Kind("DIF0322", "port renamed", _BOTH)
PORT_KIND = Kind("DIF0323", "port of another kind", _BOTH)
PORT_TYPE = Kind(
    "DIF0324",
    "port of another type",
    _BOTH,
    (
        Wire.CDR,
        Wire.XCDR1,
        Wire.XCDR2,
    ),
)
PORT_INTERFACE = Kind(
    "DIF0325", "service port with another interface", _BOTH, (Wire.GIOP,)
)
PORT_UNIT = Kind("DIF0326", "unit of a port changed", _BOTH)
PORT_SERVICE = Kind(
    "DIF0327", "interface moved to another service port or instance", _STORED
)
PORT_TYPE_NAME = Kind(
    "DIF0328", "type name of a service port changed", _STORED, (Wire.GIOP,)
)
PORTS_REORDERED = Kind("DIF0329", "ports in another order", _NONE)
PARAMETER_ADDED = Kind("DIF0340", "configuration parameter added", _NONE)
PARAMETER_REMOVED = Kind("DIF0341", "configuration parameter removed", _BOTH)
PARAMETER_RENAMED = Kind("DIF0342", "configuration parameter renamed", _BOTH)
PARAMETER_TYPE = Kind("DIF0343", "configuration parameter of another type", _BOTH)
PARAMETER_DEFAULT = Kind(
    "DIF0344", "default of a configuration parameter changed", _STORED
)
PARAMETER_NARROWED = Kind(
    "DIF0345", "range of a configuration parameter narrowed", _STORED
)
PARAMETER_WIDENED = Kind(
    "DIF0346", "range of a configuration parameter widened", _SOURCE
)
PARAMETER_CONSTRAINT = Kind(
    "DIF0347", "constraint of a configuration parameter changed", _STORED
)
PARAMETER_UNIT = Kind("DIF0348", "unit of a configuration parameter changed", _BOTH)
PARAMETER_WIDGET = Kind("DIF0349", "widget of a configuration parameter changed", _NONE)
ADAPTER_ADDED = Kind("DIF0360", "adapter added", _NONE)
ADAPTER_REMOVED = Kind("DIF0361", "adapter removed", _STORED)
ADAPTER_TYPES = Kind(
    "DIF0362",
    "adapter between other types",
    _STORED,
    (
        Wire.CDR,
        Wire.XCDR1,
        Wire.XCDR2,
    ),
)
ADAPTER_COPIES = Kind("DIF0363", "adapter copies other members", _SOURCE)

KINDS = kinds_of(globals())
