"""Options of `rtgen run` for the transport of service calls."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from rtgen import plugins, runtime
from rtgen.cli.common import Console, FiniteRange, Place, Refusal
from rtgen.cli.running import engines
from rtgen.cli.running.engines import CALL_TIMEOUT, EngineOptions, option_of
from rtgen.cli.signals import terminable
from rtgen.diagnostics import InputError, ToolError
from rtgen.runtime.errors import NoNamingServiceError
from rtgen.runtime.services.transports import AwaitingTransport
from rtgen.systems.rules import CONNECTION, PARAMETER

if TYPE_CHECKING:
    from rtgen.model import System
    from rtgen.runtime.corba.transport import CorbaCalls
    from rtgen.runtime.services.transports import ProcessTransport

_REPORT_AFTER = 1.0
"""Seconds of waiting for other processes after which it is reported."""
_BUILT_IN = ("corba", *engines.TAKES)


class _Transport(click.Choice[str]):
    """Names of the built-in transports, shown in help texts, and of plug-ins."""

    def __init__(self) -> None:
        super().__init__(["direct", *_BUILT_IN])

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
    *engines.OPTIONS,
    click.option(
        "--wait",
        type=FiniteRange(0, 86400),
        metavar="SECONDS",
        help="Time to wait for other processes; default: 30.",
    ),
)
_WAIT = 30.0
_COMMON = frozenset({"only", "wait"})
ACTIVATED: Final = "activated"
"""The option by which `--supervise` learns which foreign components a process has activated."""
TAKES: dict[str, frozenset[str]] = {
    "corba": _COMMON | {"foreign", "nameserver", "endpoint", "call_timeout", ACTIVATED},
    **{engine: _COMMON | names for engine, names in engines.TAKES.items()},
}
"""The options of each built-in transport."""


@dataclass(frozen=True, slots=True)
class TransportOptions(EngineOptions):
    """The transport options of the command line; None for those not given."""

    only: str | None
    nameserver: str | None
    endpoint: str | None
    wait: float | None
    foreign: str | None
    activated: str | None

    @property
    def patience(self) -> float:
        """Seconds to wait for other processes."""
        return _WAIT if self.wait is None else self.wait

    @property
    def carries_data(self) -> bool:
        """Whether samples can be sent to other processes."""
        return self.transport in engines.TAKES

    @property
    def joins_data(self) -> bool:
        """Whether data ports of two processes can be connected."""
        return self.carries_data or self.transport == "corba"

    def check(self, *, simulated: bool) -> None:
        """Raise Refusal for inconsistent options."""
        self.check_taken(TAKES)
        named = [option_of(name) for name in self.given]
        if self.carries_data:
            named.append(f"--transport {self.transport}")
        if simulated and named:
            raise Refusal(
                f"{named[0]} needs --clock real: processes share no simulated time"
            )


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
    profile: System,
    *,
    simulated: bool,
) -> Iterator[ProcessTransport | None]:
    """Open the transport; None for direct calls. Raises ToolError.

    Simulated time uses no naming service, since no other process can call. `options` are those of
    plug-ins by name; `profile` is the part of this process.
    """
    if carrying.transport == "direct":
        yield None
        return
    if carrying.carries_data:
        with carrying.open(profile.name, _lease(profile)) as distributed:
            yield distributed
        return
    for entry in plugins.announced(plugins.Group.TRANSPORTS):
        if entry.name == carrying.transport:
            brought = plugins.load(entry)
            given = options.get(entry.name, {})
            calling = functools.partial(
                plugins.running, plugins.Group.TRANSPORTS, entry.name
            )
            with ExitStack() as stack:
                with calling():
                    transport = stack.enter_context(brought(given, simulated=simulated))
                try:
                    yield transport
                except Exception as error:
                    if plugins.is_passed_by(entry, error):
                        with calling():
                            raise
                    raise
                with calling():
                    stack.close()
            return
    with _corba(carrying, console, simulated=simulated) as corba:
        yield corba


def _lease(profile: System) -> float | None:
    """Return the shortest lease of the data connections."""
    from rtgen.runtime.distribution.qos import shortest_lease

    return shortest_lease(
        dict(c.properties) for c in profile.connections if not c.service
    )


def _corba(
    carrying: TransportOptions, console: Console, *, simulated: bool
) -> CorbaCalls:
    """Return the transport over omniORB. Raises ToolError."""
    try:
        from rtgen.runtime.corba.orb import LOOPBACK
        from rtgen.runtime.corba.transport import CorbaCalls, NamedCorba
    except ImportError as error:
        raise ToolError(
            "--transport corba needs omniORBpy, which is not installed",
            hint="pip install 'rtgen[corba]'",
        ) from error
    host = carrying.endpoint or LOOPBACK
    timeout = carrying.call_timeout or CALL_TIMEOUT
    try:
        if simulated:
            return CorbaCalls(host=host, timeout=timeout)
        named = NamedCorba(
            name_server=carrying.nameserver,
            host=host,
            timeout=timeout,
            activated=None if carrying.activated is None else Path(carrying.activated),
        )
    except NoNamingServiceError as error:
        hint = "start omniNames there; without --nameserver one is started"
        raise ToolError(str(error), hint=hint) from error
    except runtime.TransportError as error:
        raise ToolError(str(error)) from error
    console.say(f"naming service: {named.name_server}")
    return named


def await_others(transport: ProcessTransport, seconds: float, console: Console) -> None:
    """Wait until other processes provide the called services. Raises ToolError, InputError.

    After a while the missing components are reported. Ctrl-C and SIGTERM raise KeyboardInterrupt.
    """

    def tell() -> None:
        if isinstance(transport, AwaitingTransport) and (missing := transport.missing):
            console.say(f"waiting for other processes: {', '.join(missing)}")

    patience = threading.Timer(_REPORT_AFTER, tell)
    patience.daemon = True
    patience.start()
    try:
        with terminable():
            transport.await_others(seconds)
    except runtime.ServedElsewhereError as error:
        raise ToolError(
            str(error),
            hint="end the other process, or give this one components of its own by --only, "
            "or another --partition",
        ) from error
    except runtime.TransportError as error:
        raise ToolError(
            str(error), hint="start the process that runs it, or --wait longer"
        ) from error
    except runtime.ConnectError as error:
        raise InputError([CONNECTION.at(None, str(error))]) from error
    except runtime.ConfigurationError as error:
        raise InputError([PARAMETER.at(None, str(error))]) from error
    except KeyboardInterrupt:
        if patience.is_alive():
            tell()
        raise
    finally:
        patience.cancel()
