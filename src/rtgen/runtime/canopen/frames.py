"""Frames and identifiers (CiA 301, 7.2 and 7.3.3): what every protocol machine speaks in.

The machines of this package do no I/O and keep no clock: frames and the time, in integer
nanoseconds, come from outside, and frames to be sent are returned.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

SECOND: Final = 1_000_000_000
"""Nanoseconds in a second."""
MILLISECOND: Final = 1_000_000
"""Nanoseconds in the unit of the heartbeat and event times."""
INHIBIT_UNIT: Final = 100_000
"""Nanoseconds in the unit of the inhibit times, 100 us."""

MAX_NODE_ID: Final = 127
MAX_DATA: Final = 8

NMT: Final = 0x000
SYNC: Final = 0x080
EMERGENCY: Final = 0x080
"""To be added to the node-id, as the following ones are."""
TIME: Final = 0x100
SDO_RESPONSE: Final = 0x580
SDO_REQUEST: Final = 0x600
ERROR_CONTROL: Final = 0x700
LSS_RESPONSE: Final = 0x7E4
LSS_REQUEST: Final = 0x7E5

_RESTRICTED: Final = (
    (0x000, 0x07F),
    (0x101, 0x180),
    (0x581, 0x5FF),
    (0x601, 0x67F),
    (0x6E0, 0x7FF),
)


@dataclass(frozen=True, slots=True)
class Frame:
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
    """A COB-ID as the object dictionary has it: identifier and flags (CiA 301, 7.5.2).

    `bit31` says of PDO, SDO and EMCY that the object does not exist, of TIME that the node takes
    it. `bit30` says of a TPDO that it allows no remote frame, of SYNC and TIME that the node
    produces it.
    """

    value: int
    extended: bool = field(init=False, repr=False, compare=False)
    """Whether the identifier has 29 bits."""
    can_id: int = field(init=False, repr=False, compare=False)
    """The identifier."""

    def __post_init__(self) -> None:
        if not 0 <= self.value < 1 << 32:
            raise ValueError(f"no COB-ID: {self.value:#x}")
        extended = bool(self.value & 1 << 29)
        object.__setattr__(self, "extended", extended)
        can_id = self.value & (0x1FFFFFFF if extended else 0x7FF)
        object.__setattr__(self, "can_id", can_id)

    @property
    def bit31(self) -> bool:
        """Whether bit 31 is set."""
        return bool(self.value & 1 << 31)

    @property
    def bit30(self) -> bool:
        """Whether bit 30 is set."""
        return bool(self.value & 1 << 30)

    @property
    def configurable(self) -> bool:
        """Whether an object may have it: not of other services, no bit set between."""
        if self.extended:
            return True
        return not (restricted(self.can_id) or self.value & 0x1FFFF800)

    def carries(self, frame: Frame) -> bool:
        """Whether the frame has this identifier, of the same length."""
        return frame.can_id == self.can_id and frame.extended == self.extended

    def frame(self, data: bytes) -> Frame:
        """A data frame with this identifier."""
        return Frame(self.can_id, data, extended=self.extended)


def checked_node_id(node_id: int) -> int:
    """The node-id. Raises ValueError unless it is 1 to 127."""
    if not 1 <= node_id <= MAX_NODE_ID:
        raise ValueError(f"node-id {node_id}: it is 1 to {MAX_NODE_ID}")
    return node_id


def tpdo(number: int, node_id: int) -> int:
    """The predefined identifier of TPDO 1 to 4 (CiA 301, 7.3.3, table 39)."""
    return _pdo(0x180, number, node_id)


def rpdo(number: int, node_id: int) -> int:
    """The predefined identifier of RPDO 1 to 4 (CiA 301, 7.3.3, table 39)."""
    return _pdo(0x200, number, node_id)


def _pdo(first: int, number: int, node_id: int) -> int:
    if not 1 <= number <= 4:
        raise ValueError(f"PDO {number} has no predefined identifier")
    return first + 0x100 * (number - 1) + checked_node_id(node_id)


def restricted(can_id: int) -> bool:
    """Whether no object may be configured to that identifier of 11 bits (CiA 301, table 40)."""
    return any(low <= can_id <= high for low, high in _RESTRICTED)
