"""Connections between a service port of this process and one of another, for every transport."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping
from typing import Any, Generic, Protocol, TypeVar

from rtgen.runtime.errors import (
    ConnectorPropertyError,
    DuplicateConnectionError,
    PortTypeError,
    TransportError,
)
from rtgen.runtime.marshalling.descriptors import InterfaceDescriptor
from rtgen.runtime.services.connectors import end, read_properties
from rtgen.runtime.services.ports import Carrier, Consumer, ServicePort
from rtgen.runtime.services.transports import RemotePort

_POLL_INTERVAL = 0.05


class FoundProvider(Carrier, Protocol):
    """The provider in another process that a consumer is connected to."""

    consumer: Consumer[Any]
    port: RemotePort
    selected: str | None
    """The instance name that a property selects."""
    alone: bool
    """Whether the consumer is the only one of its interface."""

    def find(self) -> bool:
        """Look the provider up; return whether it exists. Raises TransportError, PortTypeError."""


P = TypeVar("P", bound=FoundProvider)
_O = TypeVar("_O")


def fitting_provider(
    provider: FoundProvider,
    offers: Mapping[str, _O],
    has_interface: Callable[[_O, str], bool],
    operations_of: Callable[[_O], Collection[str] | None],
) -> _O:
    """Return the offer of a port that is selected by property, else by name and type, else alone.

    `has_interface` says whether an offer has the interface of a repository id, `operations_of` the
    signatures of its operations, None if they are not known. Raises PortTypeError.
    """
    consumer, port, selected = provider.consumer, provider.port, provider.selected
    wanted: InterfaceDescriptor = consumer.interface._descriptor_
    identity = wanted.repository_id
    name = consumer.instance if selected is None else selected
    if name in offers and has_interface(offers[name], identity):
        fitting = [offers[name]]
    else:
        others = offers.values() if selected is None else ()
        fitting = [each for each in others if has_interface(each, identity)]
        fitting = fitting if provider.alone and len(fitting) == 1 else []
    if not fitting:
        raise PortTypeError(
            f"{port} has no provider for {consumer}, which requires {identity}; "
            f"it has: {', '.join(offers)}"
        )
    known = operations_of(fitting[0])
    missing = [] if known is None else [s for s in wanted.operations if s not in known]
    if missing:
        raise PortTypeError(
            f"{consumer} and {port} were generated from different definitions "
            f"of {wanted.name}; the provider has no {', '.join(missing)}"
        )
    return fitting[0]


class RemoteServiceConnector(Generic[P]):
    """A connection between a local service port and one of another process.

    Consumers of the local port call `providers`; the other port's consumers look up the providers
    of the local port. `make` returns the provider for a consumer, given the instance name selected
    by properties, and whether the consumer is the only one of its interface; `where` says in
    messages where providers are looked up. Raises ConnectorPropertyError.
    """

    def __init__(
        self,
        name: str,
        source: ServicePort,
        target: RemotePort,
        properties: Mapping[str, str],
        make: Callable[[Consumer[Any], str | None, bool], P],
        where: str,
    ) -> None:
        self.name = name
        self.source = source
        self.target = target
        self.connected = False
        self._where = where
        named, self.strict = read_properties(properties)
        kinds = [consumer.interface for consumer in source.consumers]
        self.providers = [
            make(
                consumer,
                _selected(named, source, target, consumer),
                kinds.count(consumer.interface) == 1,
            )
            for consumer in source.consumers
        ]
        there = f"{target.instance}.port.{target.port}.required."
        unknown = next((key for key in named if not key.startswith(there)), None)
        if unknown is not None:
            raise ConnectorPropertyError(
                f"connector property {unknown!r} names no consumer"
            )

    def attach(self) -> None:
        """Establish the connection. Raises DuplicateConnectionError."""
        for provider in self.providers:
            if provider.consumer.connected:
                raise DuplicateConnectionError(
                    f"{provider.consumer} is connected already"
                )
        self.connected = True
        for provider in self.providers:
            provider.consumer._provider = provider

    def await_providers(self, deadline: float) -> None:
        """Wait for all providers, until a time of `time.monotonic`.

        Raises TransportError after the deadline, PortTypeError for incompatible types: with
        `strict` all interfaces must match, else at least one, as for a connection within a process.
        """
        lonely: list[PortTypeError] = []
        for provider in self.providers:
            try:
                self._await(provider, deadline)
            except PortTypeError as error:
                lonely.append(error)
        pairs = len(self.providers) - len(lonely) + len(self.source.providers)
        if lonely and (self.strict or not pairs):
            raise lonely[0]

    def _await(self, provider: P, deadline: float) -> None:
        while not provider.find():
            if time.monotonic() > deadline:
                raise TransportError(
                    f"{provider.consumer} waits for {self.target}, "
                    f"which nobody serves {self._where}"
                )
            time.sleep(_POLL_INTERVAL)

    def detach(self) -> None:
        """Remove the connection; later calls raise ObjectNotExist."""
        self.connected = False
        for provider in self.providers:
            provider.consumer._provider = None


def _selected(
    named: dict[str, str], here: ServicePort, there: RemotePort, consumer: Consumer[Any]
) -> str | None:
    """Return the instance name of the provider selected by the properties for a consumer."""
    wish = end(here, "required", consumer)
    selected = named.pop(wish, None)
    if selected is None:
        return None
    prefix = f"{there.instance}.port.{there.port}.provided."
    if not selected.startswith(prefix):
        raise ConnectorPropertyError(
            f"connector property {wish!r}: {selected!r} is not a provider of {there}"
        )
    return selected.rpartition(".")[2]
