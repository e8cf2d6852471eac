"""The state machine of CiA 402 on the side of the drive."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Final

from refnav.cia402 import Command, Control, PowerState, command_of

_S = PowerState

TRANSITIONS: Final = {
    0: (None, _S.NOT_READY_TO_SWITCH_ON),
    1: (_S.NOT_READY_TO_SWITCH_ON, _S.SWITCH_ON_DISABLED),
    2: (_S.SWITCH_ON_DISABLED, _S.READY_TO_SWITCH_ON),
    3: (_S.READY_TO_SWITCH_ON, _S.SWITCHED_ON),
    4: (_S.SWITCHED_ON, _S.OPERATION_ENABLED),
    5: (_S.OPERATION_ENABLED, _S.SWITCHED_ON),
    6: (_S.SWITCHED_ON, _S.READY_TO_SWITCH_ON),
    7: (_S.READY_TO_SWITCH_ON, _S.SWITCH_ON_DISABLED),
    8: (_S.OPERATION_ENABLED, _S.READY_TO_SWITCH_ON),
    9: (_S.OPERATION_ENABLED, _S.SWITCH_ON_DISABLED),
    10: (_S.SWITCHED_ON, _S.SWITCH_ON_DISABLED),
    11: (_S.OPERATION_ENABLED, _S.QUICK_STOP_ACTIVE),
    12: (_S.QUICK_STOP_ACTIVE, _S.SWITCH_ON_DISABLED),
    13: (None, _S.FAULT_REACTION_ACTIVE),
    14: (_S.FAULT_REACTION_ACTIVE, _S.FAULT),
    15: (_S.FAULT, _S.SWITCH_ON_DISABLED),
    16: (_S.QUICK_STOP_ACTIVE, _S.OPERATION_ENABLED),
}
"""The state before and after each transition; None for any, or for none before."""

_BY_COMMAND: Final = {
    (_S.SWITCH_ON_DISABLED, Command.SHUTDOWN): 2,
    (_S.READY_TO_SWITCH_ON, Command.SWITCH_ON): 3,
    (_S.READY_TO_SWITCH_ON, Command.ENABLE_OPERATION): 3,
    (_S.READY_TO_SWITCH_ON, Command.QUICK_STOP): 7,
    (_S.READY_TO_SWITCH_ON, Command.DISABLE_VOLTAGE): 7,
    (_S.SWITCHED_ON, Command.ENABLE_OPERATION): 4,
    (_S.SWITCHED_ON, Command.SHUTDOWN): 6,
    (_S.SWITCHED_ON, Command.QUICK_STOP): 10,
    (_S.SWITCHED_ON, Command.DISABLE_VOLTAGE): 10,
    (_S.OPERATION_ENABLED, Command.SWITCH_ON): 5,
    (_S.OPERATION_ENABLED, Command.SHUTDOWN): 8,
    (_S.OPERATION_ENABLED, Command.DISABLE_VOLTAGE): 9,
    (_S.OPERATION_ENABLED, Command.QUICK_STOP): 11,
    (_S.QUICK_STOP_ACTIVE, Command.DISABLE_VOLTAGE): 12,
    (_S.QUICK_STOP_ACTIVE, Command.ENABLE_OPERATION): 16,
}


class Braking(Enum):
    """How the drive brakes before it enters another state."""

    COAST = 0
    SLOW_DOWN = 1
    QUICK = 2
    CURRENT_LIMIT = 3
    VOLTAGE_LIMIT = 4


class PowerMachine:
    """State machine of a drive and its braking modes (CiA 402), without time.

    `taken` is called for every transition. The codes are those of 605Ah, 605Ch and 605Eh; without a
    605Bh, a shutdown lets the axis coast.
    """

    def __init__(self, taken: Callable[[int], None] = lambda number: None) -> None:
        self._taken = taken
        self.quick_stop_code = 2
        self.disable_code = 1
        self.fault_code = 2
        self.braking: Braking | None = None
        """How the drive brakes; None while it follows its target, or does nothing."""
        self._disabling = False
        self._reset = True
        self.state = PowerState.NOT_READY_TO_SWITCH_ON
        self._go(0)

    @property
    def powered(self) -> bool:
        """Whether the motor has torque."""
        state = self.state
        follows = state in (PowerState.OPERATION_ENABLED, PowerState.QUICK_STOP_ACTIVE)
        return follows or state is PowerState.FAULT_REACTION_ACTIVE

    def initialised(self) -> None:
        """Called after the drive's self-test."""
        self._go(1)

    def command(self, controlword: int, *, faultless: bool = True) -> None:
        """Obey a controlword; a fault is reset only if its cause has gone."""
        reset = bool(controlword & Control.FAULT_RESET)
        rising = reset and not self._reset
        self._reset = reset
        if self.state is PowerState.FAULT and rising and faultless:
            self._go(15)
        command = command_of(controlword)
        if command is None:
            return
        if self._disabling and command is Command.ENABLE_OPERATION:
            self._disabling = False
            self.braking = None
        while (number := _BY_COMMAND.get((self.state, command))) is not None:
            if number == 5 and self.disable_code == 1:
                self._disabling = True
                self.braking = Braking.SLOW_DOWN
                return
            if number == 16 and self.quick_stop_code < 5:
                return
            self._go(number)
            if number == 11:
                self._brake(self.quick_stop_code)

    def fault(self) -> None:
        """Enter the fault reaction: a powered drive brakes first, then stays in the fault state."""
        if self.state in (PowerState.FAULT_REACTION_ACTIVE, PowerState.FAULT):
            return
        powered = self.powered
        self._go(13)
        if powered:
            self._brake(self.fault_code)
        else:
            self._go(14)

    def at_rest(self) -> None:
        """Called when a braking axis has come to rest."""
        if self._disabling:
            self._go(5)
        elif self.state is PowerState.QUICK_STOP_ACTIVE and self.quick_stop_code < 5:
            self._go(12)
        elif self.state is PowerState.FAULT_REACTION_ACTIVE:
            self._go(14)

    def _brake(self, code: int) -> None:
        # 5 to 8 brake as 1 to 4, then hold the axis.
        self.braking = Braking(code if code < 5 else code - 4)
        if self.braking is Braking.COAST:
            self.at_rest()

    def _go(self, number: int) -> None:
        self._disabling = False
        self.braking = None
        self.state = TRANSITIONS[number][1]
        self._taken(number)
