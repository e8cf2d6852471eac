"""Options of `rtgen run` for the transport of service calls."""

from __future__ import annotations

import functools
import threading
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rtgen import runtime
from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.kit import plugins
from rtgen.compiler.systems.rules import CONNECTION, PARAMETER
from rtgen.facts.extras import installation
from rtgen.runtime.errors import NoNamingServiceError
from rtgen.runtime.services.transports import AwaitingTransport
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.kit.signals import terminable
from rtgen.tools.running import engines
from rtgen.tools.running.engines import CALL_TIMEOUT, EngineOptions, option_of

if TYPE_CHECKING:
    from rtgen.compiler.model import System
    from rtgen.runtime.corba.transport import CorbaCalls
    from rtgen.runtime.services.transports import ProcessTransport

_REPORT_AFTER = 1.0
"""Seconds of waiting for other processes after which it is reported."""


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

    only: str | None = None
    nameserver: str | None = None
    endpoint: str | None = None
    wait: float | None = None
    foreign: str | None = None
    activated: str | None = None

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
            options_of = options.get(entry.name, {})
            calling = functools.partial(
                plugins.running, plugins.Group.TRANSPORTS, entry.name
            )
            with ExitStack() as stack:
                with calling():
                    transport = stack.enter_context(
                        brought(options_of, simulated=simulated)
                    )
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
            hint=installation("corba"),
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
