"""Text for the messages of layer setting services (CiA 305)."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.wire import lss
from rtgen.runtime.canopen.wire.lss import LssCommand

_PARTS: Final = ("vendor", "product", "revision", "serial number")
_BIT_RATES: Final = {index: rate for rate, index in lss.BIT_RATES.items()}

_NUMBERS: Final = {
    LssCommand.IDENTIFY_VENDOR: "who has vendor",
    LssCommand.IDENTIFY_PRODUCT: "who has product",
    LssCommand.IDENTIFY_REVISION_LOW: "who has revision from",
    LssCommand.IDENTIFY_REVISION_HIGH: "who has revision up to",
    LssCommand.IDENTIFY_SERIAL_LOW: "who has serial number from",
    LssCommand.IDENTIFY_SERIAL_HIGH: "who has serial number up to",
}
_PLAIN: Final = {
    LssCommand.STORE: "store configuration",
    LssCommand.INQUIRE_NODE_ID: "ask for node-id",
    LssCommand.IDENTIFY_UNCONFIGURED: "who has no node-id",
}
_CONFIGURED: Final = {
    LssCommand.CONFIGURE_NODE_ID: "node-id",
    LssCommand.CONFIGURE_BIT_TIMING: "bit rate",
    LssCommand.STORE: "storing",
}
_ANSWERS: Final = {
    LssCommand.SWITCHED: "selected",
    LssCommand.IDENTIFIED: "here",
    LssCommand.UNCONFIGURED_IDENTIFIED: "has no node-id",
}


def lss_text(data: bytes, *, request: bool) -> str:
    """Return the meaning of a message of the LSS master (`request`) or of a slave."""
    if len(data) != lss.MESSAGE:
        return f"no message: {data.hex(' ') or 'no data'}"
    try:
        command = LssCommand(data[0])
    except ValueError:
        return _unknown(data)
    text = _request(command, data) if request else _answer(command, data)
    return text or _unknown(data)


def _unknown(data: bytes) -> str:
    return f"unknown command {data[0]:02X}h: {data[1:].hex(' ')}"


def _request(command: LssCommand, data: bytes) -> str | None:
    number = lss.first_number(data)
    if command in _NUMBERS:
        return f"{_NUMBERS[command]} 0x{number:X}"
    match command:
        case LssCommand.SWITCH_GLOBAL:
            configuring = data[1] == lss.CONFIGURATION
            return f"all to {'configuration' if configuring else 'waiting'} state"
        case LssCommand.FASTSCAN:
            return _fastscan(number, data[5], data[6])
        case LssCommand.CONFIGURE_NODE_ID:
            return f"set node-id {data[1]}"
        case LssCommand.CONFIGURE_BIT_TIMING:
            return f"set bit rate {_bit_rate(data[1], data[2])}"
        case LssCommand.ACTIVATE_BIT_TIMING:
            return f"activate bit rate after {number & 0xFFFF} ms"
    for first, verb in (
        (LssCommand.SWITCH_VENDOR, "select {} 0x{:X}"),
        (LssCommand.INQUIRE_VENDOR, "ask for {}"),
    ):
        if first <= command < first + len(_PARTS):
            return verb.format(_PARTS[command - first], number)
    return _PLAIN.get(command)


def _bit_rate(table: int, index: int) -> str:
    if table == 0 and index == lss.AUTOMATIC_BIT_RATE:
        return "automatic"
    if table == 0 and index in _BIT_RATES:
        return f"{_BIT_RATES[index]} kbit/s"
    return f"entry {index} of table {table}"


def _fastscan(number: int, bit: int, part: int) -> str:
    if bit == lss.START_OF_SCAN:
        return "fastscan: who has no node-id"
    name = _PARTS[part] if part < len(_PARTS) else f"part {part}"
    return f"fastscan: {name} 0x{number:X} down to bit {bit}"


def _answer(command: LssCommand, data: bytes) -> str | None:
    if command in _CONFIGURED:
        what = _CONFIGURED[command]
        if not data[1]:
            return f"{what} done"
        return f"{what} refused: error {data[1]}, {data[2]}"
    if command is LssCommand.INQUIRE_NODE_ID:
        node_id = data[1]
        return f"node-id is {'not set' if node_id == lss.UNCONFIGURED else node_id}"
    place = command - LssCommand.INQUIRE_VENDOR
    if 0 <= place < len(_PARTS):
        return f"{_PARTS[place]} is 0x{lss.first_number(data):X}"
    return _ANSWERS.get(command)
