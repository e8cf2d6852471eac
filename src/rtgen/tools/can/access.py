"""Which CAN bus a command uses, and the descriptions of its nodes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime.canopen.bus.python_can import BusAddress, Option
from rtgen.tools.can.decoding.node_index import NodeIndex, read_node_index
from rtgen.tools.can.project_bus import listed, project_buses
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal

CHANNEL = "can0"
"""Default channel, the same as that of CANopen components."""


@dataclass(frozen=True, slots=True)
class BusAccess:
    """A python-can bus according to the options; `bitrate` in bit/s. None: python-can's default."""

    interface: str | None = None
    channel: str | None = None
    bitrate: int | None = None
    further: dict[str, Option] = field(default_factory=dict)

    def address(self) -> BusAddress:
        """Return the bus's address, falling back to python-can's configuration.

        Raises Refusal if no bus is named, ToolError if the configuration is not valid.
        """
        arguments = dict(self.further)
        interface, channel, bitrate = self.interface, self.channel, self.bitrate
        if interface is None:
            config = _configuration()
            interface = config.pop("interface")
            channel = channel or config.pop("channel", None)
            bitrate = bitrate or config.pop("bitrate", None)
            plain = {k: v for k, v in config.items() if isinstance(v, Option)}
            arguments = plain | arguments
        channel = CHANNEL if channel is None else str(channel)
        options = tuple(sorted(arguments.items()))
        return BusAddress(interface, channel, bitrate or 0, options)

    def on(self, node_index: NodeIndex) -> BusAccess:
        """Return a copy with the bit rate of the bus file, unless an option sets one."""
        if self.bitrate is not None or node_index.bus is None:
            return self
        return replace(self, bitrate=1000 * node_index.bus.bit_rate)


def _configuration() -> dict[str, Any]:
    """Return python-can's configuration: of the environment, or of a file."""
    from configparser import Error as MalformedFile

    from can import CanInterfaceNotImplementedError
    from can.util import load_config

    try:
        configuration: dict[str, Any] = dict(load_config())
    except CanInterfaceNotImplementedError as error:
        if "None" in str(error):
            raise Refusal(
                "which bus? Give --interface, for instance --interface socketcan "
                "--channel can0, or --interface socketcand for rtgen can hub"
            ) from None
        raise _misconfigured(error) from error
    except (ValueError, TypeError, AttributeError, MalformedFile) as error:
        raise _misconfigured(error) from error
    if not isinstance(configuration.get("bitrate") or 0, int):
        raise _misconfigured(f"{configuration['bitrate']!r} is not a bit rate")
    return configuration


def _misconfigured(reason: object) -> ToolError:
    return ToolError(
        f"python-can's configuration is not valid: {' '.join(str(reason).split())}",
        hint="it is in CAN_INTERFACE, CAN_CHANNEL, CAN_BITRATE and CAN_CONFIG, or in ~/.canrc",
    )


@dataclass(frozen=True, slots=True)
class NodeFiles:
    """The files with descriptions of nodes: a bus file, and files with node-ids.

    Without either, they are those of the project's bus.
    """

    bus_file: Path | None = None
    descriptions: tuple[tuple[int | None, Path], ...] = ()

    def read(self, console: Console, *, names: bool = True) -> NodeIndex:
        """Return the nodes of the files by id and name. Raises InputError, ReportedError.

        `names`: whether the command shows nodes, so that it says why they have no names.
        """
        file = self.bus_file
        if file is None and not self.descriptions:
            buses = project_buses(console)
            if len(buses) > 1 and names:
                console.say(f"nodes have no names: --bus names one of {listed(buses)}")
            file = buses[0] if len(buses) == 1 else None
        return read_node_index(file, self.descriptions)
