"""Kinds of changes of systems and of the project file (DIF06.., DIF07..)."""

from __future__ import annotations

from rtgen.tools.diff.changes import Break, Kind, Wire, kinds_of

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

SYSTEM_ADDED = Kind("DIF0601", "system added", _NONE)
SYSTEM_REMOVED = Kind("DIF0602", "system removed", _BOTH)
SYSTEM_ID = Kind("DIF0603", "id of a system changed", _STORED)
INSTANCE_ADDED = Kind("DIF0610", "instance added to a system", _NONE)
INSTANCE_REMOVED = Kind("DIF0611", "instance removed from a system", _BOTH)
INSTANCE_RENAMED = Kind("DIF0612", "instance renamed", _BOTH)
INSTANCE_TYPE = Kind("DIF0613", "instance of another component", _BOTH)
INSTANCE_ID = Kind("DIF0614", "profile id of an instance changed", _STORED)
INSTANCE_RATE = Kind("DIF0615", "rate of an instance changed", _SOURCE)
INSTANCE_REQUIRED = Kind("DIF0616", "instance made required or optional", _STORED)
INSTANCE_SET = Kind("DIF0617", "active configuration set changed", _STORED)
VALUE_ADDED = Kind("DIF0618", "configuration value added", _STORED)
VALUE_REMOVED = Kind("DIF0619", "configuration value removed", _STORED)
VALUE_CHANGED = Kind("DIF0620", "configuration value changed", _STORED)
SET_ADDED = Kind("DIF0621", "configuration set added", _NONE)
SET_REMOVED = Kind("DIF0622", "configuration set removed", _STORED)
INSTANCE_PLACE = Kind("DIF0623", "place or path of an instance changed", _NONE)
CONNECTION_ADDED = Kind("DIF0630", "connection added", _NONE)
CONNECTION_REMOVED = Kind("DIF0631", "connection removed", _SOURCE)
CONNECTION_SUBSCRIPTION = Kind(
    "DIF0632", "subscription of a connection changed", _SOURCE
)
CONNECTION_INTERFACE = Kind(
    "DIF0633", "transport of a connection changed", _SOURCE, (Wire.GIOP,)
)
CONNECTION_DATA_TYPE = Kind(
    "DIF0634", "data type of a connection changed", _STORED, (Wire.CDR,)
)
CONNECTION_PROPERTY = Kind("DIF0635", "property of a connection changed", _STORED)
CONNECTION_NAME = Kind("DIF0636", "connection renamed", _NONE)
ACTIVATION = Kind("DIF0640", "start order changed", _SOURCE)
SYSTEM_PROPERTY = Kind("DIF0641", "property of a system changed", _STORED)
PACKAGE = Kind("DIF0701", "package of generated code renamed", _SOURCE)
SKELETONS = Kind("DIF0702", "folder of skeletons changed", _SOURCE)
OUTPUT = Kind("DIF0703", "output folder changed", _SOURCE)
TARGET = Kind("DIF0704", "target changed", _SOURCE)
REPRESENTATION = Kind(
    "DIF0705", "representation of the project changed", _STORED, (Wire.CDR,)
)
EXTENSIBILITY = Kind("DIF0706", "default extensibility changed", _NONE)
SMALL_ROOM = Kind("DIF0707", "room on small targets lowered", _SOURCE)
SMALL_ROOM_MORE = Kind("DIF0708", "room on small targets raised", _NONE)
TECS_CORBA = Kind("DIF0709", "CORBA for TECS boards switched", _SOURCE, (Wire.GIOP,))
FACTORY = Kind("DIF0710", "factory of a component changed", _SOURCE)
READING = Kind(
    "DIF0711", "macros, include folders or encodings of sources changed", _NONE
)
SOURCES = Kind("DIF0712", "paths of the sources changed", _NONE)
TOOLS = Kind("DIF0713", "settings of lint, diff or plug-ins changed", _NONE)
NUMERIC = Kind("DIF0714", "form of numbers in Python changed", _SOURCE)

KINDS = kinds_of(globals())
