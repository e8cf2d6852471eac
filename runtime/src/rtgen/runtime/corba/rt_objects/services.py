"""Service connections by IORs in the properties of a connector, as in OpenRTM."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
from omniORB import CORBA

from rtgen.facts.connector_properties import STRICTNESS
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.errors import DuplicateConnectionError, PortTypeError
from rtgen.runtime.services.ports import Carrier, Consumer, Provider, ServicePort
from rtgen.runtime.services.transports import RemotePort

_NONE = ("nil", "null")
"""Values of pairs for a consumer without provider."""


def type_names(end: Consumer[Any] | Provider[Any]) -> list[str]:
    """Return the possible names of an interface's type in other processes, its own first.

    Besides the scoped name there is the one without scope, under which many components register
    interfaces.
    """
    scoped: str = end.interface._descriptor_.name
    return [*filter(None, (end._type_name, scoped, scoped.rpartition("::")[2]))]


def descriptor(end: Consumer[Any] | Provider[Any]) -> str:
    """Return the name of an interface in connectors: type and instance."""
    return f"{type_names(end)[0]}.{end.instance}"


def offers(
    instance: str,
    port: str,
    providers: Mapping[Provider[Any], str],
) -> dict[str, str]:
    """Return a connector's properties that offer providers, given with their IORs.

    Besides OpenRTM's two names they use those of `type_names`.
    """
    found: dict[str, str] = {}
    for provider, ior in providers.items():
        name = descriptor(provider)
        found[f"{instance}.port.{port}.provided.{name}"] = ior
        found[f"port.{name}"] = ior
        for other in type_names(provider):
            found.setdefault(f"port.{other}.{provider.instance}", ior)
    return found


class ServiceLink(msgspec.Struct, eq=False):
    """A connection of a service port to a foreign one; `pairs` are consumers with providers."""

    name: str
    source: ServicePort
    target: RemotePort
    pairs: Mapping[Consumer[Any], Carrier]
    connected: bool = False

    def attach(self) -> None:
        """Establish the connection. Raises DuplicateConnectionError."""
        for consumer in self.pairs:
            if consumer.connected:
                raise DuplicateConnectionError(f"{consumer} is connected already")
        for consumer, carrier in self.pairs.items():
            consumer._provider = carrier
        self.connected = True

    def detach(self) -> None:
        """Remove the connection; later calls raise ObjectNotExist."""
        self.connected = False
        for consumer in self.pairs:
            consumer._provider = None


def link(
    name: str,
    source: ServicePort,
    port: str,
    properties: Mapping[str, str],
    objects: Objects,
    exported: Exported,
) -> ServiceLink:
    """Return the unestablished connection that a connector's properties describe for `port`.

    `properties` are those of the other end. Raises PortTypeError for a strict connection with a
    consumer that has no provider.
    """
    pairs: dict[Consumer[Any], Carrier] = {}
    for consumer in source.consumers:
        ior = _offered(consumer, source.instance, port, properties)
        if ior is None:
            ior = _only_one(consumer, properties, exported)
        reference = None if ior is None else exported.reference(ior)
        if reference is not None:
            pairs[consumer] = objects.remote(consumer.interface, reference)
        elif properties.get(STRICTNESS) == "strict" and ior not in _NONE:
            raise PortTypeError(f"strict connection: no provider for {consumer}")
    return ServiceLink(name, source, RemotePort("", name), pairs)


def _offered(
    consumer: Consumer[Any], instance: str, port: str, properties: Mapping[str, str]
) -> str | None:
    """Return the IOR in the properties for a consumer: by a pair, else by equal names."""
    required = f"{instance}.port.{port}.required.{descriptor(consumer)}"
    selected = properties.get(required)
    if selected is not None:
        return properties.get(selected, selected)
    keys = [f"port.{each}.{consumer.instance}" for each in type_names(consumer)]
    return next((properties[key] for key in keys if key in properties), None)


def _only_one(
    consumer: Consumer[Any], properties: Mapping[str, str], exported: Exported
) -> str | None:
    """Return the only offered provider of the consumer's interface at the other end."""
    identity = consumer.interface._descriptor_.repository_id
    iors = {text for text in properties.values() if text.startswith("IOR:")}
    fitting = []
    for ior in sorted(iors):
        reference = exported.reference(ior)
        try:
            if reference is not None and reference._is_a(identity):
                fitting.append(ior)
        except CORBA.SystemException:
            continue
    return fitting[0] if len(fitting) == 1 else None
