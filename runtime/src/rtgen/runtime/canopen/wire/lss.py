"""Commands, addresses and messages of layer setting services (CiA 305), for master and slave."""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple

UNCONFIGURED: Final = 0xFF
"""The node-id of an unconfigured node."""
MESSAGE: Final = 8
"""Length of every message in octets."""

WAITING: Final = 0
CONFIGURATION: Final = 1
"""The two states of a slave, as encoded in SWITCH_GLOBAL."""

OUT_OF_RANGE: Final = 1
"""Error code of a response; 0 is success, 255 manufacturer-specific."""
STORING_UNSUPPORTED: Final = 1
STORING_FAILED: Final = 2

START_OF_SCAN: Final = 0x80
"""The bit number of the fastscan message that starts a scan."""

BIT_RATES: Final = {
    1000: 0, 800: 1, 500: 2, 250: 3, 125: 4, 50: 6, 20: 7, 10: 8,
}  # fmt: skip
"""Bit timing table 0: kbit/s to index."""
AUTOMATIC_BIT_RATE: Final = 9


class LssCommand(IntEnum):
    """Command specifiers; a response repeats that of its request unless it has its own."""

    SWITCH_GLOBAL = 0x04
    CONFIGURE_NODE_ID = 0x11
    CONFIGURE_BIT_TIMING = 0x13
    ACTIVATE_BIT_TIMING = 0x15
    STORE = 0x17
    SWITCH_VENDOR = 0x40
    SWITCH_PRODUCT = 0x41
    SWITCH_REVISION = 0x42
    SWITCH_SERIAL = 0x43
    SWITCHED = 0x44
    IDENTIFY_VENDOR = 0x46
    IDENTIFY_PRODUCT = 0x47
    IDENTIFY_REVISION_LOW = 0x48
    IDENTIFY_REVISION_HIGH = 0x49
    IDENTIFY_SERIAL_LOW = 0x4A
    IDENTIFY_SERIAL_HIGH = 0x4B
    IDENTIFY_UNCONFIGURED = 0x4C
    IDENTIFIED = 0x4F
    """Response to IDENTIFY commands and to FASTSCAN: there is a matching slave."""
    UNCONFIGURED_IDENTIFIED = 0x50
    FASTSCAN = 0x51
    INQUIRE_VENDOR = 0x5A
    INQUIRE_PRODUCT = 0x5B
    INQUIRE_REVISION = 0x5C
    INQUIRE_SERIAL = 0x5D
    INQUIRE_NODE_ID = 0x5E


class LssAddress(NamedTuple):
    """The LSS address: the values of 1018h:1 to 4."""

    vendor: int
    product: int
    revision: int
    serial: int


def message(command: LssCommand, value: int = 0, size: int = 4) -> bytes:
    """Return a message with an integer of `size` octets after the command."""
    return (bytes((command,)) + value.to_bytes(size, "little")).ljust(MESSAGE, b"\0")


def fastscan_message(number: int, bit: int, part: int, following: int) -> bytes:
    """Return a fastscan message: address part (0 to 3) equals `number` from bit `bit` upwards."""
    head = bytes((LssCommand.FASTSCAN,)) + number.to_bytes(4, "little")
    return head + bytes((bit, part, following))


def first_number(data: bytes) -> int:
    """Return the integer of 4 octets after the command."""
    return int.from_bytes(data[1:5], "little")
