"""Transport of a system's service calls over omniORB."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Collection, Mapping
from contextlib import AbstractContextManager, ExitStack, nullcontext
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from omniORB import CORBA

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


class CorbaTransport:
    """Carries service calls over omniORB; objects are found by a naming service.

    `host`: address for other processes; `timeout` [s] of every call; `naming`: whether to use a
    naming service, at `name_server`, defaulting to this machine's standard port, falling back to a
    private one; `activated`: a file that lists the foreign components activated here. All methods
    raise TransportError.
    """

    def __init__(
        self,
        *,
        naming: bool = True,
        name_server: str | None = None,
        host: str = LOOPBACK,
        timeout: float = 2.0,
        activated: Path | None = None,
    ) -> None:
        self._closing = ExitStack()
        orb = Orb(host, timeout)
        self._closing.callback(orb.close)
        self._objects = Objects(orb)
        self._references: dict[Provider[Any], Any] = {}
        self._connectors: list[RemoteConnector] = []
        self._peers: list[PeerConnection | ServicePeer] = []
        self._naming: Naming | None = None
        self._directory: Directory | None = None
        self._keeper: Keeper | None = None
        self._rt_objects: RtObjects | None = None
        try:
            if naming:
                self._naming = self._found(orb, name_server)
                self._rt_objects = RtObjects(orb, self._objects, self._naming)
                self._directory = Directory(
                    self._naming,
                    self._rt_objects.exported,
                    partial(Naming, orb.orb, limit=orb.limit),
                    activated,
                )
        except TransportError:
            self.close()
            raise

    def __enter__(self) -> CorbaTransport:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Remove the objects, and shut down the ORB and a private naming service.

        Components that were activated here are deactivated.
        """
        with ExitStack() as last:
            last.callback(self._close)
            last.callback(self.release_foreign)
            self._rest()

    def _close(self) -> None:
        for provider in list(self._references):
            self._withdraw(provider)
        self._closing.close()

    def _found(self, orb: Orb, address: str | None) -> Naming:
        try:
            return Naming(orb.orb, address or LOOPBACK, orb.limit)
        except TransportError:
            if address is not None:
                raise
        server = self._closing.enter_context(NameServer())
        return Naming(orb.orb, server.address, orb.limit)

    @property
    def name_server(self) -> str:
        """The address of the naming service; empty without one."""
        return "" if self._naming is None else self._naming.address

    @property
    def rt_objects(self) -> RtObjects | None:
        """The components of this process, as visible to others; None without a naming service."""
        return self._rt_objects

    def steered(self, system: System) -> None:
        """Let other processes observe and control the components of a system."""
        if self._rt_objects is not None:
            self._rt_objects.system = system

    def publishing(self) -> AbstractContextManager[None]:
        """See `PublishingTransport`."""
        return (
            nullcontext() if self._rt_objects is None else self._rt_objects.publishing()
        )

    # Interface to the system

    def serve(self, component: PortOwner) -> None:
        """Publish the providers of a component, and the component itself as an RTObject."""
        for (port, name), provider in component.providers.items():
            reference = self._objects.serve(
                provider.interface, provider.carry_out, partial(_exists, provider)
            )
            self._references[provider] = reference
            if self._naming is not None:
                self._naming.bind((component.instance_name, port), name, reference)
        if self._rt_objects is not None and isinstance(component, Component):
            self._rt_objects.publish(component, self._references)

    def withdraw(self, component: PortOwner) -> None:
        """Withdraw a component. Failures of the naming service are logged."""
        if self._rt_objects is not None:
            try:
                self._rt_objects.withdraw(component.instance_name)
            except TransportError as error:
                log.warning("%s", error)
        for provider in component.providers.values():
            if provider in self._references:
                self._withdraw(provider)

    def _withdraw(self, provider: Provider[Any]) -> None:
        reference = self._references.pop(provider)
        if self._naming is not None:
            place = provider.owner, provider.port
            try:
                self._naming.unbind(place, provider.instance, reference)
            except TransportError as error:
                log.warning("%s", error)
        self._objects.withdraw(reference)

    def reach(self, interface: Any, provider: Provider[Any]) -> Carrier:
        """Return the carrier of calls to a provider of this process, which also use the ORB."""
        return self._objects.remote(interface, self._references[provider])

    def connector(
        self,
        name: str,
        here: ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteConnector | ServicePeer:
        """Return a connection to a port of another process. Raises ConnectError."""
        if self._naming is None:
            raise TransportError(f"{there} is in no reachable process")
        directory = self._directory
        if directory is not None and there.instance in directory.foreign:
            assert self._rt_objects is not None  # set together with the directory
            peer = ServicePeer(name, here, there, properties, self._rt_objects)
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
        here: OutPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> PeerConnection:
        """Return a connection to an InPort of another process, not established."""
        return self._peer(name, here, there, properties)

    def receiving(
        self,
        name: str,
        here: InPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> PeerConnection:
        """Return a connection from an OutPort of another process, not established."""
        return self._peer(name, here, there, properties)

    def _peer(
        self,
        name: str,
        here: InPort[Any] | OutPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> PeerConnection:
        if self._rt_objects is None:
            raise TransportError(f"{there} is in no reachable process")
        made = PeerConnection(name, here, there, properties, self._rt_objects)
        self._peers.append(made)
        return made

    # Other processes

    def await_others(self, seconds: float) -> None:
        """Wait for all connected providers and data ports.

        Foreign components are configured. Raises PortTypeError for incompatible types,
        ConfigurationError.
        """
        deadline = time.monotonic() + seconds
        directory = self._directory
        if directory is not None:
            for foreign in directory.foreign.values():
                self._await(directory, foreign, deadline)
        for connector in self._connectors:
            if connector.connected:
                connector.await_providers(deadline)
        for peer in self._peers:
            if peer.connected and directory is not None:
                peer.establish(directory, deadline)
        if directory is not None and (self._peers or directory.foreign):
            self._rest()
            self._keeper = Keeper(directory, lambda: tuple(self._peers))

    def _await(self, directory: Directory, foreign: Foreign, deadline: float) -> None:
        while directory.find(foreign.instance) is None:
            if time.monotonic() > deadline:
                raise TransportError(
                    f"no process runs {foreign.instance}, which rtgen does not run: "
                    f"{directory.where(foreign.instance)}"
                )
            time.sleep(_POLL_INTERVAL)
        foreign.configure()
        foreign.look()

    def _rest(self) -> None:
        """Stop monitoring other processes."""
        keeper, self._keeper = self._keeper, None
        if keeper is not None:
            keeper.close()

    def expect(self, component: ForeignComponent) -> None:
        """See `ForeignTransport`."""
        if self._directory is None:
            raise TransportError(f"{component.instance} is found by a naming service")
        self._directory.expect(component)

    def reaches(self, instance: str) -> bool:
        """See `ForeignTransport`."""
        return self._directory is not None and instance in self._directory.foreign

    def activate_foreign(self, instance: str) -> None:
        """See `ForeignTransport`."""
        if self._directory is not None:
            foreign = self._directory.foreign[instance]
            foreign.activate(self._directory.activations)

    def deactivate_foreign(self, instance: str) -> None:
        """See `ForeignTransport`."""
        if self._directory is not None:
            self._directory.foreign[instance].wanted = False
            self._directory.activations.release(instance)

    def foreign_states(self) -> dict[str, LifeCycleState | None]:
        """See `ForeignTransport`."""
        foreign = {} if self._directory is None else self._directory.foreign
        return {name: each.last_state for name, each in foreign.items()}

    def link_reports(self) -> list[LinkReport]:
        """See `ForeignTransport`."""
        return [report for peer in self._peers if (report := peer.report) is not None]

    def release_foreign(self) -> None:
        """See `ForeignTransport`."""
        if self._directory is not None:
            self._directory.activations.release_all()

    @property
    def missing(self) -> list[str]:
        """See `AwaitingTransport`: those that do not respond at the moment."""
        directory = self._directory
        if directory is None:
            return []
        data = {peer.there.instance for peer in self._peers if peer.connected}
        calls = {p.port.instance for p in self._wanted() if not p.is_served}
        silent = {
            each
            for each in {*data, *directory.foreign}
            if not _answers(directory, each)
        }
        return sorted(silent | calls)

    def _wanted(self) -> list[RemoteProvider]:
        return [p for c in self._connectors if c.connected for p in c.providers]

    def is_ready(self, instance: str, before: Collection[str]) -> bool:
        """Return whether an instance's providers that other processes activate first are ACTIVE."""
        foreign = {} if self._directory is None else self._directory.foreign
        called = {
            peer.there.instance
            for peer in self._peers
            if isinstance(peer, ServicePeer) and peer.here.instance == instance
        }
        if any(foreign[name].state is not ACTIVE_STATE for name in called & {*before}):
            return False
        return all(
            provider.exists
            for provider in self._wanted()
            if provider.consumer.owner == instance and provider.port.instance in before
        )


def _exists(provider: Provider[Any]) -> bool:
    return provider.exists


def _answers(directory: Directory, instance: str) -> bool:
    try:
        return directory.find(instance) is not None
    except (CORBA.SystemException, TransportError):
        return False
