"""CAN frames and identifiers (CiA 301, 7.2 and 7.3.3), shared by all protocol machines.

The machines of this package do no I/O and have no clock: they are given received frames and the
time, in integer nanoseconds, and return the frames to send.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import msgspec

from rtgen.facts.canopen import EMERGENCY as EMERGENCY
from rtgen.facts.canopen import ERROR_CONTROL as ERROR_CONTROL
from rtgen.facts.canopen import EXTENDED, INVALID, NO_RTR, can_id_of
from rtgen.facts.canopen import INHIBIT_UNIT as INHIBIT_UNIT
from rtgen.facts.canopen import LSS_REQUEST as LSS_REQUEST
from rtgen.facts.canopen import LSS_RESPONSE as LSS_RESPONSE
from rtgen.facts.canopen import MAX_NODE_ID as MAX_NODE_ID
from rtgen.facts.canopen import MILLISECOND as MILLISECOND
from rtgen.facts.canopen import NMT as NMT
from rtgen.facts.canopen import SDO_REQUEST as SDO_REQUEST
from rtgen.facts.canopen import SDO_RESPONSE as SDO_RESPONSE
from rtgen.facts.canopen import SYNC as SYNC
from rtgen.facts.canopen import TIME as TIME
from rtgen.facts.cob_ids import configurable

SECOND: Final = 1_000_000_000
"""Nanoseconds in a second."""

MAX_DATA: Final = 8


class Frame(msgspec.Struct, frozen=True, gc=False):
    """A CAN frame. Raises ValueError for an identifier or data that CAN cannot carry."""

    can_id: int
    data: bytes = b""
    remote: bool = False
    extended: bool = False

    def __post_init__(self) -> None:
        if not 0 <= self.can_id < 1 << (29 if self.extended else 11):
            raise ValueError(f"no CAN identifier: {self.can_id:#x}")
        if len(self.data) > MAX_DATA:
            raise ValueError(f"{len(self.data)} octets; a frame has up to {MAX_DATA}")


@dataclass(frozen=True, slots=True)
class CobId:
    """A COB-ID of the object dictionary: identifier and flags (CiA 301, 7.5.2).

    `bit31` means "not valid" for PDO, SDO and EMCY, "consumes" for TIME. `bit30` means "no remote
    frames" for a TPDO, "produces" for SYNC and TIME.
    """

    value: int
    extended: bool = field(init=False, repr=False, compare=False)
    """Whether the identifier has 29 bits."""
    can_id: int = field(init=False, repr=False, compare=False)
    """The identifier."""

    def __post_init__(self) -> None:
        if not 0 <= self.value < 1 << 32:
            raise ValueError(f"no COB-ID: {self.value:#x}")
        extended = bool(self.value & EXTENDED)
        object.__setattr__(self, "extended", extended)
        can_id = can_id_of(self.value)
        object.__setattr__(self, "can_id", can_id)

    @property
    def bit31(self) -> bool:
        """Whether bit 31 is set."""
        return bool(self.value & INVALID)

    @property
    def bit30(self) -> bool:
        """Whether bit 30 is set."""
        return bool(self.value & NO_RTR)

    @property
    def configurable(self) -> bool:
        """Whether an object may be set to it: no restricted identifier, no reserved bit set."""
        return configurable(self.value)

    @property
    def valid(self) -> bool:
        """Whether the PDO, SDO or EMCY exists: bit 31 is 0, and the identifier may be used."""
        return not self.bit31 and self.configurable

    def carries(self, frame: Frame) -> bool:
        """Return whether a frame has this identifier and format (11 or 29 bits)."""
        return frame.can_id == self.can_id and frame.extended == self.extended

    def frame(self, data: bytes) -> Frame:
        """Return a data frame with this identifier."""
        return Frame(self.can_id, data, extended=self.extended)


def earliest(*times: int | None) -> int | None:
    """Return the earliest time of which there is one; None for never."""
    first = None
    for time in times:
        if time is not None and (first is None or time < first):
            first = time
    return first


def checked_node_id(node_id: int) -> int:
    """Validate a node-id. Raises ValueError unless it is 1 to 127."""
    if not 1 <= node_id <= MAX_NODE_ID:
        raise ValueError(f"node-id {node_id}: it is 1 to {MAX_NODE_ID}")
    return node_id


def sdo_cob_ids(node_id: int) -> tuple[CobId, CobId]:
    """Return the COB-IDs of requests to and responses of a node's predefined SDO server.

    Raises ValueError for an invalid node-id.
    """
    checked_node_id(node_id)
    return CobId(SDO_REQUEST + node_id), CobId(SDO_RESPONSE + node_id)
