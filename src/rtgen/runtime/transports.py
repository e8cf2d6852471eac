"""What carries service calls in place of a call in the same process, and between processes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from rtgen.runtime.component import Component
from rtgen.runtime.service_ports import Carrier, Provider, ServicePort


@dataclass(frozen=True, slots=True)
class RemotePort:
    """A service port of a component in another process."""

    instance: str
    port: str

    def __str__(self) -> str:
        return f"{self.instance}.{self.port}"


class RemoteConnector(Protocol):
    """One connection with a service port of another process."""

    name: str
    source: ServicePort
    target: RemotePort
    connected: bool

    def attach(self) -> None:
        """Makes the connection: calls go to the other process. Raises ConnectError."""

    def detach(self) -> None:
        """Cuts the connection; later calls raise ObjectNotExist."""


class Transport(Protocol):
    """Carries the calls of a system's service ports. Methods raise RtcError."""

    def serve(self, component: Component) -> None:
        """Makes the providers of a component reachable."""

    def withdraw(self, component: Component) -> None:
        """Ends that."""

    def reach(self, consumer_interface: Any, provider: Provider[Any]) -> Carrier:
        """What carries calls of a consumer's interface to a provider of this process."""

    def connector(
        self,
        name: str,
        here: ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteConnector:
        """A connection with a port of another process, not made yet. Raises ConnectError."""
