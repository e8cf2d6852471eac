"""Transports of a system's service calls over omniORB."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Collection, Mapping
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omniORB import CORBA

from rtgen.runtime.closable import Closable
from rtgen.runtime.corba.connector import RemoteConnector, RemoteProvider
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import LOOPBACK, Orb
from rtgen.runtime.corba.rt_objects.foreign import Directory, Foreign
from rtgen.runtime.corba.rt_objects.keeping import Keeper
from rtgen.runtime.corba.rt_objects.peers import PeerConnection, ServicePeer
from rtgen.runtime.corba.rt_objects.publishing import RtObjects
from rtgen.runtime.errors import TransportError
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.return_codes import ACTIVE_STATE, LifeCycleState
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.ports import Carrier, PortOwner, Provider, ServicePort
from rtgen.runtime.services.transports import (
    ForeignComponent,
    LinkReport,
    RemotePort,
)
from rtgen.runtime.timing.guards import Guard

if TYPE_CHECKING:
    from rtgen.runtime.system.system import System

log = logging.getLogger("rtgen.runtime")

_POLL_INTERVAL = 0.05


class CorbaCalls(Closable):
    """Carries the service calls of one process over omniORB, without a naming service.

    `host`: address for other processes; `timeout` [s] of every call. All methods raise
    TransportError.
    """

    def __init__(self, *, host: str = LOOPBACK, timeout: float = 2.0) -> None:
        self._closing = ExitStack()
        self._orb = Orb(host, timeout)
        self._closing.callback(self._orb.close)
        self._objects = Objects(self._orb)
        self._references: dict[Provider[Any], Any] = {}

    def close(self) -> None:
        """Remove the objects, and shut down the ORB."""
        for provider in list(self._references):
            self._withdraw(provider)
        self._closing.close()

    def serve(self, component: PortOwner) -> None:
        """See `Transport`."""
        for provider in component.providers.values():
            self._references[provider] = self._objects.serve(
                provider.interface, provider.carry_out, partial(_exists, provider)
            )

    def withdraw(self, component: PortOwner) -> None:
        """See `Transport`."""
        for provider in component.providers.values():
            if provider in self._references:
                self._withdraw(provider)

    def _withdraw(self, provider: Provider[Any]) -> None:
        self._objects.withdraw(self._references.pop(provider))

    def carrier_of(self, interface: Any, provider: Provider[Any]) -> Carrier:
        """Return the carrier of calls to a provider of this process, which also use the ORB."""
        return self._objects.remote(interface, self._references[provider])

    def connector(
        self,
        name: str,
        here: ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteConnector | ServicePeer:
        """Raise TransportError: other processes are found by a naming service."""
        raise TransportError(f"{there} is in no reachable process")

    def await_others(self, seconds: float) -> None:
        """See `ProcessTransport`: there are none."""

    def is_ready(self, instance: str, before: Collection[str]) -> bool:
        """See `ProcessTransport`: there are no other processes."""
        return True


class NamedCorba(CorbaCalls):
    """Carries calls and samples between processes over omniORB; a naming service finds objects.

    `name_server`: where it is, by default at this machine's standard port, or else a private one;
    `activated`: a file that lists the foreign components activated here.
    """

    def __init__(
        self,
        *,
        name_server: str | None = None,
        host: str = LOOPBACK,
        timeout: float = 2.0,
        activated: Path | None = None,
    ) -> None:
        super().__init__(host=host, timeout=timeout)
        orb = self._orb
        try:
            self._naming = self._open_naming(name_server)
            self.rt_objects = RtObjects(orb, self._objects, self._naming)
            """The components of this process, as visible to others."""
            self._directory = Directory(
                self._naming,
                self.rt_objects.exported,
                partial(Naming, orb.orb, limit=orb.limit),
                activated,
            )
        except TransportError:
            self._closing.close()
            raise
        self._connectors: list[RemoteConnector] = []
        self._peers: list[PeerConnection | ServicePeer] = []
        self._keeper: Keeper | None = None

    def close(self) -> None:
        """Remove the objects, and shut down the ORB and a private naming service.

        Components that were activated here are deactivated.
        """
        with ExitStack() as last:
            last.callback(super().close)
            last.callback(self.release_foreign)
            self._stop_monitoring()

    def _open_naming(self, address: str | None) -> Naming:
        orb = self._orb
        try:
            return Naming(orb.orb, address or LOOPBACK, orb.limit)
        except TransportError:
            if address is not None:
                raise
        server = self._closing.enter_context(NameServer())
        return Naming(orb.orb, server.address, orb.limit)

    @property
    def name_server(self) -> str:
        """The address of the naming service."""
        return self._naming.address

    def allow_control(self, system: System) -> None:
        """See `ControlTransport`."""
        self.rt_objects.system = system

    def publishing(self) -> AbstractContextManager[None]:
        """See `PublishingTransport`."""
        return self.rt_objects.publishing()

    # Interface to the system

    def serve(self, component: PortOwner) -> None:
        """Publish the providers of a component, and the component itself as an RTObject."""
        super().serve(component)
        for (port, name), provider in component.providers.items():
            place = component.instance_name, port
            self._naming.bind(place, name, self._references[provider])
        if isinstance(component, Component):
            self.rt_objects.publish(component, self._references)

    def withdraw(self, component: PortOwner) -> None:
        """Withdraw a component. Failures of the naming service are logged."""
        try:
            self.rt_objects.withdraw(component.instance_name)
        except TransportError as error:
            log.warning("%s", error)
        super().withdraw(component)

    def _withdraw(self, provider: Provider[Any]) -> None:
        place = provider.owner, provider.port
        try:
            self._naming.unbind(place, provider.instance, self._references[provider])
        except TransportError as error:
            log.warning("%s", error)
        super()._withdraw(provider)

    def connector(
        self,
        name: str,
        here: ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteConnector | ServicePeer:
        """Return a connection to a port of another process. Raises ConnectError."""
        if self.is_foreign(there.instance):
            peer = ServicePeer(name, here, there, properties, self.rt_objects)
            self._peers.append(peer)
            return peer
        made = RemoteConnector(
            name, here, there, properties, self._objects, self._naming
        )
        self._connectors.append(made)
        return made

    def sending(
        self,
        name: str,
        here: InPort[Any] | OutPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> PeerConnection:
        """Return a connection to an InPort of another process, not established."""
        made = PeerConnection(name, here, there, properties, self.rt_objects)
        self._peers.append(made)
        return made

    def receiving(
        self,
        name: str,
        here: InPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> PeerConnection:
        """Return a connection from an OutPort of another process, not established."""
        return self.sending(name, here, there, properties)

    # Other processes

    def await_others(self, seconds: float) -> None:
        """Wait for all connected providers and data ports.

        Foreign components are configured. Raises PortTypeError for incompatible types,
        ConfigurationError.
        """
        deadline = time.monotonic() + seconds
        directory = self._directory
        for foreign in directory.foreign.values():
            self._await(foreign, deadline)
        for connector in self._connectors:
            if connector.connected:
                connector.await_providers(deadline)
        for peer in self._peers:
            if peer.connected:
                peer.establish(directory, deadline)
        if self._peers or directory.foreign:
            self._stop_monitoring()
            self._keeper = Keeper(directory, lambda: tuple(self._peers))

    def _await(self, foreign: Foreign, deadline: float) -> None:
        while self._directory.find(foreign.instance) is None:
            if time.monotonic() > deadline:
                raise TransportError(
                    f"no process runs {foreign.instance}, which rtgen does not run: "
                    f"{self._directory.where(foreign.instance)}"
                )
            time.sleep(_POLL_INTERVAL)
        foreign.configure()
        foreign.look()

    def _stop_monitoring(self) -> None:
        """Stop monitoring other processes."""
        keeper, self._keeper = self._keeper, None
        if keeper is not None:
            keeper.close()

    def add_foreign(self, component: ForeignComponent) -> None:
        """See `ForeignTransport`."""
        self._directory.add(component)

    def is_foreign(self, instance: str) -> bool:
        """See `ForeignTransport`."""
        return instance in self._directory.foreign

    def activate_foreign(self, instance: str) -> None:
        """See `ForeignTransport`."""
        self._directory.foreign[instance].activate(self._directory.activations)

    def deactivate_foreign(self, instance: str) -> None:
        """See `ForeignTransport`."""
        self._directory.foreign[instance].wanted = False
        self._directory.activations.release(instance)

    def foreign_states(self) -> dict[str, LifeCycleState | None]:
        """See `ForeignTransport`."""
        foreign = self._directory.foreign
        return {name: each.last_state for name, each in foreign.items()}

    def link_reports(self) -> list[LinkReport]:
        """See `ForeignTransport`."""
        return [report for peer in self._peers if (report := peer.report) is not None]

    def release_foreign(self) -> None:
        """See `ForeignTransport`."""
        self._directory.activations.release_all()

    @property
    def missing(self) -> list[str]:
        """See `AwaitingTransport`: those that do not respond at the moment."""
        data = {peer.there.instance for peer in self._peers if peer.connected}
        calls = {p.port.instance for p in self._remote_providers() if not p.is_served}
        silent = {
            each
            for each in {*data, *self._directory.foreign}
            if not _answers(self._directory, each)
        }
        return sorted(silent | calls)

    def _remote_providers(self) -> list[RemoteProvider]:
        return [p for c in self._connectors if c.connected for p in c.providers]

    def is_ready(self, instance: str, before: Collection[str]) -> bool:
        """Return whether an instance's providers that other processes activate first are ACTIVE."""
        foreign = self._directory.foreign
        called = {
            peer.there.instance
            for peer in self._peers
            if isinstance(peer, ServicePeer) and peer.here.instance == instance
        }
        if any(foreign[name].state is not ACTIVE_STATE for name in called & {*before}):
            return False
        return all(
            provider.exists
            for provider in self._remote_providers()
            if provider.consumer.owner == instance and provider.port.instance in before
        )


def _exists(provider: Provider[Any]) -> bool:
    return provider.exists


def _answers(directory: Directory, instance: str) -> bool:
    try:
        return directory.find(instance) is not None
    except (CORBA.SystemException, TransportError):
        return False
