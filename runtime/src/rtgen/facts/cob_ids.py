"""COB-IDs of communication objects: predefined, restricted, and those in force.

Sources: CiA 301, 7.3.3 (predefined connection set), 7.3.5 (restricted CAN identifiers), 7.5.2 (the
objects). The only judgement of what a COB-ID that is missing, 0 or restricted stands for: front
end, generated device, proxy, manager, decoder and start-up ask here.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import Final, NamedTuple, TypeAlias

from rtgen.facts.canopen import (
    EMERGENCY,
    EXTENDED,
    INVALID,
    MAX_EXTENDED_ID,
    NO_RTR,
    PDOS,
    RPDO_COMMUNICATION,
    SDO_REQUEST,
    SDO_RESPONSE,
    SYNC,
    TIME,
    TPDO_COMMUNICATION,
    can_id_of,
)

Number: TypeAlias = tuple[int, int]
"""Index and sub-index of an object."""

COB_ID_SYNC: Final = (0x1005, 0)
COB_ID_TIME: Final = (0x1012, 0)
COB_ID_EMERGENCY: Final = (0x1014, 0)
EMERGENCY_CONSUMERS: Final = 0x1028
SDO_SERVERS: Final = range(0x1200, 0x1280)
SDO_CLIENTS: Final = range(0x1280, 0x1300)
PREDEFINED_PDOS: Final = 4
"""PDOs of each direction that have a predefined COB-ID."""

_RESTRICTED: Final = (
    (0x000, 0x07F),
    (0x101, 0x180),
    (0x581, 0x5FF),
    (0x601, 0x67F),
    (0x6E0, 0x6FF),
    (0x701, 0x7FF),
)
_RESERVED: Final = 0x1FFFF800
"""Bits of a COB-ID with an 11-bit identifier that are 0."""
_WORD: Final = 0xFFFFFFFF
_RPDO_BASE: Final = 0x200
_TPDO_BASE: Final = 0x180
_NEXT_PDO: Final = 0x100


class Service(NamedTuple):
    """The service of a COB-ID.

    `base` is its predefined identifier, to which the node-id is added if it is `relative`; None:
    none is predefined. The flags in `on` mean that the service exists; without such flags, bit 31
    means that it does not. `flags` are those with another meaning. `fixed`: the identifier cannot
    be configured.
    """

    name: str
    base: int | None = None
    relative: bool = False
    on: int = 0
    flags: int = 0
    fixed: bool = False

    def predefined(self, node_id: int) -> int:
        """Return the predefined COB-ID; one that is not valid if there is none."""
        if self.base is None:
            return INVALID
        return self.base + node_id if self.relative else self.base

    def flags_of(self, cob_id: int) -> int:
        """Return the flags of a COB-ID that have a meaning, besides that it is not valid."""
        return cob_id & (self.on | self.flags)

    def exists(self, cob_id: int) -> bool:
        """Return whether the COB-ID's identifier is in use, so that it cannot be changed."""
        return bool(cob_id & self.on) if self.on else not cob_id & INVALID

    def switched_off(self, cob_id: int) -> int:
        """Return the COB-ID with which its service does not exist."""
        return cob_id & ~self.on if self.on else cob_id | INVALID


class Standing(Enum):
    """What a stated COB-ID stands for."""

    STATED = auto()
    """Itself."""
    PREDEFINED = auto()
    """None is stated: the predefined one, with the stated flags."""
    OFF = auto()
    """The service cannot have it: it is switched off."""


def restricted(can_id: int) -> bool:
    """Return whether the 11-bit identifier cannot be configured (CiA 301, 7.3.5)."""
    return any(low <= can_id <= high for low, high in _RESTRICTED)


def configurable(cob_id: int) -> bool:
    """Return whether an object may have it: no restricted identifier, no reserved bit set."""
    if cob_id & EXTENDED:
        return True
    return not (restricted(can_id_of(cob_id)) or cob_id & _RESERVED)


def service_of(number: Number) -> Service | None:
    """Return the service of an object with a COB-ID; None for other objects."""
    index, subindex = number
    if number in _SINGLE:
        return _SINGLE[number]
    if index == EMERGENCY_CONSUMERS and subindex:
        return Service(f"EMCY of entry {subindex}")
    if index in SDO_SERVERS and subindex in (1, 2):
        return _sdo_server(index - SDO_SERVERS.start + 1, subindex)
    if index in SDO_CLIENTS and subindex in (1, 2):
        return Service(f"SDO client {index - SDO_CLIENTS.start + 1}")
    for name, first, base, flags in (
        ("RPDO", RPDO_COMMUNICATION, _RPDO_BASE, 0),
        ("TPDO", TPDO_COMMUNICATION, _TPDO_BASE, NO_RTR),
    ):
        place = index - first
        if 0 <= place < PDOS and subindex == 1:
            identifier = base + _NEXT_PDO * place if place < PREDEFINED_PDOS else None
            return Service(
                f"{name} {place + 1}", identifier, relative=True, flags=flags
            )
    return None


def _sdo_server(server: int, subindex: int) -> Service:
    if server > 1:
        return Service(f"SDO server {server}")
    base = SDO_REQUEST if subindex == 1 else SDO_RESPONSE
    return Service("SDO server 1", base, relative=True, fixed=True)


_SINGLE: Final = {
    COB_ID_SYNC: Service("SYNC", SYNC, on=NO_RTR),
    COB_ID_TIME: Service("TIME", TIME, on=INVALID | NO_RTR),
    COB_ID_EMERGENCY: Service("EMCY", EMERGENCY, relative=True),
}


def standing(service: Service, cob_id: int | None, *, chosen: bool = False) -> Standing:
    """Return what a stated COB-ID stands for; None: none is stated.

    Identifier 0 states none, and so does the function code of a service without the node-id, such
    as 200h for RPDO 1, unless it was `chosen` for a node.
    """
    if cob_id is None:
        return Standing.PREDEFINED
    if cob_id & EXTENDED:
        return Standing.STATED
    if not service.on and cob_id & INVALID:
        return Standing.STATED
    identifier = cob_id & MAX_EXTENDED_ID
    if not identifier:
        return Standing.PREDEFINED
    if service.fixed:
        return Standing.STATED
    if service.relative and identifier == service.base and not chosen:
        return Standing.PREDEFINED
    return Standing.STATED if configurable(cob_id) else Standing.OFF


def is_stated(number: Number, cob_id: int | None) -> bool:
    """Return whether a description states the COB-ID with which its nodes begin.

    Otherwise nodes may have another one than `in_force`, and others than each other.
    """
    service = service_of(number)
    word = None if cob_id is None else cob_id & _WORD
    return service is None or standing(service, word) is Standing.STATED


def in_force(
    number: Number, cob_id: int | None, node_id: int, *, chosen: bool = False
) -> int | None:
    """Return the COB-ID that an object has in a node; `cob_id` if the object has none.

    See `standing`.
    """
    service = service_of(number)
    if service is None:
        return cob_id
    if cob_id is not None:
        cob_id &= _WORD
    match standing(service, cob_id, chosen=chosen):
        case Standing.PREDEFINED:
            return service.predefined(node_id) | service.flags_of(cob_id or 0)
        case Standing.OFF:
            assert cob_id is not None
            return service.switched_off(cob_id)
    return cob_id
