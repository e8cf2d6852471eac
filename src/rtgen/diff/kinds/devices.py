"""Kinds of changes of CANopen devices and buses (DIF05..)."""

from __future__ import annotations

from rtgen.diff.changes import Break, Kind, Wire

_SOURCE = (Break.SOURCE,)
_STORED = (Break.STORED,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

DEVICE_ADDED = Kind(
    "DIF0501",
    "device added",
    _NONE,
    "no bus had the device",
)
DEVICE_REMOVED = Kind(
    "DIF0502",
    "device removed",
    _BOTH,
    "proxies and buses have no description any more",
)
DEVICE_IDENTITY = Kind(
    "DIF0503",
    "vendor, product or revision number changed",
    _STORED,
    "managers compare the identity before they start a node",
    (Wire.NODE,),
)
DEVICE_BIT_RATE_REMOVED = Kind(
    "DIF0504",
    "bit rate no longer supported",
    _STORED,
    "buses of that rate lose the device",
    (Wire.NODE,),
)
DEVICE_BIT_RATE_ADDED = Kind(
    "DIF0505",
    "bit rate added",
    _NONE,
    "the supported bit rates are only extended",
)
DEVICE_INFO = Kind(
    "DIF0506",
    "information of a device changed",
    _NONE,
    "only people read the texts",
)
DEVICE_CAPABILITY = Kind(
    "DIF0507",
    "LSS, boot-up or granularity of a device changed",
    _STORED,
    "managers use the service of the device",
    (Wire.NODE,),
)
DEVICE_NODE_ID = Kind(
    "DIF0508",
    "node-id of a DCF changed",
    _STORED,
    "all identifiers of the predefined connection set follow the node-id",
    (Wire.COB_ID,),
)
OBJECT_ADDED = Kind(
    "DIF0510",
    "object added",
    _NONE,
    "no peer accessed the object",
)
OBJECT_REMOVED = Kind(
    "DIF0511",
    "object removed",
    _BOTH,
    "SDO requests for the object are aborted, and stored values have no place",
    (Wire.SDO,),
)
OBJECT_RENAMED = Kind(
    "DIF0512",
    "object renamed",
    _SOURCE,
    "index and sub-index are the same, but ports and constants are named after it",
)
OBJECT_TYPE = Kind(
    "DIF0513",
    "object of another data type",
    _BOTH,
    "peers take the octets for a value of their own type",
    (Wire.SDO,),
)
OBJECT_ACCESS_NARROWED = Kind(
    "DIF0514",
    "access right taken away",
    _BOTH,
    "SDO requests that were answered are aborted",
    (Wire.SDO,),
)
OBJECT_ACCESS_WIDENED = Kind(
    "DIF0515",
    "access right added",
    _NONE,
    "access is only extended",
)
OBJECT_DEFAULT = Kind(
    "DIF0516",
    "default value of an object changed",
    _STORED,
    "the device starts with another value",
)
OBJECT_VALUE = Kind(
    "DIF0517",
    "configured value of an object changed",
    _STORED,
    "the device is configured with another value",
)
OBJECT_NARROWED = Kind(
    "DIF0518",
    "limits of an object narrowed",
    _STORED,
    "values that were valid are refused",
    (Wire.SDO,),
)
OBJECT_WIDENED = Kind(
    "DIF0519",
    "limits of an object widened",
    _NONE,
    "valid values stay valid",
)
OBJECT_UNIT = Kind(
    "DIF0520",
    "unit or factor of an object changed",
    _BOTH,
    "the same number means another quantity",
)
OBJECT_MAPPABLE = Kind(
    "DIF0521",
    "object can no longer be mapped",
    _STORED,
    "configurations that map the object are refused",
    (Wire.PDO,),
)
OBJECT_MAPPABLE_NOW = Kind(
    "DIF0522",
    "object can be mapped now",
    _NONE,
    "no configuration mapped the object",
)
OBJECT_STRUCTURE = Kind(
    "DIF0523",
    "object of another kind",
    _BOTH,
    "sub-indices mean something else",
    (Wire.SDO,),
)
PDO_ADDED = Kind(
    "DIF0530",
    "PDO added",
    _NONE,
    "no peer listened to the PDO or sent it",
)
PDO_REMOVED = Kind(
    "DIF0531",
    "PDO removed",
    _SOURCE,
    "peers send, or wait for, a PDO that no longer exists",
    (Wire.PDO,),
)
PDO_APPENDED = Kind(
    "DIF0532",
    "object mapped at the end of a PDO",
    _SOURCE,
    "a longer PDO is truncated by old receivers, but a shorter one is dropped by new ones",
    (Wire.PDO,),
)
PDO_MAPPING = Kind(
    "DIF0533",
    "mapping of a PDO changed",
    _SOURCE,
    "receivers take the bits for other objects",
    (Wire.PDO,),
)
PDO_ENTRY_TYPE = Kind(
    "DIF0534",
    "mapped object of another data type",
    _SOURCE,
    "receivers take the bits for a value of another type",
    (Wire.PDO,),
)
PDO_COB_ID = Kind(
    "DIF0535",
    "COB-ID of a PDO changed",
    _STORED,
    "peers wait for another identifier",
    (Wire.COB_ID,),
)
PDO_VALIDITY = Kind(
    "DIF0536",
    "PDO enabled or disabled",
    _STORED,
    "the PDO is sent no longer, or now",
    (Wire.COB_ID,),
)
PDO_TRANSMISSION = Kind(
    "DIF0537",
    "transmission type of a PDO changed",
    _STORED,
    "the PDO is sent, or takes effect, at other times",
    (Wire.TRANSMISSION,),
)
PDO_INHIBIT = Kind(
    "DIF0538",
    "inhibit time of a PDO changed",
    _STORED,
    "the PDO may be sent more or less often",
    (Wire.TRANSMISSION,),
)
PDO_EVENT_TIMER = Kind(
    "DIF0539",
    "event timer of a PDO changed",
    _STORED,
    "the PDO is sent more or less often, and receivers time out",
    (Wire.TRANSMISSION,),
)
PDO_SYNC_START = Kind(
    "DIF0540",
    "SYNC start value of a PDO changed",
    _STORED,
    "the PDO begins with another SYNC",
    (Wire.TRANSMISSION,),
)
BUS_ADDED = Kind(
    "DIF0550",
    "bus added",
    _NONE,
    "nothing ran on the bus",
)
BUS_REMOVED = Kind(
    "DIF0551",
    "bus removed",
    _BOTH,
    "networks, proxies and systems of the bus are gone",
)
BUS_BIT_RATE = Kind(
    "DIF0552",
    "bit rate of a bus changed",
    _STORED,
    "nodes of two bit rates cannot share a bus",
    (Wire.NODE,),
)
BUS_MANAGER = Kind(
    "DIF0553",
    "node-id of the manager changed",
    _STORED,
    "nodes supervise the heartbeat of the manager",
    (Wire.COB_ID,),
)
BUS_SYNC = Kind(
    "DIF0554",
    "SYNC period or counter of a bus changed",
    _STORED,
    "synchronous PDOs come at other times",
    (Wire.TRANSMISSION,),
)
BUS_HEARTBEAT = Kind(
    "DIF0555",
    "heartbeat of a bus changed",
    _STORED,
    "nodes and manager supervise each other with other times",
    (Wire.NODE,),
)
BUS_SETTING = Kind(
    "DIF0556",
    "other setting of a bus changed",
    _NONE,
    "nothing on the bus depends on it",
)
NODE_ADDED = Kind(
    "DIF0560",
    "node added to a bus",
    _NONE,
    "no peer knew the node",
)
NODE_REMOVED = Kind(
    "DIF0561",
    "node removed from a bus",
    _BOTH,
    "proxies and systems of the node are gone",
    (Wire.NODE,),
)
NODE_RENAMED = Kind(
    "DIF0570",
    "node renamed",
    _BOTH,
    "frames hold the node-id, but systems and code name the node",
)
NODE_ID = Kind(
    "DIF0562",
    "node-id changed",
    _STORED,
    "all identifiers of the predefined connection set follow the node-id",
    (Wire.COB_ID,),
)
NODE_DEVICE = Kind(
    "DIF0563",
    "node of another device",
    _BOTH,
    "the node has other objects",
    (Wire.SDO,),
)
NODE_VALUE = Kind(
    "DIF0564",
    "start-up value of a node changed",
    _STORED,
    "the node is configured with another value",
)
NODE_SUPERVISION = Kind(
    "DIF0565",
    "supervision or start of a node changed",
    _STORED,
    "the manager reacts to failures in another way",
    (Wire.NODE,),
)
KIND_PORTS = Kind(
    "DIF0566",
    "ports, parameters or operations of a device kind changed",
    _BOTH,
    "the component of the node has other ports, parameters or operations",
)
KIND_SCALE = Kind(
    "DIF0567",
    "scale or unit of a device kind changed",
    _BOTH,
    "the same number at a port means another quantity",
)
LINK_ADDED = Kind(
    "DIF0568",
    "PDO link added",
    _NONE,
    "the RPDO was fed by its proxy before",
)
LINK_REMOVED = Kind(
    "DIF0569",
    "PDO link removed",
    _SOURCE,
    "the RPDO gets no PDOs from the other node",
    (Wire.PDO,),
)

KINDS = (
    DEVICE_ADDED,
    DEVICE_REMOVED,
    DEVICE_IDENTITY,
    DEVICE_BIT_RATE_REMOVED,
    DEVICE_BIT_RATE_ADDED,
    DEVICE_INFO,
    DEVICE_CAPABILITY,
    DEVICE_NODE_ID,
    OBJECT_ADDED,
    OBJECT_REMOVED,
    OBJECT_RENAMED,
    OBJECT_TYPE,
    OBJECT_ACCESS_NARROWED,
    OBJECT_ACCESS_WIDENED,
    OBJECT_DEFAULT,
    OBJECT_VALUE,
    OBJECT_NARROWED,
    OBJECT_WIDENED,
    OBJECT_UNIT,
    OBJECT_MAPPABLE,
    OBJECT_MAPPABLE_NOW,
    OBJECT_STRUCTURE,
    PDO_ADDED,
    PDO_REMOVED,
    PDO_APPENDED,
    PDO_MAPPING,
    PDO_ENTRY_TYPE,
    PDO_COB_ID,
    PDO_VALIDITY,
    PDO_TRANSMISSION,
    PDO_INHIBIT,
    PDO_EVENT_TIMER,
    PDO_SYNC_START,
    BUS_ADDED,
    BUS_REMOVED,
    BUS_BIT_RATE,
    BUS_MANAGER,
    BUS_SYNC,
    BUS_HEARTBEAT,
    BUS_SETTING,
    NODE_ADDED,
    NODE_REMOVED,
    NODE_RENAMED,
    NODE_ID,
    NODE_DEVICE,
    NODE_VALUE,
    NODE_SUPERVISION,
    KIND_PORTS,
    KIND_SCALE,
    LINK_ADDED,
    LINK_REMOVED,
)
