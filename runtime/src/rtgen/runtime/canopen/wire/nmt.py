"""NMT slave state machine (CiA 301, 7.2.8 and 7.3.2), and its mapping to RTC states.

Figure and transition numbers are those of the published description of RTC-CANopen: figure 110
merges the two state machines, figure 111 makes the meaning of "stop" depend on a return code.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum, auto
from typing import Final

import msgspec

from rtgen.runtime.canopen.wire.frames import ERROR_CONTROL, NMT, Frame, checked_node_id


class NmtCommand(IntEnum):
    """Command specifiers (CiA 301, 7.2.8.3.1)."""

    START = 0x01
    STOP = 0x02
    ENTER_PRE_OPERATIONAL = 0x80
    RESET_NODE = 0x81
    RESET_COMMUNICATION = 0x82


class NmtState(IntEnum):
    """States as encoded in heartbeats; INITIALISING is the value of the boot-up message."""

    INITIALISING = 0x00
    STOPPED = 0x04
    OPERATIONAL = 0x05
    PRE_OPERATIONAL = 0x7F


class Service(IntEnum):
    """Communication services of a node."""

    PDO = auto()
    SDO = auto()
    SYNC = auto()
    TIME = auto()
    EMERGENCY = auto()
    NMT = auto()


_ALL: Final = frozenset(Service)
SERVICES: Final = {
    NmtState.INITIALISING: frozenset[Service](),
    NmtState.PRE_OPERATIONAL: _ALL - {Service.PDO},
    NmtState.OPERATIONAL: _ALL,
    NmtState.STOPPED: frozenset({Service.NMT}),
}
"""The services available in each state (CiA 301, table 38); NMT includes error control."""


def command_frame(command: NmtCommand, node_id: int = 0) -> Frame:
    """Return an NMT command to a node, or to all (0)."""
    return Frame(NMT, bytes((command, checked_node_id(node_id) if node_id else 0)))


def heartbeat_frame(node_id: int, state: NmtState) -> Frame:
    """Return a heartbeat, or the boot-up message for INITIALISING (CiA 301, 7.2.8.3.2 and .3)."""
    return Frame(ERROR_CONTROL + checked_node_id(node_id), bytes((state,)))


def decode_command(frame: Frame) -> tuple[NmtCommand, int] | None:
    """Return the command in a frame and its node-id (0: all); None for any other frame."""
    if frame.can_id != NMT or frame.extended or frame.remote or len(frame.data) != 2:
        return None
    try:
        return NmtCommand(frame.data[0]), frame.data[1]
    except ValueError:
        return None


class Transition(msgspec.Struct, frozen=True, gc=False):
    """A change of a slave's state; `command` is None if the node changed by itself."""

    before: NmtState
    after: NmtState
    command: NmtCommand | None


class NmtSlave:
    """The slave's state machine, starting in INITIALISING.

    Its owner performs the actions of a reset, and then calls `boot`. `self_start` continues to
    OPERATIONAL without a command (CiA 301, 7.3.2.1). With `merged_stop` the effect of a stop is
    decided by `stopping`, called when the command arrives: True is a normal end, in
    PRE_OPERATIONAL; False is a failure, in STOPPED, which then is only left by a reset.
    """

    def __init__(
        self,
        node_id: int,
        *,
        self_start: bool = False,
        merged_stop: bool = False,
        stopping: Callable[[], bool] = lambda: True,
    ) -> None:
        self.node_id = checked_node_id(node_id)
        self.state = NmtState.INITIALISING
        self.reset: NmtCommand = NmtCommand.RESET_NODE
        """The reset to be performed in INITIALISING; reset node includes reset communication."""
        self._self_start = self_start
        self._merged_stop = merged_stop
        self._stopping = stopping

    def allows(self, service: Service) -> bool:
        """Return whether the service is available in the current state."""
        return service in SERVICES[self.state]

    def boot(self) -> Frame:
        """Leave INITIALISING; return the boot-up message. Raises RuntimeError in other states."""
        if self.state is not NmtState.INITIALISING:
            raise RuntimeError(f"boot-up in {self.state.name}")
        self.state = (
            NmtState.OPERATIONAL if self._self_start else NmtState.PRE_OPERATIONAL
        )
        return heartbeat_frame(self.node_id, NmtState.INITIALISING)

    def fail(self) -> Transition | None:
        """Enter STOPPED after a failure (transitions 5, 6, 9); None if already there."""
        return self._go(NmtState.STOPPED, None)

    def go(self, state: NmtState) -> Transition | None:
        """Enter a state without a command; None if already there."""
        return self._go(state, None)

    def receive(self, frame: Frame) -> Transition | None:
        """Process a command; None if it is for another node, or changes nothing.

        A reset is a transition from every state; in INITIALISING commands are ignored.
        """
        decoded = decode_command(frame)
        if decoded is None or decoded[1] not in (0, self.node_id):
            return None
        command = decoded[0]
        if self.state is NmtState.INITIALISING:
            return None
        if command in (NmtCommand.RESET_NODE, NmtCommand.RESET_COMMUNICATION):
            self.reset = command
            return self._go(NmtState.INITIALISING, command)
        if self._merged_stop and self.state is NmtState.STOPPED:
            return None
        return self._go(self._target(command), command)

    def _target(self, command: NmtCommand) -> NmtState:
        if command is NmtCommand.START:
            return NmtState.OPERATIONAL
        if command is NmtCommand.STOP and not (self._merged_stop and self._stopping()):
            return NmtState.STOPPED
        return NmtState.PRE_OPERATIONAL

    def _go(self, state: NmtState, command: NmtCommand | None) -> Transition | None:
        before, self.state = self.state, state
        return None if before is state else Transition(before, state, command)
