"""Service connections: matches consumers and providers of two service ports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rtgen.facts.connector_properties import SERVICE, STRICTNESS, is_pair
from rtgen.runtime.errors import (
    ConnectionLimitError,
    ConnectorPropertyError,
    DuplicateConnectionError,
    PolarityError,
    PortTypeError,
)
from rtgen.runtime.marshalling.comparison import difference
from rtgen.runtime.marshalling.descriptors import lineage
from rtgen.runtime.ports.connector_properties import check
from rtgen.runtime.services.ports import Carrier, Consumer, Provider, ServicePort
from rtgen.runtime.services.transports import Transport

Pair = tuple[Consumer[Any], Provider[Any]]


class ServiceConnector:
    """A connection of service ports; `pairs` are the matched consumers and providers."""

    def __init__(
        self,
        name: str,
        source: ServicePort,
        target: ServicePort,
        properties: Mapping[str, str],
        transport: Transport | None = None,
    ) -> None:
        self.name = name
        self.source = source
        self.target = target
        self.properties = dict(properties)
        self._transport = transport
        self.connected = False
        self.pairs = _pairs(source, target, properties)

    def __repr__(self) -> str:
        return f"<ServiceConnector {self.name}: {self.source} -- {self.target}>"

    def attach(self) -> None:
        """Establish the connection, so that calls reach the providers."""
        self.connected = True
        for consumer, provider in self.pairs:
            consumer._provider = self._carrier(consumer, provider)
            provider.connections += 1

    def detach(self) -> None:
        """Remove the connection; later calls raise ObjectNotExist."""
        self.connected = False
        for consumer, provider in self.pairs:
            consumer._provider = None
            provider.connections -= 1

    def _carrier(self, consumer: Consumer[Any], provider: Provider[Any]) -> Carrier:
        if self._transport is None:
            return provider
        return self._transport.carrier_of(consumer.interface, provider)


def _pairs(
    source: ServicePort, target: ServicePort, properties: Mapping[str, str]
) -> tuple[Pair, ...]:
    named, strict = read_properties(properties)
    pairs: list[Pair] = []
    lonely: list[str] = []
    for here, there in ((source, target), (target, source)):
        for consumer in here.consumers:
            provider = _partner(consumer, here, there, named)
            if provider is None:
                lonely.append(str(consumer))
            else:
                pairs.append((consumer, provider))
    if named:
        unknown = next(iter(named))
        raise ConnectorPropertyError(
            f"connector property {unknown!r} names no consumer"
        )
    if not pairs:
        raise _mismatch(source, target)
    if strict and lonely:
        raise PortTypeError(f"strict connection: no provider for {', '.join(lonely)}")
    for consumer, provider in pairs:
        if consumer.connected:
            raise DuplicateConnectionError(f"{consumer} is connected already")
        consumers = sum(other is provider for _, other in pairs)
        if (
            provider.limit is not None
            and provider.connections + consumers > provider.limit
        ):
            raise ConnectionLimitError(
                f"{provider} serves at most {provider.limit} at a time"
            )
    return tuple(pairs)


def read_properties(properties: Mapping[str, str]) -> tuple[dict[str, str], bool]:
    """Return the pairs selected by properties, consumer to provider, and whether all must match.

    Raises ConnectorPropertyError.
    """
    named = {key: text for key, text in properties.items() if is_pair(key)}
    check({k: t for k, t in properties.items() if k not in named}, SERVICE)
    strictness = properties.get(STRICTNESS, "best_effort").strip()
    return named, strictness == "strict"


def _partner(
    consumer: Consumer[Any],
    here: ServicePort,
    there: ServicePort,
    named: dict[str, str],
) -> Provider[Any] | None:
    """Return the provider for a consumer.

    It is selected by a property, else of equal instance name and type, else the only one of the
    type for the only consumer.
    """
    wish = end(here, "required", consumer)
    if wish in named:
        selected = named.pop(wish)
        for provider in there.providers:
            if end(there, "provided", provider) == selected:
                _check_interfaces(consumer, provider)
                return provider
        raise ConnectorPropertyError(
            f"connector property {wish!r}: {selected!r} is not a provider"
        )
    fitting = [p for p in there.providers if _interface_difference(consumer, p) is None]
    for provider in fitting:
        if provider.instance == consumer.instance:
            return provider
    same_interface = [c for c in here.consumers if c.interface is consumer.interface]
    return fitting[0] if len(fitting) == len(same_interface) == 1 else None


def end(
    port: ServicePort, polarity: str, interface: Consumer[Any] | Provider[Any]
) -> str:
    """Return the name of an interface in properties; polarity: `provided` or `required`."""
    type_ = interface.interface._descriptor_.name
    return f"{port.instance}.port.{port.port}.{polarity}.{type_}.{interface.instance}"


def _interface_difference(
    consumer: Consumer[Any], provider: Provider[Any]
) -> str | None:
    """Return why the provider's interface is not, and does not derive from, the consumer's.

    None if it is or does.
    """
    required, offered = consumer.interface._descriptor_, provider.interface._descriptor_
    line = lineage(offered).values()
    if any(difference(required, ancestor) is None for ancestor in line):
        return None
    return difference(required, offered)


def _check_interfaces(consumer: Consumer[Any], provider: Provider[Any]) -> None:
    differs = _interface_difference(consumer, provider)
    if differs is not None:
        raise PortTypeError(
            f"{consumer} and {provider} have different interfaces\n{differs}"
        )


def _mismatch(
    source: ServicePort, target: ServicePort
) -> PolarityError | PortTypeError:
    for here, there in ((source, target), (target, source)):
        if here.consumers and there.providers:
            consumer, provider = here.consumers[0], there.providers[0]
            differs = _interface_difference(consumer, provider)
            if differs is None:
                return PortTypeError(
                    f"{source} and {target}: no instance names agree, and more than one "
                    f"provider or consumer has the type of {consumer}"
                )
            return PortTypeError(
                f"{consumer} and {provider} have different interfaces\n{differs}"
            )
    polarity = "provide" if source.providers else "require"
    return PolarityError(
        f"{source} and {target} both only {polarity}; a connection needs one end of each"
    )
