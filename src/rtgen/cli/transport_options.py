"""Options of the commands that join processes: engines, and transports of calls and samples."""

from __future__ import annotations

from typing import Any

import click

from rtgen.cli.help import gathered
from rtgen.cli.parameter_types import FiniteRange, Place, WholeRange
from rtgen.compiler.kit import plugins
from rtgen.compiler.project import TRANSPORTS
from rtgen.tools.running.transports import TransportOptions


def _locators(
    _: click.Context, __: click.Parameter, value: str | None
) -> tuple[str, ...] | None:
    """Validate locators of Zenoh, `PROTOCOL/ADDRESS`. Raises click.BadParameter."""
    if value is None:
        return None
    locators = tuple(text.strip() for text in value.split(","))
    for text in locators:
        protocol, slash, address = text.partition("/")
        if not (protocol.isalpha() and slash and address):
            raise click.BadParameter(
                f"'{text}' is not PROTOCOL/ADDRESS, such as tcp/192.0.2.1:7447."
            )
    return locators


def _partition(_: click.Context, __: click.Parameter, value: str | None) -> str | None:
    """Validate the name of a partition. Raises click.BadParameter."""
    if value is None:
        return None
    from rtgen.runtime.distribution.medium import MediumError, check_name

    try:
        return check_name(value)
    except MediumError as error:
        raise click.BadParameter(f"{error}.") from error


PROCESSES = "Processes"
"""The title of the options of this module."""

ENGINE_OPTIONS = (
    click.option(
        "--partition",
        callback=_partition,
        metavar="NAME",
        help="Common name; default: that of the system.",
    ),
    click.option(
        "--interface",
        metavar="NAME|ADDRESS",
        help="Network interface (dds); default: loopback.",
    ),
    click.option(
        "--domain",
        type=WholeRange(0, 232),
        metavar="NUMBER",
        help="DDS domain (dds); default: 0.",
    ),
    click.option(
        "--connect",
        callback=_locators,
        metavar="LOCATOR,...",
        help="Routers, peers (zenoh): tcp/HOST:PORT.",
    ),
    click.option(
        "--listen",
        callback=_locators,
        metavar="LOCATOR,...",
        help="Where this peer listens (zenoh).",
    ),
    click.option(
        "--transport-config",
        type=click.Path(exists=True, dir_okay=False),
        metavar="FILE",
        help="The engine's own configuration (dds, zenoh).",
    ),
    click.option(
        "--call-timeout",
        type=FiniteRange(0.001, 3600),
        metavar="SECONDS",
        help="Time-out of calls; default: 2.",
    ),
)


class _Transport(click.Choice[str]):
    """Names of the built-in transports, shown in help texts, and of plug-ins."""

    def __init__(self) -> None:
        super().__init__(TRANSPORTS)

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """Return the name of a transport. Raises click.BadParameter."""
        if value in (
            entry.name for entry in plugins.announced(plugins.Group.TRANSPORTS)
        ):
            return str(value)
        return super().convert(value, param, ctx)


with_transport = gathered(
    "carrying",
    TransportOptions,
    click.option(
        "--transport",
        type=_Transport(),
        default="direct",
        metavar="NAME",
        help="direct, corba, dds or zenoh; default: direct.",
    ),
    click.option(
        "--only",
        metavar="INSTANCE,...",
        help="The components that this process runs.",
    ),
    click.option(
        "--foreign",
        metavar="INSTANCE,...",
        help="Components that rtgen does not run (corba).",
    ),
    click.option("--activated", metavar="FILE", hidden=True),
    click.option(
        "--nameserver",
        type=Place(),
        metavar="HOST[:PORT]",
        help="Naming service (corba); default: a new one.",
    ),
    click.option(
        "--endpoint",
        metavar="HOST",
        help="Address of this process (corba).",
    ),
    *ENGINE_OPTIONS,
    click.option(
        "--wait",
        type=FiniteRange(0, 86400),
        metavar="SECONDS",
        help="For other processes; default: 30.",
    ),
    title=PROCESSES,
)
