"""The slave of the layer setting services (CiA 305): node-id and bit rate over the bus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

from rtgen.runtime.canopen.frames import (
    LSS_REQUEST,
    LSS_RESPONSE,
    MAX_DATA,
    MAX_NODE_ID,
    Frame,
)

Identity: TypeAlias = tuple[int, int, int, int]
"""Vendor-id, product code, revision and serial number, as 1018h has them."""

UNCONFIGURED: Final = 0xFF
"""The node-id of a node that has none yet."""
BIT_RATES: Final = {0: 1000, 1: 800, 2: 500, 3: 250, 4: 125, 6: 50, 7: 20, 8: 10}
"""Bit rates in kbit/s by their index in the standard table."""

SWITCH_GLOBAL: Final = 0x04
SET_NODE_ID: Final = 0x11
SET_BIT_TIMING: Final = 0x13
ACTIVATE_BIT_TIMING: Final = 0x15
STORE: Final = 0x17
SELECT_FIRST: Final = 0x40
SELECTED: Final = 0x44
IDENTIFY_FIRST: Final = 0x46
IDENTIFY_LAST: Final = 0x4B
IDENTIFY_UNCONFIGURED: Final = 0x4C
IDENTIFIED: Final = 0x4F
UNCONFIGURED_IDENTIFIED: Final = 0x50
FASTSCAN: Final = 0x51
INQUIRE_FIRST: Final = 0x5A
INQUIRE_NODE_ID: Final = 0x5E

FASTSCAN_BEGIN: Final = 0x80
_CONFIGURATION: Final = 1
_REFUSED: Final = 1
_IDENTITY_PARTS: Final = (0, 1, 2, 2, 3, 3)
"""Which part of the identity the commands 46h to 4Bh are about; two have a low and a high end."""


@dataclass
class LssSettings:
    """What the services set; 255 is no node-id, the bit rate is in kbit/s, None if never set."""

    node_id: int = UNCONFIGURED
    bit_rate: int | None = None


class LssSlave:
    """Answers the master; what it sets is `pending` until the node takes it over.

    `stored` is what a reset of the node comes back with. `activated` is called with a bit rate, in
    kbit/s, and the delay in ms before and after the change.
    """

    def __init__(
        self,
        identity: Callable[[], Identity],
        node_id: int = UNCONFIGURED,
        activated: Callable[[int, int], None] | None = None,
    ) -> None:
        self._identity = identity
        self._activated = activated
        self.active = node_id
        """The node-id that the node has now."""
        self.pending = LssSettings(node_id)
        self.stored = LssSettings(node_id)
        self.configuring = False
        """Whether the slave is in the configuration state, not in the waiting state."""
        self._matched = 0
        self._identified = 0
        self._scanned = 0

    def receive(self, frame: Frame) -> list[Frame]:
        """The answers to a frame."""
        if frame.can_id != LSS_REQUEST or frame.extended or frame.remote:
            return []
        if len(frame.data) != MAX_DATA:
            return []
        answer = self._answer(frame.data)
        if answer is None:
            return []
        return [Frame(LSS_RESPONSE, answer.ljust(MAX_DATA, b"\0"))]

    def take_over(self, *, stored: bool) -> int:
        """The node-id that a reset gives; of the whole node, it is the stored one."""
        if stored:
            self.pending = LssSettings(self.stored.node_id, self.stored.bit_rate)
        self.active = self.pending.node_id
        self.configuring = False
        return self.active

    def _answer(self, data: bytes) -> bytes | None:
        command = data[0]
        number = int.from_bytes(data[1:5], "little")
        if command == SWITCH_GLOBAL:
            self.configuring = data[1] == _CONFIGURATION
            self._matched = 0
            return None
        if command == FASTSCAN:
            return self._fastscan(number, *data[5:8])
        if SELECT_FIRST <= command < SELECT_FIRST + 4:
            return self._select(command - SELECT_FIRST, number)
        if IDENTIFY_FIRST <= command <= IDENTIFY_LAST:
            return self._identify(command - IDENTIFY_FIRST, number)
        if command == IDENTIFY_UNCONFIGURED:
            unconfigured = self.active == UNCONFIGURED
            return bytes((UNCONFIGURED_IDENTIFIED,)) if unconfigured else None
        return self._configure(command, data) if self.configuring else None

    def _configure(self, command: int, data: bytes) -> bytes | None:
        """The services of the configuration state."""
        if command == SET_NODE_ID:
            fits = 1 <= data[1] <= MAX_NODE_ID or data[1] == UNCONFIGURED
            if fits:
                self.pending.node_id = data[1]
            return bytes((command, 0 if fits else _REFUSED))
        if command == SET_BIT_TIMING:
            fits = data[1] == 0 and data[2] in BIT_RATES
            if fits:
                self.pending.bit_rate = BIT_RATES[data[2]]
            return bytes((command, 0 if fits else _REFUSED))
        if command == ACTIVATE_BIT_TIMING:
            if self._activated is not None and self.pending.bit_rate is not None:
                delay = int.from_bytes(data[1:3], "little")
                self._activated(self.pending.bit_rate, delay)
            return None
        if command == STORE:
            self.stored = LssSettings(self.pending.node_id, self.pending.bit_rate)
            return bytes((command, 0))
        if INQUIRE_FIRST <= command < INQUIRE_NODE_ID:
            part = self._identity()[command - INQUIRE_FIRST]
            return bytes((command,)) + part.to_bytes(4, "little")
        if command == INQUIRE_NODE_ID:
            return bytes((command, self.active))
        return None

    def _select(self, part: int, number: int) -> bytes | None:
        if self.configuring:
            return None
        if part == 0:
            self._matched = 0
        right = part == self._matched and self._identity()[part] == number
        self._matched = part + 1 if right else 0
        if self._matched < 4:
            return None
        self._matched, self.configuring = 0, True
        return bytes((SELECTED,))

    def _identify(self, step: int, number: int) -> bytes | None:
        own = self._identity()[_IDENTITY_PARTS[step]]
        if step == 0:
            self._identified = 0
        if step in (0, 1):
            right = own == number
        else:
            right = own >= number if step % 2 == 0 else own <= number
        right = right and step == self._identified
        self._identified = step + 1 if right else 0
        if self._identified < len(_IDENTITY_PARTS):
            return None
        self._identified = 0
        return bytes((IDENTIFIED,))

    def _fastscan(
        self, number: int, bit: int, part: int, following: int
    ) -> bytes | None:
        if self.active != UNCONFIGURED or self.configuring:
            return None
        answer = bytes((IDENTIFIED,))
        if bit == FASTSCAN_BEGIN:
            self._scanned = 0
            return answer
        if bit > 31 or part > 3 or following > 3 or part != self._scanned:
            return None
        if (self._identity()[part] ^ number) >> bit:
            return None
        if bit == 0:
            self._scanned = following
            if following < part:
                self._scanned, self.configuring = 0, True
        return answer
