"""Options of commands that join the processes of a system over DDS or Zenoh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rtgen import runtime
from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.extras import installation
from rtgen.tools.kit.exits import Refusal

if TYPE_CHECKING:
    from rtgen.runtime.distribution.medium import Medium
    from rtgen.runtime.distribution.transport import DistributedTransport

CALL_TIMEOUT = 2.0
"""Seconds that a call may take by default."""
INTERFACE_HINT = (
    "the name or address of a network interface of this machine, as `ip address` "
    "lists them"
)
_CONNECT_HINT = (
    "start the router, or correct its address; with --listen a process waits for it"
)
_SECURE_HINT = (
    "start the router, or correct its address; a router with certificates also refuses those of "
    "another site, expired ones, and whoever shows none"
)
_LISTEN_HINT = (
    "an address of this machine with a free port; tcp/127.0.0.1:0 means any port"
)


@dataclass(frozen=True, slots=True)
class EngineOptions:
    """The options of the command line; None for those not given."""

    transport: str = "direct"
    interface: str | None = None
    domain: int | None = None
    connect: tuple[str, ...] | None = None
    listen: tuple[str, ...] | None = None
    partition: str | None = None
    transport_config: str | None = None
    call_timeout: float | None = None

    def check_taken(self, takes: dict[str, frozenset[str]]) -> None:
        """Raise Refusal for an option that the transport does not have."""
        for option in self.given:
            if option not in takes.get(self.transport, ()):
                takers = [each for each, names in takes.items() if option in names]
                *others, last = takers
                either = f"{', '.join(others)} or {last}" if others else last
                raise Refusal(f"{option_of(option)} needs --transport {either}")
        if self.interface is not None and self.transport_config is not None:
            raise Refusal("--interface and --transport-config exclude each other")

    @property
    def given(self) -> list[str]:
        """The options that were given, besides the transport."""
        names = [f.name for f in fields(self) if f.name != "transport"]
        return [name for name in names if getattr(self, name) is not None]

    def open(self, system: str, lease: float | None = None) -> DistributedTransport:
        """Return the transport, in the partition of the system of this name.

        `lease` [s] is the shortest that connections require. Raises ToolError.
        """
        from rtgen.runtime.distribution.medium import MediumError, check_name
        from rtgen.runtime.distribution.transport import DistributedTransport

        try:
            partition = check_name(self.partition or system)
        except MediumError as error:
            raise ToolError(
                str(error), hint="name the system by --partition"
            ) from error
        try:
            medium = _ENGINES[self.transport](self, partition, lease)
            timeout = self.call_timeout or CALL_TIMEOUT
            return DistributedTransport(medium, timeout=timeout)
        except (MediumError, runtime.TransportError) as error:
            raise ToolError(str(error)) from error


def option_of(name: str) -> str:
    """Return the option for the name of an argument."""
    return f"--{name.replace('_', '-')}"


ENGINE = frozenset({"partition", "transport_config", "call_timeout"})
TAKES: dict[str, frozenset[str]] = {
    "dds": ENGINE | {"interface", "domain"},
    "zenoh": ENGINE | {"connect", "listen"},
}
"""The options of each engine."""


def _dds(options: EngineOptions, partition: str, lease: float | None) -> Medium:
    """Return the engine of DDS. Raises ToolError, MediumError."""
    try:
        from rtgen.runtime.dds.medium import DdsMedium
    except ImportError as error:
        raise ToolError(
            "--transport dds needs cyclonedds, which is not installed",
            hint=installation("dds"),
        ) from error
    from rtgen.runtime.distribution.medium import MediumError

    config = options.transport_config
    try:
        return DdsMedium(
            partition,
            domain=options.domain or 0,
            interface=options.interface,
            config=None if config is None else Path(config),
            lease=lease,
        )
    except MediumError as error:
        if config is not None:
            raise ToolError(
                f"--transport-config {config}: Cyclone DDS does not start with it: {error}",
                hint="what Cyclone DDS calls CYCLONEDDS_URI is this file",
            ) from error
        if options.interface is not None:
            raise ToolError(
                f"--interface {options.interface}: Cyclone DDS does not start with it: "
                f"{error}",
                hint=INTERFACE_HINT,
            ) from error
        raise


def _zenoh(options: EngineOptions, partition: str, lease: float | None) -> Medium:
    """Return the engine of Zenoh. Raises ToolError, MediumError."""
    try:
        from rtgen.runtime.zenoh.medium import ZenohMedium
        from rtgen.runtime.zenoh.session import Endpoints
    except ImportError as error:
        raise ToolError(
            "--transport zenoh needs eclipse-zenoh, which is not installed",
            hint=installation("zenoh"),
        ) from error
    from rtgen.runtime.distribution.medium import MediumError

    config = options.transport_config
    endpoints = Endpoints(
        None if config is None else Path(config),
        options.connect or (),
        options.listen or (),
        lease,
    )
    try:
        return ZenohMedium(partition, endpoints)
    except MediumError as error:
        if config is None and (options.connect or options.listen):
            hint = _LISTEN_HINT if options.listen else _CONNECT_HINT
            raise ToolError(str(error), hint=hint) from error
        if "Unable to connect" in str(error):
            raise ToolError(str(error), hint=_SECURE_HINT) from error
        raise


_ENGINES: dict[str, Callable[[Any, str, float | None], Medium]] = {
    "dds": _dds,
    "zenoh": _zenoh,
}
