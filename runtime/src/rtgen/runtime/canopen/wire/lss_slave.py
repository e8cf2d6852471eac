"""LSS slave (CiA 305): node-id and bit rate over the bus."""

from __future__ import annotations

import operator
from collections.abc import Callable, Collection
from typing import Final

import msgspec
from msgspec.structs import replace

from rtgen.runtime.canopen.wire.frames import (
    LSS_REQUEST,
    LSS_RESPONSE,
    MAX_NODE_ID,
    Frame,
)
from rtgen.runtime.canopen.wire.lss import (
    BIT_RATES,
    CONFIGURATION,
    MESSAGE,
    OUT_OF_RANGE,
    START_OF_SCAN,
    UNCONFIGURED,
    LssAddress,
    LssCommand,
    first_number,
    message,
)

_RATES: Final = {index: rate for rate, index in BIT_RATES.items()}
_SWITCHES: Final = (
    LssCommand.SWITCH_VENDOR,
    LssCommand.SWITCH_PRODUCT,
    LssCommand.SWITCH_REVISION,
    LssCommand.SWITCH_SERIAL,
)
_INQUIRIES: Final = (
    LssCommand.INQUIRE_VENDOR,
    LssCommand.INQUIRE_PRODUCT,
    LssCommand.INQUIRE_REVISION,
    LssCommand.INQUIRE_SERIAL,
)
_RANGE: Final = {
    LssCommand.IDENTIFY_VENDOR: (0, operator.eq),
    LssCommand.IDENTIFY_PRODUCT: (1, operator.eq),
    LssCommand.IDENTIFY_REVISION_LOW: (2, operator.ge),
    LssCommand.IDENTIFY_REVISION_HIGH: (2, operator.le),
    LssCommand.IDENTIFY_SERIAL_LOW: (3, operator.ge),
    LssCommand.IDENTIFY_SERIAL_HIGH: (3, operator.le),
}
"""The address part in a command, and its comparison."""


class LssSettings(msgspec.Struct, gc=False):
    """Settings: node-id (255: unconfigured) and bit rate in kbit/s (None: never set)."""

    node_id: int = UNCONFIGURED
    bit_rate: int | None = None


class LssSlave:
    """Responds to the master; settings stay `pending` until the node applies them."""

    def __init__(
        self,
        address: Callable[[], LssAddress],
        node_id: int = UNCONFIGURED,
        activated: Callable[[int, int], None] | None = None,
        bit_rates: Collection[int] = (),
    ) -> None:
        self._address = address
        self._activated = activated
        self._rates = {
            index: rate
            for index, rate in _RATES.items()
            if not bit_rates or rate in bit_rates
        }
        self.active = node_id
        """The node-id in use."""
        self.pending = LssSettings(node_id)
        self.stored = LssSettings(node_id)
        self.configuring = False
        """Whether the slave is in the configuration state (else in the waiting state)."""
        self._matched = 0
        self._in_range = 0
        self._scanned = 0

    def receive(self, frame: Frame) -> list[Frame]:
        """Return the responses to a frame."""
        if frame.can_id != LSS_REQUEST or frame.extended or frame.remote:
            return []
        if len(frame.data) != MESSAGE:
            return []
        try:
            answer = self._answer(LssCommand(frame.data[0]), frame.data)
        except ValueError:
            return []
        return [] if answer is None else [Frame(LSS_RESPONSE, answer)]

    def take_over(self, *, stored: bool) -> int:
        """Return the node-id after a reset; `stored`: after a reset of the whole node."""
        if stored:
            self.pending = replace(self.stored)
        self.active = self.pending.node_id
        self.configuring = False
        return self.active

    def _answer(self, command: LssCommand, data: bytes) -> bytes | None:
        if command is LssCommand.SWITCH_GLOBAL:
            self.configuring = data[1] == CONFIGURATION
            self._matched = 0
            return None
        if command is LssCommand.FASTSCAN:
            return self._scan(first_number(data), *data[5:8])
        if command in _SWITCHES:
            return self._switch(_SWITCHES.index(command), first_number(data))
        if command in _RANGE:
            return self._identify(command, first_number(data))
        if command is LssCommand.IDENTIFY_UNCONFIGURED:
            unconfigured = self.active == UNCONFIGURED
            return message(LssCommand.UNCONFIGURED_IDENTIFIED) if unconfigured else None
        return self._configure(command, data) if self.configuring else None

    def _configure(self, command: LssCommand, data: bytes) -> bytes | None:
        """Execute a service of the configuration state."""
        if command is LssCommand.CONFIGURE_NODE_ID:
            fits = 1 <= data[1] <= MAX_NODE_ID or data[1] == UNCONFIGURED
            if fits:
                self.pending.node_id = data[1]
            return message(command, 0 if fits else OUT_OF_RANGE)
        if command is LssCommand.CONFIGURE_BIT_TIMING:
            fits = data[1] == 0 and data[2] in self._rates
            if fits:
                self.pending.bit_rate = self._rates[data[2]]
            return message(command, 0 if fits else OUT_OF_RANGE)
        if command is LssCommand.ACTIVATE_BIT_TIMING:
            if self._activated is not None and self.pending.bit_rate is not None:
                delay = int.from_bytes(data[1:3], "little")
                self._activated(self.pending.bit_rate, delay)
            return None
        if command is LssCommand.STORE:
            self.stored = replace(self.pending)
            return message(command)
        if command in _INQUIRIES:
            return message(command, self._address()[_INQUIRIES.index(command)])
        if command is LssCommand.INQUIRE_NODE_ID:
            return message(command, self.active)
        return None

    def _switch(self, part: int, number: int) -> bytes | None:
        """Switch state selective: compare the address part by part.

        The matching slave enters the configuration state.
        """
        if self.configuring:
            return None
        if part == 0:
            self._matched = 0
        right = part == self._matched and self._address()[part] == number
        self._matched = part + 1 if right else 0
        if self._matched < len(_SWITCHES):
            return None
        self._matched, self.configuring = 0, True
        return message(LssCommand.SWITCHED)

    def _identify(self, command: LssCommand, number: int) -> bytes | None:
        """Identify: compare vendor and product, then ranges of revision and serial number."""
        part, compare = _RANGE[command]
        step = list(_RANGE).index(command)
        if step == 0:
            self._in_range = 0
        right = step == self._in_range and compare(self._address()[part], number)
        self._in_range = step + 1 if right else 0
        if self._in_range < len(_RANGE):
            return None
        self._in_range = 0
        return message(LssCommand.IDENTIFIED)

    def _scan(self, number: int, bit: int, part: int, following: int) -> bytes | None:
        """Fastscan: respond if the address matches down to a bit; the last match selects."""
        if self.active != UNCONFIGURED or self.configuring:
            return None
        if bit == START_OF_SCAN:
            self._scanned = 0
            return message(LssCommand.IDENTIFIED)
        if bit > 31 or part > 3 or following > 3 or part != self._scanned:
            return None
        if (self._address()[part] ^ number) >> bit:
            return None
        if bit == 0:
            self._scanned = following
            if following < part:
                self._scanned, self.configuring = 0, True
        return message(LssCommand.IDENTIFIED)
