"""CiA 402 for both ends of the bus: states, commands, bits, and how a master enables a drive.

Source: CiA 402-2, drive profile, finite state automaton and modes of operation.
"""

from __future__ import annotations

from enum import Enum, IntEnum, IntFlag
from typing import Final


class PowerState(Enum):
    """States of the drive state machine (CiA 402): mask and value of the statusword."""

    NOT_READY_TO_SWITCH_ON = 0x4F, 0x00
    SWITCH_ON_DISABLED = 0x4F, 0x40
    READY_TO_SWITCH_ON = 0x6F, 0x21
    SWITCHED_ON = 0x6F, 0x23
    OPERATION_ENABLED = 0x6F, 0x27
    QUICK_STOP_ACTIVE = 0x6F, 0x07
    FAULT_REACTION_ACTIVE = 0x4F, 0x0F
    FAULT = 0x4F, 0x08

    @property
    def bits(self) -> int:
        """The bits of a statusword in this state."""
        bits: int = self.value[1]
        return bits


def state_of(statusword: int) -> PowerState | None:
    """Return the state in a statusword; None for an undefined combination of bits."""
    for state in PowerState:
        mask, value = state.value
        if statusword & mask == value:
            return state
    return None


class Status(IntFlag):
    """Bits of the statusword besides those of the state; 12 and 13 depend on the mode."""

    VOLTAGE_ENABLED = 1 << 4
    WARNING = 1 << 7
    REMOTE = 1 << 9
    TARGET_REACHED = 1 << 10
    INTERNAL_LIMIT = 1 << 11
    SET_POINT_ACKNOWLEDGE = 1 << 12
    SPEED_ZERO = 1 << 12
    HOMING_ATTAINED = 1 << 12
    FOLLOWS = 1 << 12
    FOLLOWING_ERROR = 1 << 13
    HOMING_ERROR = 1 << 13


class Control(IntFlag):
    """Bits of the controlword besides those of the commands; 4 to 6 depend on the mode."""

    NEW_SET_POINT = 1 << 4
    HOMING_START = 1 << 4
    CHANGE_AT_ONCE = 1 << 5
    RELATIVE = 1 << 6
    FAULT_RESET = 1 << 7
    HALT = 1 << 8


class Command(IntEnum):
    """The commands of the automaton, each with its controlword."""

    DISABLE_VOLTAGE = 0x00
    QUICK_STOP = 0x02
    SHUTDOWN = 0x06
    SWITCH_ON = 0x07
    ENABLE_OPERATION = 0x0F


_COMMANDS: Final = (
    (0x82, Command.DISABLE_VOLTAGE),
    (0x86, Command.QUICK_STOP),
    (0x87, Command.SHUTDOWN),
    (0x8F, Command.SWITCH_ON),
    (0x8F, Command.ENABLE_OPERATION),
)


def command_of(controlword: int) -> Command | None:
    """Return the command in a controlword; None if the fault reset bit is set."""
    for mask, command in _COMMANDS:
        if controlword & mask == command & mask:
            return command
    return None


class Mode(IntEnum):
    """Modes of operation; 6502h has bit n - 1 for mode n, the negative ones are EPOS's own."""

    NONE = 0
    PROFILE_POSITION = 1
    PROFILE_VELOCITY = 3
    PROFILE_TORQUE = 4
    HOMING = 6
    CYCLIC_SYNCHRONOUS_POSITION = 8
    EPOS_POSITION = -1
    EPOS_VELOCITY = -2
    EPOS_CURRENT = -3


class DriveMaster:
    """Switches a drive on, step by step, following its statusword."""

    _NEXT: Final = {
        PowerState.SWITCH_ON_DISABLED: Command.SHUTDOWN,
        PowerState.READY_TO_SWITCH_ON: Command.SWITCH_ON,
        PowerState.SWITCHED_ON: Command.ENABLE_OPERATION,
        PowerState.OPERATION_ENABLED: Command.ENABLE_OPERATION,
        # From these states, the transitions lead through "switch on disabled".
        PowerState.QUICK_STOP_ACTIVE: Command.DISABLE_VOLTAGE,
    }

    def __init__(self) -> None:
        self.state: PowerState | None = None
        """The drive's state by its last statusword; None before the first one."""
        self.controlword = int(Command.DISABLE_VOLTAGE)
        """The next controlword."""

    @property
    def enabled(self) -> bool:
        """Whether the drive follows its target."""
        return self.state is PowerState.OPERATION_ENABLED

    def forget(self) -> None:
        """Forget the state of a drive that is lost."""
        self.state = None
        self.controlword = int(Command.DISABLE_VOLTAGE)

    def take(self, statusword: int) -> None:
        """Evaluate a statusword of the drive."""
        state = self.state = state_of(statusword)
        if state is PowerState.FAULT:
            # A rising edge resets: the bit toggles until the fault is gone.
            self.controlword = ~self.controlword & Control.FAULT_RESET
        elif state is not None:
            self.controlword = int(self._NEXT.get(state, Command.DISABLE_VOLTAGE))
