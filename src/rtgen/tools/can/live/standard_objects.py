"""Names, data types and access of standardized objects.

Sources: CiA 301, 7.5.2 (communication), CiA 401-1 (I/O devices), CiA 402-2 and -3 (drives).
"""

from __future__ import annotations

from functools import cache
from typing import Final

import msgspec

from rtgen.compiler.model.canopen import Access, DataType
from rtgen.compiler.typemap.canopen.communication import type_of
from rtgen.facts.canopen import (
    PDOS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    TPDO_COMMUNICATION,
    TPDO_MAPPING,
)
from rtgen.facts.cob_ids import SDO_CLIENTS, SDO_SERVERS

COMMUNICATION: Final = (
    *range(0x1000, 0x102B),
    *range(0x1200, 0x1210),
    *range(0x1280, 0x1290),
)
"""The indices of communication objects without those of PDOs; few devices have more SDOs."""
_PROFILE_AREA: Final = range(0x6000, 0xA000)
_NEXT_DEVICE: Final = 0x800
"""Distance of the objects of the logical devices of a node."""

_NAMES: Final = {
    0x1000: "Device type",
    0x1001: "Error register",
    0x1002: "Manufacturer status register",
    0x1003: "Pre-defined error field",
    0x1005: "COB-ID SYNC message",
    0x1006: "Communication cycle period",
    0x1007: "Synchronous window length",
    0x1008: "Manufacturer device name",
    0x1009: "Manufacturer hardware version",
    0x100A: "Manufacturer software version",
    0x100C: "Guard time",
    0x100D: "Life time factor",
    0x1010: "Store parameters",
    0x1011: "Restore default parameters",
    0x1012: "COB-ID time stamp object",
    0x1013: "High resolution time stamp",
    0x1014: "COB-ID EMCY",
    0x1015: "Inhibit time EMCY",
    0x1016: "Consumer heartbeat time",
    0x1017: "Producer heartbeat time",
    0x1018: "Identity object",
    0x1019: "Synchronous counter overflow value",
    0x1020: "Verify configuration",
    0x1021: "Store EDS",
    0x1022: "Store format",
    0x1023: "OS command",
    0x1024: "OS command mode",
    0x1025: "OS debugger interface",
    0x1026: "OS prompt",
    0x1027: "Module list",
    0x1028: "Emergency consumer object",
    0x1029: "Error behavior object",
}
_PARTS: Final = {
    0x1018: ("Vendor-ID", "Product code", "Revision number", "Serial number"),
    0x1020: ("Configuration date", "Configuration time"),
}
ARRAYS: Final = (0x1003, 0x1010, 0x1011, 0x1016, 0x1027, 0x1028, 0x1029)
"""Communication objects that are arrays; others with subobjects are records."""
_CONSTANT: Final = (
    *range(0x1000, 0x1004),
    *range(0x1008, 0x100B),
    0x1018,
    0x1021,
    SDO_SERVERS.start,
)
_PDO_PARTS: Final = (
    "COB-ID",
    "Transmission type",
    "Inhibit time",
    "Compatibility entry",
    "Event timer",
    "SYNC start value",
)
_SDO_PARTS: Final = (
    "COB-ID client to server",
    "COB-ID server to client",
    "Node-ID of the other end",
)

_IO: Final = """
6000 UNSIGNED8 ro Read input 8-bit
6002 UNSIGNED8 rw Polarity input 8-bit
6003 UNSIGNED8 rw Filter constant input 8-bit
6005 BOOLEAN rw Global interrupt enable digital
6006 UNSIGNED8 rw Interrupt mask any change 8-bit
6007 UNSIGNED8 rw Interrupt mask low to high 8-bit
6008 UNSIGNED8 rw Interrupt mask high to low 8-bit
6020 BOOLEAN ro Read input bit
6100 UNSIGNED16 ro Read input 16-bit
6120 UNSIGNED32 ro Read input 32-bit
6200 UNSIGNED8 rw Write output 8-bit
6202 UNSIGNED8 rw Polarity output 8-bit
6206 UNSIGNED8 rw Error mode output 8-bit
6207 UNSIGNED8 rw Error value output 8-bit
6208 UNSIGNED8 rw Filter mask output 8-bit
6220 BOOLEAN rw Write output bit
6300 UNSIGNED16 rw Write output 16-bit
6320 UNSIGNED32 rw Write output 32-bit
6400 INTEGER8 ro Read analogue input 8-bit
6401 INTEGER16 ro Read analogue input 16-bit
6402 INTEGER32 ro Read analogue input 32-bit
6403 REAL32 ro Read analogue input float
6410 INTEGER8 rw Write analogue output 8-bit
6411 INTEGER16 rw Write analogue output 16-bit
6412 INTEGER32 rw Write analogue output 32-bit
6413 REAL32 rw Write analogue output float
6421 UNSIGNED8 rw Analogue input interrupt trigger selection
6422 UNSIGNED32 ro Analogue input interrupt source
6423 BOOLEAN rw Analogue input global interrupt enable
6424 INTEGER32 rw Analogue input interrupt upper limit
6425 INTEGER32 rw Analogue input interrupt lower limit
6426 UNSIGNED32 rw Analogue input interrupt delta
6427 UNSIGNED32 rw Analogue input interrupt negative delta
6428 UNSIGNED32 rw Analogue input interrupt positive delta
6430 UNSIGNED32 rw Analogue input SI unit
6431 INTEGER32 rw Analogue input offset
6432 INTEGER32 rw Analogue input scaling
6443 UNSIGNED8 rw Analogue output error mode
6444 INTEGER32 rw Analogue output error value
"""
_DRIVE: Final = """
603F UNSIGNED16 ro Error code
6040 UNSIGNED16 rw Controlword
6041 UNSIGNED16 ro Statusword
6042 INTEGER16 rw vl target velocity
6043 INTEGER16 ro vl velocity demand
6044 INTEGER16 ro vl velocity actual value
605A INTEGER16 rw Quick stop option code
605B INTEGER16 rw Shutdown option code
605C INTEGER16 rw Disable operation option code
605D INTEGER16 rw Halt option code
605E INTEGER16 rw Fault reaction option code
6060 INTEGER8 rw Modes of operation
6061 INTEGER8 ro Modes of operation display
6062 INTEGER32 ro Position demand value
6063 INTEGER32 ro Position actual internal value
6064 INTEGER32 ro Position actual value
6065 UNSIGNED32 rw Following error window
6066 UNSIGNED16 rw Following error time out
6067 UNSIGNED32 rw Position window
6068 UNSIGNED16 rw Position window time
6069 INTEGER32 ro Velocity sensor actual value
606A INTEGER16 rw Sensor selection code
606B INTEGER32 ro Velocity demand value
606C INTEGER32 ro Velocity actual value
606D UNSIGNED16 rw Velocity window
606E UNSIGNED16 rw Velocity window time
606F UNSIGNED16 rw Velocity threshold
6070 UNSIGNED16 rw Velocity threshold time
6071 INTEGER16 rw Target torque
6072 UNSIGNED16 rw Max torque
6073 UNSIGNED16 rw Max current
6074 INTEGER16 ro Torque demand
6075 UNSIGNED32 rw Motor rated current
6076 UNSIGNED32 rw Motor rated torque
6077 INTEGER16 ro Torque actual value
6078 INTEGER16 ro Current actual value
6079 UNSIGNED32 ro DC link circuit voltage
607A INTEGER32 rw Target position
607B INTEGER32 rw Position range limit
607C INTEGER32 rw Home offset
607D INTEGER32 rw Software position limit
607E UNSIGNED8 rw Polarity
607F UNSIGNED32 rw Max profile velocity
6080 UNSIGNED32 rw Max motor speed
6081 UNSIGNED32 rw Profile velocity
6082 UNSIGNED32 rw End velocity
6083 UNSIGNED32 rw Profile acceleration
6084 UNSIGNED32 rw Profile deceleration
6085 UNSIGNED32 rw Quick stop deceleration
6086 INTEGER16 rw Motion profile type
6087 UNSIGNED32 rw Torque slope
6088 INTEGER16 rw Torque profile type
608F UNSIGNED32 rw Position encoder resolution
6090 UNSIGNED32 rw Velocity encoder resolution
6091 UNSIGNED32 rw Gear ratio
6092 UNSIGNED32 rw Feed constant
6098 INTEGER8 rw Homing method
6099 UNSIGNED32 rw Homing speeds
609A UNSIGNED32 rw Homing acceleration
60B0 INTEGER32 rw Position offset
60B1 INTEGER32 rw Velocity offset
60B2 INTEGER16 rw Torque offset
60B8 UNSIGNED16 rw Touch probe function
60B9 UNSIGNED16 ro Touch probe status
60C0 INTEGER16 rw Interpolation sub mode select
60C1 INTEGER32 rw Interpolation data record
60C5 UNSIGNED32 rw Max acceleration
60C6 UNSIGNED32 rw Max deceleration
60F4 INTEGER32 ro Following error actual value
60FA INTEGER32 ro Control effort
60FC INTEGER32 ro Position demand internal value
60FD UNSIGNED32 ro Digital inputs
60FE UNSIGNED32 rw Digital outputs
60FF INTEGER32 rw Target velocity
6502 UNSIGNED32 ro Supported drive modes
"""
_PROFILES: Final = {401: _IO, 402: _DRIVE}


class Standard(msgspec.Struct, frozen=True):
    """What a standard says of an object; `data_type` and `access` None: nothing."""

    name: str = ""
    data_type: DataType | None = None
    access: Access | None = None


def standard(index: int, subindex: int, profile: int) -> Standard:
    """Return what the standards say of an object of a device with a profile (1000h, 16 bits).

    It may have subobjects: data type and access are those of each but sub-index 0.
    """
    if index in _PROFILE_AREA:
        known = _objects(profile).get(index % _NEXT_DEVICE)
        return known or Standard()
    if index >= 0x2000:
        return Standard()
    name, parts = _communication_names(index)
    if subindex and parts:
        name = parts[subindex - 1] if subindex <= len(parts) else ""
    if index in _CONSTANT:
        return Standard(name, type_of(index, subindex), Access.RO)
    return Standard(name, type_of(index, subindex), Access.RW if name else None)


def name_of(index: int, profile: int) -> str:
    """Return the name of an object with subobjects; empty for an unknown one."""
    if index >= 0x2000:
        return standard(index, 0, profile).name
    return _communication_names(index)[0]


def _communication_names(index: int) -> tuple[str, tuple[str, ...]]:
    for base, name, parts in (
        (RPDO_COMMUNICATION, "RPDO communication parameter", _PDO_PARTS),
        (TPDO_COMMUNICATION, "TPDO communication parameter", _PDO_PARTS),
        (RPDO_MAPPING, "RPDO mapping parameter", ()),
        (TPDO_MAPPING, "TPDO mapping parameter", ()),
    ):
        if base <= index < base + PDOS:
            return f"{name} {index - base + 1}", parts
    if index in SDO_SERVERS:
        number = index - SDO_SERVERS.start + 1
        return f"SDO server parameter {number}", _SDO_PARTS
    if index in SDO_CLIENTS:
        number = index - SDO_CLIENTS.start + 1
        return f"SDO client parameter {number}", _SDO_PARTS
    return _NAMES.get(index, ""), _PARTS.get(index, ())


@cache
def _objects(profile: int) -> dict[int, Standard]:
    """Return the objects of a profile by the distance from its first index."""
    objects = {}
    for line in _PROFILES.get(profile, "").strip().splitlines():
        index, type_, access, name = line.split(" ", 3)
        place = int(index, 16) % _NEXT_DEVICE
        objects[place] = Standard(name, DataType[type_], Access(access))
    return objects
