"""Kinds of changes of systems and of the project file (DIF06.., DIF07..)."""

from __future__ import annotations

from rtgen.diff.changes import Break, Kind, Wire

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

SYSTEM_ADDED = Kind(
    "DIF0601",
    "system added",
    _NONE,
    "nothing ran the system",
)
SYSTEM_REMOVED = Kind(
    "DIF0602",
    "system removed",
    _BOTH,
    "scripts and experiments name the system",
)
SYSTEM_ID = Kind(
    "DIF0603",
    "id of a system changed",
    _STORED,
    "tools know systems by their id",
)
INSTANCE_ADDED = Kind(
    "DIF0610",
    "instance added to a system",
    _NONE,
    "no connection led to the instance",
)
INSTANCE_REMOVED = Kind(
    "DIF0611",
    "instance removed from a system",
    _BOTH,
    "connections, scripts and logs name the instance",
)
INSTANCE_RENAMED = Kind(
    "DIF0612",
    "instance renamed",
    _BOTH,
    "scripts, logs and the naming service name the instance",
)
INSTANCE_TYPE = Kind(
    "DIF0613",
    "instance of another component",
    _BOTH,
    "the instance has other ports and parameters",
)
INSTANCE_ID = Kind(
    "DIF0614",
    "profile id of an instance changed",
    _STORED,
    "tools find the definition by its id",
)
INSTANCE_RATE = Kind(
    "DIF0615",
    "rate of an instance changed",
    _SOURCE,
    "its callbacks run at another period",
)
INSTANCE_REQUIRED = Kind(
    "DIF0616",
    "instance made required or optional",
    _STORED,
    "the system runs, or does not run, without the instance",
)
INSTANCE_SET = Kind(
    "DIF0617",
    "active configuration set changed",
    _STORED,
    "the instance starts with other values",
)
VALUE_ADDED = Kind(
    "DIF0618",
    "configuration value added",
    _STORED,
    "the value replaces the default",
)
VALUE_REMOVED = Kind(
    "DIF0619",
    "configuration value removed",
    _STORED,
    "the default replaces the value",
)
VALUE_CHANGED = Kind(
    "DIF0620",
    "configuration value changed",
    _STORED,
    "the instance starts with another value",
)
SET_ADDED = Kind(
    "DIF0621",
    "configuration set added",
    _NONE,
    "nothing activated the set",
)
SET_REMOVED = Kind(
    "DIF0622",
    "configuration set removed",
    _STORED,
    "scripts activate sets by id",
)
INSTANCE_PLACE = Kind(
    "DIF0623",
    "place or path of an instance changed",
    _NONE,
    "only tools use it",
)
CONNECTION_ADDED = Kind(
    "DIF0630",
    "connection added",
    _NONE,
    "the ports were not connected",
)
CONNECTION_REMOVED = Kind(
    "DIF0631",
    "connection removed",
    _SOURCE,
    "data or calls no longer arrive",
)
CONNECTION_SUBSCRIPTION = Kind(
    "DIF0632",
    "subscription of a connection changed",
    _SOURCE,
    "samples are sent at other times, or queue otherwise",
)
CONNECTION_INTERFACE = Kind(
    "DIF0633",
    "transport of a connection changed",
    _SOURCE,
    "both ends need the transport",
    (Wire.GIOP,),
)
CONNECTION_DATA_TYPE = Kind(
    "DIF0634",
    "data type of a connection changed",
    _STORED,
    "both ends need the data type",
    (Wire.CDR,),
)
CONNECTION_PROPERTY = Kind(
    "DIF0635",
    "property of a connection changed",
    _STORED,
    "the connector behaves otherwise",
)
CONNECTION_NAME = Kind(
    "DIF0636",
    "connection renamed",
    _NONE,
    "connectors are found by their ports",
)
ACTIVATION = Kind(
    "DIF0640",
    "start order changed",
    _SOURCE,
    "components start before those they need",
)
SYSTEM_PROPERTY = Kind(
    "DIF0641",
    "property of a system changed",
    _STORED,
    "runs of the system behave otherwise",
)
PACKAGE = Kind(
    "DIF0701",
    "package of generated code renamed",
    _SOURCE,
    "code imports the package by name",
)
SKELETONS = Kind(
    "DIF0702",
    "folder of skeletons changed",
    _SOURCE,
    "behaviours are imported from the folder",
)
OUTPUT = Kind(
    "DIF0703",
    "output folder changed",
    _SOURCE,
    "the generated package is found elsewhere",
)
TARGET = Kind(
    "DIF0704",
    "target changed",
    _SOURCE,
    "components run on another platform",
)
REPRESENTATION = Kind(
    "DIF0705",
    "representation of the project changed",
    _STORED,
    "to_cdr of each type without an annotation writes another representation",
    (Wire.CDR,),
)
EXTENSIBILITY = Kind(
    "DIF0706",
    "default extensibility changed",
    _NONE,
    "each type without an annotation has other headers, which is a separate change",
)
SMALL_ROOM = Kind(
    "DIF0707",
    "room on small targets lowered",
    _SOURCE,
    "longer sequences, texts or queues no longer fit",
)
SMALL_ROOM_MORE = Kind(
    "DIF0708",
    "room on small targets raised",
    _NONE,
    "values that fitted still fit",
)
TECS_CORBA = Kind(
    "DIF0709",
    "CORBA for TECS boards switched",
    _SOURCE,
    "services of boards can, or cannot, be called over CORBA",
    (Wire.GIOP,),
)
FACTORY = Kind(
    "DIF0710",
    "factory of a component changed",
    _SOURCE,
    "instances are made by other code",
)
READING = Kind(
    "DIF0711",
    "macros, include folders or encodings of sources changed",
    _NONE,
    "other effects on definitions are separate changes",
)
SOURCES = Kind(
    "DIF0712",
    "paths of the sources changed",
    _NONE,
    "each addition or removal is a separate change",
)
TOOLS = Kind(
    "DIF0713",
    "settings of lint, diff or plug-ins changed",
    _NONE,
    "definitions stay the same",
)
NUMERIC = Kind(
    "DIF0714",
    "form of numbers in Python changed",
    _SOURCE,
    "sequences and arrays of numbers are decoded as objects of another type",
)

KINDS = (
    SYSTEM_ADDED,
    SYSTEM_REMOVED,
    SYSTEM_ID,
    INSTANCE_ADDED,
    INSTANCE_REMOVED,
    INSTANCE_RENAMED,
    INSTANCE_TYPE,
    INSTANCE_ID,
    INSTANCE_RATE,
    INSTANCE_REQUIRED,
    INSTANCE_SET,
    VALUE_ADDED,
    VALUE_REMOVED,
    VALUE_CHANGED,
    SET_ADDED,
    SET_REMOVED,
    INSTANCE_PLACE,
    CONNECTION_ADDED,
    CONNECTION_REMOVED,
    CONNECTION_SUBSCRIPTION,
    CONNECTION_INTERFACE,
    CONNECTION_DATA_TYPE,
    CONNECTION_PROPERTY,
    CONNECTION_NAME,
    ACTIVATION,
    SYSTEM_PROPERTY,
    PACKAGE,
    SKELETONS,
    OUTPUT,
    TARGET,
    REPRESENTATION,
    EXTENSIBILITY,
    SMALL_ROOM,
    SMALL_ROOM_MORE,
    TECS_CORBA,
    FACTORY,
    READING,
    SOURCES,
    TOOLS,
    NUMERIC,
)
