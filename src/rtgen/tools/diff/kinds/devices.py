"""Kinds of changes of CANopen devices and buses (DIF05..)."""

from __future__ import annotations

from rtgen.tools.diff.changes import Break, Kind, Wire, kinds_of

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

DEVICE_ADDED = Kind("DIF0501", "device added", _NONE)
DEVICE_REMOVED = Kind("DIF0502", "device removed", _BOTH)
DEVICE_IDENTITY = Kind(
    "DIF0503", "vendor, product or revision number changed", _STORED, (Wire.NODE,)
)
DEVICE_BIT_RATE_REMOVED = Kind(
    "DIF0504", "bit rate no longer supported", _STORED, (Wire.NODE,)
)
DEVICE_BIT_RATE_ADDED = Kind("DIF0505", "bit rate added", _NONE)
DEVICE_INFO = Kind("DIF0506", "information of a device changed", _NONE)
DEVICE_CAPABILITY = Kind(
    "DIF0507", "LSS, boot-up or granularity of a device changed", _STORED, (Wire.NODE,)
)
DEVICE_NODE_ID = Kind("DIF0508", "node-id of a DCF changed", _STORED, (Wire.COB_ID,))
OBJECT_ADDED = Kind("DIF0510", "object added", _NONE)
OBJECT_REMOVED = Kind("DIF0511", "object removed", _BOTH, (Wire.SDO,))
OBJECT_RENAMED = Kind("DIF0512", "object renamed", _SOURCE)
OBJECT_TYPE = Kind("DIF0513", "object of another data type", _BOTH, (Wire.SDO,))
OBJECT_ACCESS_NARROWED = Kind("DIF0514", "access right taken away", _BOTH, (Wire.SDO,))
OBJECT_ACCESS_WIDENED = Kind("DIF0515", "access right added", _NONE)
OBJECT_DEFAULT = Kind("DIF0516", "default value of an object changed", _STORED)
OBJECT_VALUE = Kind("DIF0517", "configured value of an object changed", _STORED)
OBJECT_NARROWED = Kind("DIF0518", "limits of an object narrowed", _STORED, (Wire.SDO,))
OBJECT_WIDENED = Kind("DIF0519", "limits of an object widened", _NONE)
OBJECT_UNIT = Kind("DIF0520", "unit or factor of an object changed", _BOTH)
OBJECT_MAPPABLE = Kind(
    "DIF0521", "object can no longer be mapped", _STORED, (Wire.PDO,)
)
OBJECT_MAPPABLE_NOW = Kind("DIF0522", "object can be mapped now", _NONE)
OBJECT_STRUCTURE = Kind("DIF0523", "object of another kind", _BOTH, (Wire.SDO,))
PDO_ADDED = Kind("DIF0530", "PDO added", _NONE)
PDO_REMOVED = Kind("DIF0531", "PDO removed", _SOURCE, (Wire.PDO,))
PDO_APPENDED = Kind(
    "DIF0532", "object mapped at the end of a PDO", _SOURCE, (Wire.PDO,)
)
PDO_MAPPING = Kind("DIF0533", "mapping of a PDO changed", _SOURCE, (Wire.PDO,))
PDO_ENTRY_TYPE = Kind(
    "DIF0534", "mapped object of another data type", _SOURCE, (Wire.PDO,)
)
PDO_COB_ID = Kind("DIF0535", "COB-ID of a PDO changed", _STORED, (Wire.COB_ID,))
PDO_VALIDITY = Kind("DIF0536", "PDO enabled or disabled", _STORED, (Wire.COB_ID,))
PDO_TRANSMISSION = Kind(
    "DIF0537", "transmission type of a PDO changed", _STORED, (Wire.TRANSMISSION,)
)
PDO_INHIBIT = Kind(
    "DIF0538", "inhibit time of a PDO changed", _STORED, (Wire.TRANSMISSION,)
)
PDO_EVENT_TIMER = Kind(
    "DIF0539", "event timer of a PDO changed", _STORED, (Wire.TRANSMISSION,)
)
PDO_SYNC_START = Kind(
    "DIF0540", "SYNC start value of a PDO changed", _STORED, (Wire.TRANSMISSION,)
)
BUS_ADDED = Kind("DIF0550", "bus added", _NONE)
BUS_REMOVED = Kind("DIF0551", "bus removed", _BOTH)
BUS_BIT_RATE = Kind("DIF0552", "bit rate of a bus changed", _STORED, (Wire.NODE,))
BUS_MANAGER = Kind("DIF0553", "node-id of the manager changed", _STORED, (Wire.COB_ID,))
BUS_SYNC = Kind(
    "DIF0554", "SYNC period or counter of a bus changed", _STORED, (Wire.TRANSMISSION,)
)
BUS_HEARTBEAT = Kind("DIF0555", "heartbeat of a bus changed", _STORED, (Wire.NODE,))
BUS_SETTING = Kind("DIF0556", "other setting of a bus changed", _NONE)
NODE_ADDED = Kind("DIF0560", "node added to a bus", _NONE)
NODE_REMOVED = Kind("DIF0561", "node removed from a bus", _BOTH, (Wire.NODE,))
NODE_RENAMED = Kind("DIF0570", "node renamed", _BOTH)
NODE_ID = Kind("DIF0562", "node-id changed", _STORED, (Wire.COB_ID,))
NODE_DEVICE = Kind("DIF0563", "node of another device", _BOTH, (Wire.SDO,))
NODE_VALUE = Kind("DIF0564", "start-up value of a node changed", _STORED)
NODE_SUPERVISION = Kind(
    "DIF0565", "supervision or start of a node changed", _STORED, (Wire.NODE,)
)
KIND_PORTS = Kind(
    "DIF0566", "ports, parameters or operations of a device kind changed", _BOTH
)
KIND_SCALE = Kind("DIF0567", "scale or unit of a device kind changed", _BOTH)
LINK_ADDED = Kind("DIF0568", "PDO link added", _NONE)
LINK_REMOVED = Kind("DIF0569", "PDO link removed", _SOURCE, (Wire.PDO,))

KINDS = kinds_of(globals())
