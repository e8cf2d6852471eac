"""Prints systems as RtsProfile: the XML of RT System Editor and rtshell, format version 0.2.

Element and attribute order are those of the schema. Elements required by rtsprofile 4.1 are
always present: an abstract, dates, an execution context for each component, composite type
`None`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from msgspec.structs import replace

from rtgen.backends.kit.rendering import render
from rtgen.model import Connection, PortReference, System

_ATTRIBUTES = {
    "dataport.data_type": "",
    "dataport.interface_type": "corba_cdr",
    "dataport.dataflow_type": "push",
    "dataport.subscription_type": "flush",
}
"""Properties that are attributes of a connector, with their defaults."""

_COLUMNS, _STEP = 4, (240, 160)
"""Position of components without a location."""


@dataclass(frozen=True, slots=True)
class InstancePorts:
    """The names of an instance's ports, without the instance."""

    data: tuple[str, ...] = ()
    service: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _End:
    id: str
    instance: str
    port: str


@dataclass(frozen=True, slots=True)
class _Connector:
    id: str
    name: str
    service: bool
    source: _End
    target: _End
    type: str
    interface: str
    dataflow: str
    subscription: str
    properties: tuple[tuple[str, str], ...]


def system_text(
    system: System,
    ports: Mapping[str, InstancePorts] | None = None,
    header: Sequence[str] = (),
) -> str:
    """The system as XML; `ports` by instance, by default the connected ones.

    Connectors and components keep the order of the system. The activation order is written
    separately; the steps of one instance after another follow it.
    """
    ids = {c.instance: c.id for c in system.components}
    components = [
        replace(
            c,
            location=c.location or _place(number),
            path_uri=c.path_uri or f"localhost/{c.instance}.rtc",
        )
        for number, c in enumerate(system.components)
    ]
    return render(
        "rts_profile/system.xml.j2",
        header=header,
        system=replace(system, id=system.id or f"RTSystem:rtgen:{system.name}:1.0.0"),
        components=components,
        ports=connected_ports(system) if ports is None else ports,
        connectors=[_connector(c, ids) for c in system.connections],
        steps=system.activation,
        ids=ids,
    )


def connected_ports(system: System) -> dict[str, InstancePorts]:
    """The ports that the connectors name, by instance."""
    found: dict[str, tuple[dict[str, None], dict[str, None]]] = {
        c.instance: ({}, {}) for c in system.components
    }
    for connection in system.connections:
        for end in (connection.source, connection.target):
            found[end.instance][connection.service].setdefault(end.port)
    return {
        instance: InstancePorts(tuple(data), tuple(service))
        for instance, (data, service) in found.items()
    }


def _place(number: int) -> tuple[int, int, int, int]:
    row, column = divmod(number, _COLUMNS)
    return (40 + column * _STEP[0], 60 + row * _STEP[1], -1, -1)


def _connector(connection: Connection, ids: Mapping[str, str]) -> _Connector:
    def end(reference: PortReference) -> _End:
        return _End(ids[reference.instance], reference.instance, reference.port)

    given = dict(connection.properties)
    data_type, interface, dataflow, subscription = (
        given.get(key, default) for key, default in _ATTRIBUTES.items()
    )
    return _Connector(
        id=connection.id or connection.name,
        name=connection.name,
        service=connection.service,
        source=end(connection.source),
        target=end(connection.target),
        type=data_type,
        interface=interface,
        dataflow=dataflow,
        subscription=subscription,
        properties=tuple(p for p in given.items() if p[0] not in _ATTRIBUTES),
    )
