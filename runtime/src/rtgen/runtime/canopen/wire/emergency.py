"""Emergency messages (CiA 301, 7.2.7; error codes: table 26; error register: 1001h)."""

from __future__ import annotations

import re
from enum import IntFlag
from typing import Final

import msgspec

from rtgen.runtime.canopen.wire.frames import (
    EMERGENCY,
    MAX_DATA,
    Frame,
    checked_node_id,
)

PDO_TOO_SHORT: Final = 0x8210
PDO_TOO_LONG: Final = 0x8220
RPDO_TIMEOUT: Final = 0x8250
HEARTBEAT_LOST: Final = 0x8130


class ErrorRegister(IntFlag):
    """Bits of the error register (1001h)."""

    GENERIC = 1
    CURRENT = 2
    VOLTAGE = 4
    TEMPERATURE = 8
    COMMUNICATION = 16
    PROFILE = 32
    RESERVED = 64
    MANUFACTURER = 128


_EXACT: Final = {
    0x8110: "CAN overrun",
    0x8120: "error passive",
    HEARTBEAT_LOST: "heartbeat or guarding lost",
    0x8140: "recovered from bus-off",
    0x8150: "identifier collision",
    PDO_TOO_SHORT: "PDO too short",
    PDO_TOO_LONG: "PDO too long",
    0x8230: "destination of a multiplexed PDO not available",
    0x8240: "length of SYNC",
    RPDO_TIMEOUT: "RPDO overdue",
}
_CLASSES: Final = {
    0x00: "no error",
    0x10: "generic error",
    0x20: "current",
    0x21: "current, input side",
    0x22: "current inside the device",
    0x23: "current, output side",
    0x30: "voltage",
    0x31: "mains voltage",
    0x32: "voltage inside the device",
    0x33: "output voltage",
    0x40: "temperature",
    0x41: "ambient temperature",
    0x42: "device temperature",
    0x50: "hardware",
    0x60: "software",
    0x61: "internal software",
    0x62: "user software",
    0x63: "data set",
    0x70: "additional modules",
    0x80: "monitoring",
    0x81: "communication",
    0x82: "protocol",
    0x90: "external error",
    0xF0: "additional functions",
    0xFF: "device specific",
}


def code_text(code: int) -> str:
    """Return the meaning of an error code; that of its class if CiA 301 does not define it."""
    if code in _EXACT:
        return _EXACT[code]
    high = code >> 8
    return _CLASSES.get(high) or _CLASSES.get(high & 0xF0) or "unknown error"


def known_codes() -> dict[int, str]:
    """Return the meanings of the codes that CiA 301 defines; of a class, of its first code."""
    classes = {high << 8: text for high, text in _CLASSES.items()}
    return dict(sorted({**classes, **_EXACT}.items()))


class Emergency(msgspec.Struct, frozen=True, gc=False):
    """An emergency message; code 0000h: errors have been cleared. `additional` has 5 octets."""

    code: int
    register: ErrorRegister
    additional: bytes = bytes(5)

    @property
    def cleared(self) -> bool:
        """Whether the message reports that an error, or all errors, have been cleared."""
        return self.code >> 8 == 0

    def frame(self, node_id: int) -> Frame:
        """Return the frame sent by a node. Raises ValueError for more than 5 additional octets."""
        if len(self.additional) > 5:
            raise ValueError(f"{len(self.additional)} octets; there are up to 5")
        head = self.code.to_bytes(2, "little") + bytes((self.register,))
        return Frame(
            EMERGENCY + checked_node_id(node_id), head + self.additional.ljust(5, b"\0")
        )

    def __str__(self) -> str:
        text = f"{self.code:04X}h {code_text(self.code)}"
        bits = [bit.name.lower() for bit in self.register if bit.name]
        return f"{text} ({', '.join(bits)})" if bits else text


DEFAULT_STOPS: Final = "xxxx,-8110,-8120,-8140,-82xx"
"""All errors except those of single frames: CAN overrun, wrong PDO length, late PDO."""
_PATTERN: Final = re.compile("(-?)([0-9A-Fa-fxX]{4})")


class EmergencyPolicy:
    """Decides which emergency messages stop a component; others are only reported.

    `patterns` is a comma-separated list of codes of four hexadecimal digits, `x` for any digit.
    The last matching pattern decides; one with `-` only reports, as does no match. Raises
    ValueError for a malformed pattern.
    """

    def __init__(self, patterns: str) -> None:
        self._rules: list[tuple[bool, re.Pattern[str]]] = []
        for text in patterns.split(","):
            match = _PATTERN.fullmatch(text.strip())
            if match is None:
                raise ValueError(
                    f"{text.strip()!r} is not a pattern of emergency codes, such as 23xx or -82xx"
                )
            digits = re.sub("[xX]", ".", match[2].upper())
            self._rules.append((not match[1], re.compile(digits)))

    def stops(self, emergency: Emergency) -> bool:
        """Return whether an emergency message stops the component."""
        code = f"{emergency.code:04X}"
        decided = [stops for stops, pattern in self._rules if pattern.fullmatch(code)]
        return bool(decided) and decided[-1] and not emergency.cleared


def emergency_in(frame: Frame) -> Emergency | None:
    """Return the message in a frame with the identifier of emergencies; None without one."""
    data = frame.data
    if frame.remote or len(data) != MAX_DATA:
        return None
    code = int.from_bytes(data[:2], "little")
    return Emergency(code, ErrorRegister(data[2]), data[3:])
