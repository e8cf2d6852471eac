"""The CAN buses of a system: decoded frames, nodes and their states, bus load, sending."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol

from rtgen.runtime.canopen.bus.arbitration import frame_bits
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, command_frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.timing.traffic import BusFrame
from rtgen.tools.running.bus_access import (
    MAX_CYCLIC_FRAMES,
    MIN_PERIOD,
    CyclicFramesError,
    RealBusError,
)
from rtgen.ui.errors import BAD_VALUE, CALL_FAILED, IMPOSSIBLE, UNKNOWN, CommandError
from rtgen.ui.protocol import ui

if TYPE_CHECKING:
    from rtgen.ui.bus_description import BusDescriber

COMMANDS: Final = {
    "start": NmtCommand.START,
    "stop": NmtCommand.STOP,
    "pre-operational": NmtCommand.ENTER_PRE_OPERATIONAL,
    "reset-node": NmtCommand.RESET_NODE,
    "reset-communication": NmtCommand.RESET_COMMUNICATION,
}
_WINDOW: Final = 1.0
"""The time over which the load is measured [s]."""


@dataclass
class _Bus:
    describer: BusDescriber
    state: ui.Bus
    window: float = 0.0
    bits: int = 0
    frames: int = 0


DescriberOf = Callable[[str, str], "BusDescriber"]
"""Describes a bus by the names of its channel and its network, which may be empty."""


class SeenBuses:
    """The buses whose frames a run reports. `publish` sends an event to pages.

    `settings` are the values of the parameters of each component of the run.
    """

    def __init__(
        self,
        describer: DescriberOf,
        settings: Callable[[], Iterable[Mapping[str, str]]],
        publish: Callable[[ui.Event], None],
    ) -> None:
        self._describer = describer
        self._settings = settings
        self._publish = publish
        self._buses: dict[str, _Bus] = {}

    @property
    def states(self) -> list[ui.Bus]:
        """Return the buses on which a frame was seen."""
        return [bus.state for bus in self._buses.values()]

    def on_frame(self, happening: BusFrame, now: float) -> None:
        """Process a frame received at a time [s]."""
        bus = self._bus(happening.bus)
        frame = Frame(
            happening.can_id, happening.data, happening.remote, happening.extended
        )
        decoded = bus.describer.frame(frame)
        decoded.time, decoded.bus = now, happening.bus
        self._publish(ui.Event.of_traffic([decoded]))
        if decoded.kind in ("heartbeat", "guarding") and not frame.remote:
            self._state(bus, decoded)
        self._measure(bus, frame, now)

    def _bus(self, name: str) -> _Bus:
        bus = self._buses.get(name)
        if bus is None:
            describer = self._describer(name, self._network(name))
            bus = self._buses[name] = _Bus(describer, describer.bus(name))
            self._publish(ui.Event.of_described_bus(bus.state))
        return bus

    def _network(self, channel: str) -> str:
        """Return the network that components on a channel state in their parameters."""
        for values in self._settings():
            if values.get("channel") == channel and values.get("network"):
                return values["network"]
        return ""

    def _state(self, bus: _Bus, frame: ui.Frame) -> None:
        """Update the NMT state of the node that sent a frame."""
        for node in bus.state.nodes:
            if node.node_id == frame.node_id:
                break
        else:
            node = ui.BusNode(node_id=frame.node_id, name=f"node {frame.node_id}")
            bus.state.nodes.append(node)
        if node.nmt_state != frame.text:
            node.nmt_state = frame.text
            self._publish(ui.Event.of_described_bus(bus.state))

    def _measure(self, bus: _Bus, frame: Frame, now: float) -> None:
        bus.bits += frame_bits(frame)
        bus.frames += 1
        passed = now - bus.window
        if passed < _WINDOW:
            return
        rate = bus.state.bit_rate
        load = ui.BusLoad(
            bus=bus.state.name,
            time=now,
            load=bus.bits / rate / passed if rate else 0.0,
            frames=round(bus.frames / passed),
        )
        bus.window, bus.bits, bus.frames = now, 0, 0
        self._publish(ui.Event.of_carried(load))


class Access(Protocol):
    """Who sends frames and transfers objects, see `running.bus_access.BusAccess`."""

    def send(self, bus: str, frame: Frame, period: float) -> None: ...

    def read(self, bus: str, node: int, number: tuple[int, int]) -> bytes: ...

    def write(
        self, bus: str, node: int, number: tuple[int, int], octets: bytes
    ) -> None: ...


class Buses(SeenBuses):
    """The buses of a run, with the commands of pages for them; see `SeenBuses`."""

    def __init__(
        self,
        describer: DescriberOf,
        settings: Callable[[], Iterable[Mapping[str, str]]],
        publish: Callable[[ui.Event], None],
        access: Access,
    ) -> None:
        super().__init__(describer, settings, publish)
        self.access = access
        self.open()

    def open(self) -> None:
        """Show the described buses of components, before the first frame."""
        for values in self._settings():
            if values.get("channel") and values.get("network"):
                self._bus(values["channel"])

    def send(self, command: ui.SendFrame) -> None:
        """Send a frame once, or from now on with a period; a period 0 ends that."""
        self._existing_bus(command.bus)
        if command.period and not command.period >= MIN_PERIOD:
            raise CommandError(BAD_VALUE, f"a period of {command.period:g} s")
        with _explained():
            frame = Frame(
                command.can_id, command.data, command.remote, command.extended
            )
            self.access.send(command.bus, frame, command.period)

    def manage(self, command: ui.NmtCommand) -> None:
        """Send an NMT command to a node or to all nodes."""
        if command.command not in COMMANDS:
            choices = ", ".join(COMMANDS)
            message = f"{command.command!r} is not an NMT command; known: {choices}"
            raise CommandError(UNKNOWN, message)
        if command.node_id > 127:
            raise CommandError(BAD_VALUE, f"{command.node_id} is not a node-id")
        self._existing_bus(command.bus)
        frame = command_frame(COMMANDS[command.command], command.node_id)
        with _explained():
            self.access.send(command.bus, frame, 0.0)

    def read(self, access: ui.SdoAccess) -> tuple[str, bytes]:
        """Read an object of a node; return its value as text, and its octets."""
        bus, number = self._existing_bus(access.bus), _number(access)
        with _explained():
            octets = self.access.read(access.bus, _node(access.node_id), number)
        return bus.describer.text(access.node_id, number, octets), octets

    def write(self, access: ui.SdoAccess) -> None:
        """Write an object of a node."""
        bus, number = self._existing_bus(access.bus), _number(access)
        octets = bus.describer.octets(access.node_id, number, access.text)
        with _explained():
            self.access.write(access.bus, _node(access.node_id), number, octets)

    def objects(self, address: ui.NodeAddress) -> list[ui.ObjectEntry]:
        """Return the object dictionary of a node."""
        return [*self._existing_bus(address.bus).describer.objects(address.node_id)]

    def _existing_bus(self, name: str) -> _Bus:
        if name not in self._buses:
            names = ", ".join(self._buses) or "none"
            raise CommandError(UNKNOWN, f"there is no bus {name!r}; known: {names}")
        return self._buses[name]


@contextmanager
def _explained() -> Iterator[None]:
    """Raise CommandError for the errors of an access."""
    try:
        yield
    except RealBusError as error:
        hint = "`rtgen can send` and `rtgen can sdo` reach a real one"
        message = "pages send on simulated buses only"
        raise CommandError(IMPOSSIBLE, message, hint) from error
    except CyclicFramesError as error:
        message = f"{MAX_CYCLIC_FRAMES} cyclic frames are sent already"
        raise CommandError(BAD_VALUE, message) from error
    except (SdoAbort, LinkError, MediumError) as error:
        raise CommandError(CALL_FAILED, str(error)) from error
    except ValueError as error:
        raise CommandError(BAD_VALUE, str(error)) from error


def _number(access: ui.SdoAccess) -> tuple[int, int]:
    if access.index > 0xFFFF or access.subindex > 0xFF:
        raise CommandError(
            BAD_VALUE, f"{access.index:X}:{access.subindex} is not an object"
        )
    return access.index, access.subindex


def _node(node_id: int) -> int:
    if not 1 <= node_id <= 127:
        raise CommandError(BAD_VALUE, f"{node_id} is not a node-id")
    return node_id
