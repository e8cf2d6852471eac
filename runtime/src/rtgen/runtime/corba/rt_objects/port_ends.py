"""Interfaces around a port service: what it connects, and who is told of failures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import msgspec

from rtgen.runtime.corba.rt_objects.data import Losses
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.wire import ConnectorProfile, PortInterfaceProfile
from rtgen.runtime.system.joining import Connector

if TYPE_CHECKING:
    from rtgen.runtime.system.system import System


class Offer(msgspec.Struct):
    """A port's part of a connector: properties, its half of the connection, how to end it."""

    properties: Mapping[str, str]
    connector: Connector | None = None
    withdraw: Callable[[], None] = lambda: None


class End(Protocol):
    """Target of a port service: a data port, or the interfaces of a service port."""

    port: str
    properties: dict[str, str]
    interfaces: list[PortInterfaceProfile]

    def offer(self, name: str, properties: Mapping[str, str]) -> Offer:
        """Return the port's offer to a connection. Raises ConnectError."""

    def accept(
        self, name: str, properties: Mapping[str, str], losses: Losses
    ) -> Connector | None:
        """Return the connection to the other end's offer; None if `offer` has made it.

        Raises ConnectError.
        """

    def has(self, connector: Connector) -> bool:
        """Return whether a connection of the system ends here."""


class Watcher(Protocol):
    """Is told of the failures of one connection to a port of another process."""

    def on_refusal(self, reason: str) -> None:
        """A sample cannot be sent."""

    def on_loss(self, reason: str) -> None:
        """The other process does not answer any more."""

    def on_end(self) -> None:
        """The other port has ended the connection, without a request of this process."""

    def on_removal(self, connector: Connector | None) -> None:
        """The connection has been removed here, for any reason."""


class Link(msgspec.Struct, eq=False):
    """A connection to a port of another process; one that is made again is another one."""

    profile: ConnectorProfile
    connector: Connector | None
    withdraw: Callable[[], None]


class Ports(Protocol):
    """The port services of a process."""

    exported: Exported
    system: System | None
    ids: dict[str, str]
    """Ids of connections made by other processes, by their names in the system."""

    def at(self, connector: Connector) -> Sequence[Any]:
        """Return the port services at which a connection ends."""

    def give_up(self, place: str, reason: str) -> None:
        """End the connections to a process that does not answer."""
