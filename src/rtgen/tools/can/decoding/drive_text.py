"""Text for the words and modes of drives (CiA 402: 6040h, 6041h, 6060h and 6061h of each axis)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

PROFILE: Final = 402
"""Device profile number: the low word of a drive's device type (1000h)."""

_AXIS: Final = 0x800
"""Distance between the indices of two axes."""
_STATES: Final = (
    (0x4F, 0x00, "not ready to switch on"),
    (0x4F, 0x40, "switch on disabled"),
    (0x6F, 0x21, "ready to switch on"),
    (0x6F, 0x23, "switched on"),
    (0x6F, 0x27, "operation enabled"),
    (0x6F, 0x07, "quick stop active"),
    (0x4F, 0x0F, "fault reaction active"),
    (0x4F, 0x08, "fault"),
)
"""Mask, value and name of each state."""
_COMMANDS: Final = (
    (0x80, 0x80, "fault reset"),
    (0x82, 0x00, "disable voltage"),
    (0x86, 0x02, "quick stop"),
    (0x87, 0x06, "shutdown"),
    (0x8F, 0x07, "switch on"),
    (0x8F, 0x0F, "enable operation"),
)
_FREQUENT_BITS: Final = {0x6041: 0x16FF, 0x6040: 0x019F}
_MODE_OBJECTS: Final = (0x6060, 0x6061)
_MODES: Final = {
    0: "no mode",
    1: "profile position",
    2: "velocity",
    3: "profile velocity",
    4: "profile torque",
    6: "homing",
    7: "interpolated position",
    8: "cyclic synchronous position",
    9: "cyclic synchronous velocity",
    10: "cyclic synchronous torque",
}
"""Modes of operation (CiA 402-2, 6060h)."""


def drive_words(index: int) -> Callable[[int], str] | None:
    """Return the function that describes values of this object; None for another object."""
    if not 0x6000 <= index < 0xA000:
        return None
    place = 0x6000 + (index - 0x6000) % _AXIS
    if place in _MODE_OBJECTS:
        return mode_words
    return {0x6041: state_words, 0x6040: command_words}.get(place)


def value_names(index: int) -> dict[int, str]:
    """Return the names of frequent values of this object of a drive; empty for another object.

    Of a statusword and a controlword they are the words for values without bits of the modes of
    operation and of manufacturers, other than bit 12 and bit 4 (new set-point).
    """
    if not 0x6000 <= index < 0xA000:
        return {}
    place = 0x6000 + (index - 0x6000) % _AXIS
    if place in _MODE_OBJECTS:
        return _MODES
    words = drive_words(index)
    bits = _FREQUENT_BITS.get(place)
    if words is None or bits is None:
        return {}
    named = ((value, words(value)) for value in range(bits + 1) if not value & ~bits)
    return {value: text for value, text in named if text}


def state_words(statusword: int) -> str:
    """Return the state of the drive's state machine, and the bits "warning", "target reached"."""
    words = [_named(_STATES, statusword)]
    words += ["warning"] * bool(statusword & 1 << 7)
    words += ["target reached"] * bool(statusword & 1 << 10)
    return ", ".join(filter(None, words))


def command_words(controlword: int) -> str:
    """Return the command in a controlword, with the bit "halt"."""
    words = [_named(_COMMANDS, controlword), "halt" if controlword & 1 << 8 else ""]
    return ", ".join(filter(None, words))


def mode_words(mode: int) -> str:
    """Return the name of a mode of operation, empty for one of a manufacturer."""
    return _MODES.get(mode, "")


def _named(table: tuple[tuple[int, int, str], ...], word: int) -> str:
    return next((name for mask, value, name in table if word & mask == value), "")
