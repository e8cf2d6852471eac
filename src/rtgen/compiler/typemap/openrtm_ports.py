"""Names of ports on OpenRTM, and their mapping to the definition's names.

OpenRTM has one name space for all ports of a component, and only keeps the part of a name after its
last dot (`PortBase.setOwner`). Profiles written by its tools use these names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from msgspec.structs import replace

from rtgen.compiler.model import (
    Component,
    Connection,
    Port,
    PortKind,
    PortReference,
    System,
)
from rtgen.facts.openrtm_ports import (
    IN,
    OUT,
    SERVICE,
    Key,
    known_name,
    registered_names,
)

OPENRTM_NAME = "openrtm_name"
"""The annotation that sets a port's name."""

_WAYS = {PortKind.INPORT: IN, PortKind.OUTPORT: OUT}
_POLARITIES = {PortKind.PROVIDER: "provided", PortKind.CONSUMER: "required"}


def key_of(port: Port) -> Key:
    """Return the key of a port; the interfaces of a service port share it."""
    way = _WAYS.get(port.kind, SERVICE)
    return way, port.port if way == SERVICE else port.name


def chosen_name(port: Port) -> str:
    """Return the name given by annotation; empty without one."""
    annotation = port.annotation(OPENRTM_NAME)
    value = None if annotation is None else annotation.get()
    return value if isinstance(value, str) else ""


def names_of(component: Component) -> dict[Key, str]:
    """Return registration names for the ports of a component."""
    chosen: dict[Key, str] = {}
    for port in component.ports:
        if name := chosen_name(port):
            chosen.setdefault(key_of(port), name)
    return registered_names(map(key_of, component.ports), chosen)


@dataclass(frozen=True, slots=True)
class InstancePorts:
    """The ports of an instance: registration names, and types of the interfaces.

    `interfaces` is by port, polarity (`provided`, `required`) and instance name.
    """

    registered: Mapping[Key, str]
    interfaces: Mapping[tuple[str, str, str], str]


_NOTHING = InstancePorts({}, {})


def ports_of(component: Component) -> InstancePorts:
    """Return the ports of the instances of a component."""
    return InstancePorts(
        names_of(component),
        {
            (port.port, _POLARITIES[port.kind], port.instance): (
                port.type_name or str(port.type)
            )
            for port in component.ports
            if port.kind in _POLARITIES
        },
    )


def with_definition_names(
    system: System, instances: Mapping[str, InstancePorts]
) -> System:
    """Replace OpenRTM's names of ports and interfaces in a system by the definitions'."""
    connections = (_connection(c, instances) for c in system.connections)
    return replace(system, connections=tuple(connections))


def _connection(
    connection: Connection, instances: Mapping[str, InstancePorts]
) -> Connection:
    ways = (SERVICE, SERVICE) if connection.service else (OUT, IN)
    source, target = (
        _definition_end(end, way, instances)
        for end, way in zip((connection.source, connection.target), ways, strict=True)
    )
    if not connection.service:
        return replace(connection, source=source, target=target)
    keys = {
        text: _definition_key(text, (source, target), instances)
        for pair in connection.properties
        for text in pair
    }
    return replace(
        connection,
        source=source,
        target=target,
        properties=tuple((keys[k], keys[v]) for k, v in connection.properties),
        places={keys.get(key, key): span for key, span in connection.places.items()},
    )


def _aliases(registered: str) -> tuple[str, str]:
    """Return the names that files use for a port registered under a name."""
    return registered, known_name(registered)


def _definition_end(
    end: PortReference, way: str, instances: Mapping[str, InstancePorts]
) -> PortReference:
    ports = instances.get(end.instance, _NOTHING).registered
    if (way, end.port) in ports:
        return end
    for (kind, port), registered in ports.items():
        if kind == way and end.port in _aliases(registered):
            return replace(end, port=port)
    return end


def _definition_key(
    text: str, ends: Sequence[PortReference], instances: Mapping[str, InstancePorts]
) -> str:
    """Translate a key or value of a property if it names an interface of one of the ends.

    The type in the name is ignored: the other parts are unique, and files omit or include the
    type's scope.
    """
    for end in ends:
        ports = instances.get(end.instance, _NOTHING)
        registered = ports.registered.get((SERVICE, end.port), end.port)
        for alias in (end.port, *_aliases(registered)):
            prefix = f"{end.instance}.port.{alias}."
            if text.startswith(prefix):
                polarity, _, rest = text.removeprefix(prefix).partition(".")
                type_, _, name = rest.partition(".")
                type_ = ports.interfaces.get((end.port, polarity, name), type_)
                return f"{end.instance}.port.{end.port}.{polarity}.{type_}.{name}"
    return text
