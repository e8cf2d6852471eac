"""Layer setting services in words (CiA 305)."""

from __future__ import annotations

from typing import Final

_BIT_RATES: Final = (1000, 800, 500, 250, 125, None, 50, 20, 10)
_AUTOMATIC: Final = 9
_PARTS: Final = ("vendor", "product", "revision", "serial number")
_SELECT: Final = 0x40
_INQUIRE: Final = 0x5A
_FASTSCAN_CHECK: Final = 0x80
"""The bit number with which fastscan begins."""


def lss_words(data: bytes, *, request: bool) -> str:
    """What a message of the master (`request`), or of a slave, says."""
    if len(data) != 8:
        return f"no message: {data.hex(' ') or 'no data'}"
    text = _request(data) if request else _answer(data)
    return text or f"unknown command {data[0]:02X}h: {data[1:].hex(' ')}"


def _number(data: bytes) -> int:
    return int.from_bytes(data[1:5], "little")


def _request(data: bytes) -> str | None:
    command = data[0]
    if command == 0x04:
        return f"all to {'configuration' if data[1] == 1 else 'waiting'} state"
    if _SELECT <= command < _SELECT + 4:
        return f"select {_PARTS[command - _SELECT]} 0x{_number(data):X}"
    if _INQUIRE <= command < _INQUIRE + 4:
        return f"ask for {_PARTS[command - _INQUIRE]}"
    if command == 0x51:
        return _fastscan(data)
    if command == 0x13:
        return f"set bit rate {_bit_rate(data[1], data[2])}"
    if command == 0x15:
        return f"activate bit rate after {int.from_bytes(data[1:3], 'little')} ms"
    if command == 0x11:
        return f"set node-id {data[1]}"
    return {
        0x17: "store configuration",
        0x5E: "ask for node-id",
        0x4C: "who has no node-id",
    }.get(command)


def _bit_rate(table: int, index: int) -> str:
    if table == 0 and index == _AUTOMATIC:
        return "automatic"
    if table == 0 and index < len(_BIT_RATES) and _BIT_RATES[index]:
        return f"{_BIT_RATES[index]} kbit/s"
    return f"entry {index} of table {table}"


def _fastscan(data: bytes) -> str:
    bit, part = data[5], data[6]
    if bit == _FASTSCAN_CHECK:
        return "fastscan: who has no node-id"
    name = _PARTS[part] if part < len(_PARTS) else f"part {part}"
    return f"fastscan: {name} 0x{_number(data):X} down to bit {bit}"


def _answer(data: bytes) -> str | None:
    command = data[0]
    if _INQUIRE <= command < _INQUIRE + 4:
        return f"{_PARTS[command - _INQUIRE]} is 0x{_number(data):X}"
    if command == 0x5E:
        return f"node-id is {'not set' if data[1] == 0xFF else data[1]}"
    if command in (0x11, 0x13, 0x17):
        what = {0x11: "node-id", 0x13: "bit rate", 0x17: "storing"}[command]
        if not data[1]:
            return f"{what} done"
        return f"{what} refused: error {data[1]}, {data[2]}"
    return {0x44: "selected", 0x4F: "fastscan: here", 0x50: "no node-id here"}.get(
        command
    )
