"""Service calls of a system over omniORB."""

from __future__ import annotations

import logging
import time
from collections.abc import Collection, Mapping
from contextlib import ExitStack
from functools import partial
from types import TracebackType
from typing import Any

from rtgen.runtime.component import Component
from rtgen.runtime.corba.connector import RemoteConnector, RemoteProvider
from rtgen.runtime.corba.name_server import NameServer
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import LOOPBACK, Orb
from rtgen.runtime.errors import TransportError
from rtgen.runtime.service_ports import Carrier, Provider, ServicePort
from rtgen.runtime.transports import RemotePort

log = logging.getLogger("rtgen.runtime")


class CorbaTransport:
    """Carries service calls over omniORB; objects are known by a naming service.

    `host`: where other processes reach this one; `timeout` [s] of every call; `naming`: whether
    there is a naming service at all, `name_server` its address, else the one at the usual port of
    this machine, else one of our own. All methods raise TransportError.
    """

    def __init__(
        self,
        *,
        naming: bool = True,
        name_server: str | None = None,
        host: str = LOOPBACK,
        timeout: float = 2.0,
    ) -> None:
        self._closing = ExitStack()
        orb = Orb(host, timeout)
        self._closing.callback(orb.close)
        self._objects = Objects(orb)
        self._references: dict[Provider[Any], Any] = {}
        self._connectors: list[RemoteConnector] = []
        self._naming: Naming | None = None
        try:
            if naming:
                self._naming = self._found(orb, name_server)
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
        """Ends the objects, the ORB, and a naming service of our own."""
        for provider in list(self._references):
            self._withdraw(provider)
        self._closing.close()

    def _found(self, orb: Orb, address: str | None) -> Naming:
        try:
            return Naming(orb.orb, address or LOOPBACK)
        except TransportError:
            if address is not None:
                raise
        server = self._closing.enter_context(NameServer())
        return Naming(orb.orb, server.address)

    @property
    def name_server(self) -> str:
        """The address of the naming service; empty without one."""
        return "" if self._naming is None else self._naming.address

    # What a system asks for.

    def serve(self, component: Component) -> None:
        """Makes the providers of a component reachable."""
        for (port, name), provider in component.providers.items():
            reference = self._objects.serve(
                provider.interface, provider.carry_out, partial(_exists, provider)
            )
            self._references[provider] = reference
            if self._naming is not None:
                self._naming.bind((component.instance_name, port), name, reference)

    def withdraw(self, component: Component) -> None:
        """Ends that. What the naming service does not take back is logged."""
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
        """What carries calls to a provider of this process, by the ORB, too."""
        return self._objects.remote(interface, self._references[provider])

    def connector(
        self,
        name: str,
        here: ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteConnector:
        """A connection with a port of another process. Raises ConnectError."""
        if self._naming is None:
            raise TransportError(f"{there} is in no process that could be asked")
        made = RemoteConnector(
            name, here, there, properties, self._objects, self._naming
        )
        self._connectors.append(made)
        return made

    # Other processes.

    def await_others(self, seconds: float) -> None:
        """Waits until all providers that are connected are there.

        Raises PortTypeError if they do not fit.
        """
        deadline = time.monotonic() + seconds
        for connector in self._connectors:
            if connector.connected:
                connector.await_providers(deadline)

    def _wanted(self) -> list[RemoteProvider]:
        return [p for c in self._connectors if c.connected for p in c.providers]

    def is_ready(self, instance: str, before: Collection[str]) -> bool:
        """Whether the providers of an instance that other processes activate first are ACTIVE."""
        return all(
            provider.exists
            for provider in self._wanted()
            if provider.consumer.owner == instance and provider.port.instance in before
        )


def _exists(provider: Provider[Any]) -> bool:
    return provider.exists
