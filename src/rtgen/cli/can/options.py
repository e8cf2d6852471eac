"""Options shared by the commands of `rtgen can`: which bus, and descriptions of its nodes."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import click

from rtgen.cli.can.decoding.node_index import NodeIndex, read_node_index
from rtgen.cli.common import FiniteRange, Refusal, WholeRange
from rtgen.diagnostics import ToolError
from rtgen.runtime.canopen.bus.python_can import BusAddress, Option, option

P = ParamSpec("P")
R = TypeVar("R")

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

    def on(self, known: NodeIndex) -> BusAccess:
        """Return a copy with the bit rate of the bus file, unless an option sets one."""
        if self.bitrate is not None or known.bus is None:
            return self
        return replace(self, bitrate=1000 * known.bus.bit_rate)


def _configuration() -> dict[str, Any]:
    """Return python-can's configuration: of the environment, or of a file."""
    from configparser import Error as MalformedFile

    from can import CanInterfaceNotImplementedError
    from can.util import load_config

    try:
        found: dict[str, Any] = dict(load_config())
    except CanInterfaceNotImplementedError as error:
        if "None" in str(error):
            raise Refusal(
                "which bus? Give --interface, for instance --interface socketcan "
                "--channel can0, or --interface socketcand for rtgen can hub"
            ) from None
        raise _misconfigured(error) from error
    except (ValueError, TypeError, AttributeError, MalformedFile) as error:
        raise _misconfigured(error) from error
    if not isinstance(found.get("bitrate") or 0, int):
        raise _misconfigured(f"{found['bitrate']!r} is not a bit rate")
    return found


def _misconfigured(reason: object) -> ToolError:
    return ToolError(
        f"python-can's configuration is not valid: {' '.join(str(reason).split())}",
        hint="it is in CAN_INTERFACE, CAN_CHANNEL, CAN_BITRATE and CAN_CONFIG, or in ~/.canrc",
    )


def with_bus(function: Callable[P, R]) -> Callable[..., R]:
    """Add --interface, --channel, --bitrate and --option; the function gets `access`."""

    @click.option(
        "--interface",
        metavar="NAME",
        help="python-can's interface: socketcan, socketcand, slcan, ...",
    )
    @click.option("--channel", metavar="NAME", help=f"Channel; default: {CHANNEL}.")
    @click.option(
        "--bitrate",
        type=WholeRange(min=1),
        metavar="N",
        help="Bit rate in bit/s; default: the interface's.",
    )
    @click.option(
        "--option",
        "further",
        multiple=True,
        metavar="KEY=VALUE",
        callback=_arguments,
        help="Additional argument of the interface, such as host=127.0.0.1.",
    )
    @functools.wraps(function)
    def wrapped(
        interface: str | None,
        channel: str | None,
        bitrate: int | None,
        further: dict[str, Option],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> R:
        access = BusAccess(interface, channel, bitrate, further)
        return function(*args, access=access, **kwargs)  # type: ignore[arg-type]

    return wrapped


@dataclass(frozen=True, slots=True)
class Described:
    """The files with descriptions of nodes; `known` reads them."""

    bus_file: Path | None = None
    descriptions: tuple[tuple[int | None, Path], ...] = ()

    def known(self) -> NodeIndex:
        """Read the files. Raises InputError."""
        return read_node_index(self.bus_file, self.descriptions)


def with_nodes(function: Callable[P, R]) -> Callable[..., R]:
    """Add --bus and --eds; the function gets `described`."""

    @click.option(
        "--bus",
        "bus_file",
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="Bus file (TOML) that describes the nodes.",
    )
    @click.option(
        "--eds",
        "descriptions",
        multiple=True,
        metavar="NODE-ID=FILE",
        callback=_descriptions,
        help="EDS or DCF of a node; a DCF may contain the node-id.",
    )
    @functools.wraps(function)
    def wrapped(
        bus_file: Path | None,
        descriptions: list[tuple[int | None, Path]],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> R:
        described = Described(bus_file, tuple(descriptions))
        return function(*args, described=described, **kwargs)  # type: ignore[arg-type]

    return wrapped


def with_span(function: Callable[P, R]) -> Callable[P, R]:
    """Add --for and --count; the function gets `seconds` and `count`."""
    function = click.option(
        "--for",
        "seconds",
        type=FiniteRange(min=0, min_open=True),
        metavar="SECONDS",
        help="Stop after this time; default: at Ctrl-C.",
    )(function)
    return click.option(
        "--count",
        type=WholeRange(min=1),
        metavar="N",
        help="Stop after N frames.",
    )(function)


def _arguments(
    context: click.Context, parameter: click.Parameter, values: tuple[str, ...]
) -> dict[str, Option]:
    found: dict[str, Option] = {}
    for text in values:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier():
            raise click.BadParameter(f"{text!r} is not KEY=VALUE", context, parameter)
        found[name] = option(value)
    return found


def _descriptions(
    context: click.Context, parameter: click.Parameter, values: tuple[Any, ...]
) -> list[tuple[int | None, Path]]:
    found: list[tuple[int | None, Path]] = []
    for text in values:
        node, equals, path = text.partition("=")
        if not equals:
            found.append((None, Path(text)))
            continue
        try:
            node_id = int(node, 0)
        except ValueError:
            node_id = 0
        if not 1 <= node_id <= 127:
            message = f"{node!r} is not a node-id (1 to 127)"
            raise click.BadParameter(message, context, parameter)
        found.append((node_id, Path(path)))
    return found
