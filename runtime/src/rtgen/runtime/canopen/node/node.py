"""A CANopen slave (CiA 301) with all its services, for use by an application.

It has no I/O and no clock. The application uses the object dictionary, hooks and `NodeEvents`.
"""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.description import ObjectValue
from rtgen.runtime.canopen.node.device_pdos import IsEvent
from rtgen.runtime.canopen.node.object_dictionary import ReadHook, WriteHook
from rtgen.runtime.canopen.node.station import DeviceStation
from rtgen.runtime.canopen.wire.emergency import ErrorRegister
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import (
    NmtCommand,
    NmtState,
    Service,
    command_frame,
)

USER_SOFTWARE: Final = 0x6200


class DeviceNode(DeviceStation):
    """A slave and the operations of its application; `station` has its services.

    Changes from outside the link take effect, and are sent, by `flush`.
    """

    def get(self, index: int, subindex: int = 0) -> ObjectValue:
        """Return the value of an object. Raises KeyError for an unknown object."""
        return self.dictionary.get((index, subindex))

    def set(self, index: int, subindex: int, value: ObjectValue) -> None:
        """Set an object; `flush` sends the TPDOs that map it.

        Raises KeyError for an unknown object, ObjectValueError for an invalid value.
        """
        self.dictionary.set((index, subindex), value)

    def on_write(self, index: int, subindex: int, hook: WriteHook) -> None:
        """Call the hook before a value received by SDO or RPDO is stored."""
        self.dictionary.on_write((index, subindex), hook)

    def on_read(self, index: int, subindex: int, hook: ReadHook) -> None:
        """Get the value of an object from the hook whenever it is read or sent."""
        self.dictionary.on_read((index, subindex), hook)

    def on_change(self, index: int, subindex: int, is_event: IsEvent) -> None:
        """Let `is_event` decide whether a change of an object triggers its TPDOs."""
        self.pdos.is_event((index, subindex), is_event)

    def trigger(self, index: int, subindex: int = 0) -> None:
        """Trigger an object: `flush` sends the TPDOs that map it, even if it is unchanged."""
        self.pdos.trigger((index, subindex))

    def add_error(
        self, code: int, additional: bytes = b"", register: ErrorRegister | None = None
    ) -> None:
        """Activate an error, which is sent once by EMCY (CiA 301, 7.2.7)."""
        self.errors.add(code, additional, register)

    def remove_error(self, code: int, additional: bytes | None = None) -> None:
        """Clear an error, or all errors of a code if no additional octets are given."""
        self.errors.remove(code, additional)

    def flush(self, now: int) -> list[Frame]:
        """Return the frames to send after changes."""
        self._now = now
        return self._take_frames()

    def boot(self, now: int) -> list[Frame]:
        """Leave INITIALISING: boot-up, then PRE_OPERATIONAL. No effect without a node-id."""
        self._now = now
        self._boot()
        return self._take_frames()

    def go(self, state: NmtState, now: int) -> list[Frame]:
        """Change the state on behalf of the application."""
        self._now = now
        if self._nmt is not None and self.state is not NmtState.INITIALISING:
            self._on_transition(self._nmt.go(state))
        return self._take_frames()

    def reset(
        self, now: int, command: NmtCommand = NmtCommand.RESET_NODE
    ) -> list[Frame]:
        """Reset the node on behalf of the application."""
        if self._nmt is None:
            return []
        return list(self.receive(command_frame(command, self.node_id), now))

    def fail(
        self, now: int, code: int = USER_SOFTWARE, additional: bytes = b""
    ) -> list[Frame]:
        """Report a failure of the application: EMCY, then STOPPED; heartbeats continue."""
        self._now = now
        if self._nmt is None:
            return []
        self.errors.add(code, additional)
        initialising = self.state is NmtState.INITIALISING
        if initialising or self._allows(Service.EMERGENCY):
            self._out += self.errors.take(now, at_once=True)
        self._on_transition(self._nmt.fail())
        if initialising:
            self._error_control.restart_heartbeat(now)
        return self._take_frames()
