"""Options of the commands that join processes: engines, and transports of calls and samples."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import click

from rtgen.cli.parameter_types import FiniteRange, Place, WholeRange
from rtgen.compiler.kit import plugins
from rtgen.tools.running.transports import BUILT_IN, TransportOptions


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


ENGINE_OPTIONS = (
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
        help="Routers or peers (zenoh), as tcp/HOST:PORT; default: those of this machine.",
    ),
    click.option(
        "--listen",
        callback=_locators,
        metavar="LOCATOR,...",
        help="Locators of this peer for other peers (zenoh); default: loopback.",
    ),
    click.option(
        "--partition",
        callback=_partition,
        metavar="NAME",
        help="Name shared by the processes of a system; default: the name of the system.",
    ),
    click.option(
        "--transport-config",
        type=click.Path(exists=True, dir_okay=False),
        metavar="FILE",
        help="Configuration file of the engine (dds, zenoh) in its own format.",
    ),
    click.option(
        "--call-timeout",
        type=FiniteRange(0.001, 3600),
        metavar="SECONDS",
        help="Time-out of calls between processes; default: 2.",
    ),
)


class _Transport(click.Choice[str]):
    """Names of the built-in transports, shown in help texts, and of plug-ins."""

    def __init__(self) -> None:
        super().__init__(["direct", *BUILT_IN])

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """Return the name of a transport. Raises click.BadParameter."""
        if value in (
            entry.name for entry in plugins.announced(plugins.Group.TRANSPORTS)
        ):
            return str(value)
        return super().convert(value, param, ctx)


_OPTIONS = (
    click.option(
        "--transport",
        type=_Transport(),
        default="direct",
        show_default=True,
        help="Transport of service calls, and of samples between processes.",
    ),
    click.option(
        "--only",
        metavar="INSTANCE,...",
        help="Components of this process; other processes run the rest (real time).",
    ),
    click.option(
        "--foreign",
        metavar="INSTANCE,...",
        help="Components that rtgen does not run, but connects and activates (corba).",
    ),
    click.option("--activated", metavar="FILE", hidden=True),
    click.option(
        "--nameserver",
        type=Place(),
        metavar="HOST[:PORT]",
        help="Naming service (corba); default: that of this machine, else a new one.",
    ),
    click.option(
        "--endpoint",
        metavar="HOST",
        help="Address of this process for other processes (corba); default: 127.0.0.1.",
    ),
    *ENGINE_OPTIONS,
    click.option(
        "--wait",
        type=FiniteRange(0, 86400),
        metavar="SECONDS",
        help="Time to wait for other processes; default: 30.",
    ),
)


def with_transport(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options to a command; the function gets them as `carrying`."""

    @functools.wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> int:
        options = {f.name: kwargs.pop(f.name) for f in fields(TransportOptions)}
        return command(*args, carrying=TransportOptions(**options), **kwargs)

    function: Callable[..., int] = wrapped
    for option in reversed(_OPTIONS):
        function = option(function)
    return function
