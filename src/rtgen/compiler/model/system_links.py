"""Matches the connectors of a system with the definitions of its components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import msgspec

from rtgen.compiler.model.components import (
    Component,
    Connection,
    Port,
    PortKind,
    PortReference,
    System,
)
from rtgen.compiler.model.declarations import Interface

if TYPE_CHECKING:
    from rtgen.compiler.model import Model

DATA_KINDS = (PortKind.INPORT, PortKind.OUTPORT)


class Known(msgspec.Struct, frozen=True):
    """The definition of a component, and the model with its types."""

    component: Component
    model: Model


def known_components(models: Iterable[Model]) -> dict[str, Known]:
    """Return the components of models by type name; the first of each name is used."""
    components: dict[str, Known] = {}
    for model in models:
        for declaration in model.declarations:
            if isinstance(declaration, Component):
                components.setdefault(declaration.name[-1], Known(declaration, model))
    return components


def definitions_of(system: System, components: Mapping[str, Known]) -> dict[str, Known]:
    """Return the definitions of instances; one without is left out."""
    return {
        c.instance: components[c.type]
        for c in system.components
        if c.type in components
    }


class Pair(msgspec.Struct, frozen=True):
    """A consumer matched with a provider."""

    consumer_end: PortReference
    consumer: Port
    provider_end: PortReference
    provider: Port


def service_pairs(
    connection: Connection, ends: Mapping[str, Known]
) -> tuple[list[Pair], list[tuple[PortReference, Port]]]:
    """Match the consumers of a service connector with its providers, as the runtime does.

    A consumer's provider is the one selected by a property; else the one whose interface is, or
    derives from, the consumer's, with the same instance name; else the only one of the interface,
    if the consumer is the only one, too.
    """
    named = dict(connection.properties)
    pairs: list[Pair] = []
    lonely: list[tuple[PortReference, Port]] = []
    both = (connection.source, connection.target)
    for here, there in (both, both[::-1]):
        providers = [p for p in interfaces(there, ends) if p.kind is PortKind.PROVIDER]
        consumers = [p for p in interfaces(here, ends) if p.kind is PortKind.CONSUMER]
        for consumer in consumers:
            selected = named.get(interface_key(here, consumer))
            if selected is not None:
                fitting = [p for p in providers if interface_key(there, p) == selected]
            else:
                offered = ends[there.instance].model
                fitting = [p for p in providers if _serves(offered, p, consumer)]
                same_type = [c for c in consumers if c.type == consumer.type]
                same = [p for p in fitting if p.instance == consumer.instance]
                if same:
                    fitting = same[:1]
                elif len(same_type) > 1 or len(fitting) > 1:
                    fitting = []
            if fitting:
                pairs.append(Pair(here, consumer, there, fitting[0]))
            else:
                lonely.append((here, consumer))
    return pairs, lonely


def interface_key(end: PortReference, port: Port) -> str:
    """Return the name of an interface of a service port in a connector's properties."""
    polarity = "provided" if port.kind is PortKind.PROVIDER else "required"
    type_name = port.type_name or port.type
    return f"{end.instance}.port.{end.port}.{polarity}.{type_name}.{port.instance}"


def interfaces(end: PortReference, ends: Mapping[str, Known]) -> list[Port]:
    """Return the interfaces of the service port at one end."""
    ports = ends[end.instance].component.ports
    return [p for p in ports if p.kind not in DATA_KINDS and p.port == end.port]


def _serves(model: Model, provider: Port, consumer: Port) -> bool:
    """Return whether the provider's interface is, or derives from, the consumer's."""
    served = [str(model.unalias(provider.type))]
    declaration = model.declared(provider.type)
    if isinstance(declaration, Interface):
        served += [base.scoped for base in model.bases(declaration)]
    return str(consumer.type) in served
