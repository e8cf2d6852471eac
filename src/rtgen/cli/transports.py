"""Options of `rtgen run` for the transport of service calls."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtgen import plugins, runtime
from rtgen.cli.common import Console, FiniteRange, Refusal
from rtgen.cli.signals import terminable
from rtgen.diagnostics import InputError, ToolError
from rtgen.runtime.errors import NoNamingServiceError
from rtgen.systems.rules import CONNECTION

if TYPE_CHECKING:
    from rtgen.runtime.corba.transport import CorbaTransport
    from rtgen.runtime.distribution.medium import Medium
    from rtgen.runtime.distribution.transport import DistributedTransport
    from rtgen.runtime.services.transports import ProcessTransport

_PORTS = 1 << 16
_BUILT_IN = ("corba", "dds", "zenoh")
_CARRYING_DATA = ("dds", "zenoh")
"""Transports that carry samples between processes, in real time alone."""


def _place(_: click.Context, __: click.Parameter, value: str | None) -> str | None:
    """Validate `HOST` or `HOST:PORT`. Raises click.BadParameter."""
    if value is None:
        return None
    host, colon, port = value.rpartition(":")
    good = port.isascii() and port.isdecimal() and 0 < int(port) < _PORTS
    if not (host and good if colon else value):
        raise click.BadParameter(f"'{value}' is not HOST or HOST:PORT.")
    return value


def _locators(
    _: click.Context, __: click.Parameter, value: str | None
) -> tuple[str, ...] | None:
    """Validate locators of Zenoh, `PROTOCOL/ADDRESS`. Raises click.BadParameter."""
    if value is None:
        return None
    found = tuple(text.strip() for text in value.split(","))
    for text in found:
        protocol, slash, address = text.partition("/")
        if not (protocol.isalpha() and slash and address):
            raise click.BadParameter(
                f"'{text}' is not PROTOCOL/ADDRESS, such as tcp/192.0.2.1:7447."
            )
    return found


class _Transport(click.Choice[str]):
    """The built-in transports, which help texts name, and those of plug-ins."""

    def __init__(self) -> None:
        super().__init__(["direct", *_BUILT_IN])

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """The name of a transport. Raises click.BadParameter."""
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
        help="What carries service calls, dds and zenoh samples, too, between processes.",
    ),
    click.option(
        "--only",
        metavar="INSTANCE,...",
        help="The components of this process; others run the rest (real time).",
    ),
    click.option(
        "--nameserver",
        callback=_place,
        metavar="HOST[:PORT]",
        help="Naming service (corba); by default that of this machine, else one of our own.",
    ),
    click.option(
        "--endpoint",
        metavar="HOST",
        help="Where other processes reach this one (corba); by default 127.0.0.1.",
    ),
    click.option(
        "--interface",
        metavar="NAME|ADDRESS",
        help="Network interface (dds); by default loopback.",
    ),
    click.option(
        "--domain",
        type=click.IntRange(0, 232),
        metavar="NUMBER",
        help="DDS domain (dds), 0 to 232; by default 0.",
    ),
    click.option(
        "--connect",
        callback=_locators,
        metavar="LOCATOR,...",
        help="Routers or peers (zenoh), as tcp/HOST:PORT; by default those of this machine.",
    ),
    click.option(
        "--listen",
        callback=_locators,
        metavar="LOCATOR,...",
        help="Where other peers reach this one (zenoh); by default loopback.",
    ),
    click.option(
        "--partition",
        metavar="NAME",
        help="Name that the processes of a system share; by default the system's.",
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
        help="How long a call between processes may take; by default 2.",
    ),
    click.option(
        "--wait",
        type=FiniteRange(0, 86400),
        metavar="SECONDS",
        help="How long to wait for other processes; by default 30.",
    ),
)
_CALL_TIMEOUT = 2.0
_WAIT = 30.0
_COMMON = frozenset({"only", "call_timeout", "wait"})
_DISTRIBUTED = _COMMON | {"partition", "transport_config"}
_TAKES: dict[str, frozenset[str]] = {
    "corba": _COMMON | {"nameserver", "endpoint"},
    "dds": _DISTRIBUTED | {"interface", "domain"},
    "zenoh": _DISTRIBUTED | {"connect", "listen"},
}
"""The options that a built-in transport takes."""


@dataclass(frozen=True, slots=True)
class TransportOptions:
    """The transport options of the command line; None for those not given."""

    transport: str
    only: str | None
    nameserver: str | None
    endpoint: str | None
    interface: str | None
    domain: int | None
    connect: tuple[str, ...] | None
    listen: tuple[str, ...] | None
    partition: str | None
    transport_config: str | None
    call_timeout: float | None
    wait: float | None

    @property
    def patience(self) -> float:
        """Seconds to wait for other processes."""
        return _WAIT if self.wait is None else self.wait

    @property
    def carries_data(self) -> bool:
        """Whether samples can go to other processes."""
        return self.transport in _CARRYING_DATA

    def check(self, *, simulated: bool) -> None:
        """Raise Refusal for inconsistent options."""
        present = [f.name for f in fields(self) if f.name != "transport"]
        for name in present:
            if getattr(self, name) is None:
                continue
            option = f"--{name.replace('_', '-')}"
            if name not in _TAKES.get(self.transport, ()):
                takers = [each for each, names in _TAKES.items() if name in names]
                raise Refusal(f"{option} needs --transport {' or '.join(takers)}")
            if simulated:
                raise Refusal(
                    f"{option} needs --clock real: processes share no simulated time"
                )
        if self.carries_data and simulated:
            raise Refusal(
                f"--transport {self.transport} needs --clock real: "
                "processes share no simulated time"
            )
        if self.interface is not None and self.transport_config is not None:
            raise Refusal("--interface and --transport-config exclude each other")


def with_transport(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options to a command; the function gets them as `carrying`."""

    @functools.wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> int:
        given = {f.name: kwargs.pop(f.name) for f in fields(TransportOptions)}
        return command(*args, carrying=TransportOptions(**given), **kwargs)

    function: Callable[..., int] = wrapped
    for option in reversed(_OPTIONS):
        function = option(function)
    return function


@contextmanager
def opened(
    carrying: TransportOptions,
    console: Console,
    options: Mapping[str, Mapping[str, Any]],
    system: str,
    *,
    simulated: bool,
) -> Iterator[ProcessTransport | None]:
    """The transport; None for direct calls. Raises ToolError.

    Simulated time has no naming service, since no other process can call. `options` are those of
    plug-ins by their names; `system` is the name of the system.
    """
    if carrying.transport == "direct":
        yield None
        return
    engine = _ENGINES.get(carrying.transport)
    if engine is not None:
        with _distributed(carrying, partial(engine, carrying), system) as transport:
            yield transport
        return
    for entry in plugins.announced(plugins.Group.TRANSPORTS):
        if entry.name == carrying.transport:
            brought = plugins.load(entry)
            with brought(options.get(entry.name, {}), simulated=simulated) as transport:
                yield transport
            return
    with _corba(carrying, simulated=simulated) as transport:
        if transport.name_server:
            console.say(f"naming service: {transport.name_server}")
        yield transport


def _distributed(
    carrying: TransportOptions, medium: Callable[[str], Medium], system: str
) -> DistributedTransport:
    """The transport over an engine, in the partition of the system. Raises ToolError."""
    from rtgen.runtime.distribution.medium import MediumError, check_name
    from rtgen.runtime.distribution.transport import DistributedTransport

    try:
        partition = check_name(carrying.partition or system)
    except MediumError as error:
        raise ToolError(str(error), hint="name the system by --partition") from error
    timeout = carrying.call_timeout or _CALL_TIMEOUT
    try:
        return DistributedTransport(medium(partition), timeout=timeout)
    except (MediumError, runtime.TransportError) as error:
        raise ToolError(str(error)) from error


def _dds(carrying: TransportOptions, partition: str) -> Medium:
    """The engine of DDS. Raises ToolError, MediumError."""
    try:
        from rtgen.runtime.dds.medium import DdsMedium
    except ImportError as error:
        raise ToolError(
            "--transport dds needs cyclonedds, which is not installed",
            hint="pip install 'rtgen[dds]'",
        ) from error
    config = carrying.transport_config
    return DdsMedium(
        partition,
        domain=carrying.domain or 0,
        interface=carrying.interface,
        config=None if config is None else Path(config),
    )


def _zenoh(carrying: TransportOptions, partition: str) -> Medium:
    """The engine of Zenoh. Raises ToolError, MediumError."""
    try:
        from rtgen.runtime.zenoh.medium import ZenohMedium
        from rtgen.runtime.zenoh.session import Endpoints
    except ImportError as error:
        raise ToolError(
            "--transport zenoh needs eclipse-zenoh, which is not installed",
            hint="pip install 'rtgen[zenoh]'",
        ) from error
    config = carrying.transport_config
    endpoints = Endpoints(
        None if config is None else Path(config),
        carrying.connect or (),
        carrying.listen or (),
    )
    return ZenohMedium(partition, endpoints)


_ENGINES: dict[str, Callable[[TransportOptions, str], Medium]] = {
    "dds": _dds,
    "zenoh": _zenoh,
}


def _corba(carrying: TransportOptions, *, simulated: bool) -> CorbaTransport:
    """The transport over omniORB. Raises ToolError."""
    try:
        from rtgen.runtime.corba.orb import LOOPBACK
        from rtgen.runtime.corba.transport import CorbaTransport
    except ImportError as error:
        raise ToolError(
            "--transport corba needs omniORBpy, which is not installed",
            hint="pip install 'rtgen[corba]'",
        ) from error
    try:
        return CorbaTransport(
            naming=not simulated,
            name_server=carrying.nameserver,
            host=carrying.endpoint or LOOPBACK,
            timeout=carrying.call_timeout or _CALL_TIMEOUT,
        )
    except NoNamingServiceError as error:
        hint = "start omniNames there; without --nameserver one is started"
        raise ToolError(str(error), hint=hint) from error
    except runtime.TransportError as error:
        raise ToolError(str(error)) from error


def await_others(transport: ProcessTransport, seconds: float) -> None:
    """Wait until other processes provide what is called here. Raises ToolError, InputError.

    Ctrl-C and SIGTERM raise KeyboardInterrupt.
    """
    try:
        with terminable():
            transport.await_others(seconds)
    except runtime.TransportError as error:
        raise ToolError(
            str(error), hint="start the process that runs it, or --wait longer"
        ) from error
    except runtime.ConnectError as error:
        raise InputError([CONNECTION.at(None, str(error))]) from error
