"""The elements of an RtsProfile.

Element and attribute order are those of the schema. Elements required by rtsprofile 4.1 are always
present: an abstract, dates, an execution context for each component, composite type `None`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from rtgen.compiler.model import (
    Activation,
    Connection,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.model.profile_elements import (
    RTS,
    RTS_EXT,
    XSI,
    Name,
    ProfileElement,
)
from rtgen.facts.connector_properties import PROFILE_ATTRIBUTES

ATTRIBUTE_DEFAULTS = {
    "dataport.interface_type": "corba_cdr",
    "dataport.dataflow_type": "push",
    "dataport.subscription_type": "flush",
}
"""Values of the attributes of a connector without these properties."""

_COLUMNS, _STEP = 4, (240, 160)
"""Position of components without a location."""


@dataclass(frozen=True, slots=True)
class InstancePorts:
    """An instance's port names, without the instance."""

    data: tuple[str, ...] = ()
    service: tuple[str, ...] = ()


def profile_element(
    system: System, ports: Mapping[str, InstancePorts] | None
) -> ProfileElement:
    """Return the system as the root element of a profile; `ports` by instance."""
    ids = {c.instance: c.id for c in system.components}
    ports_of = _connected_ports(system) if ports is None else ports
    connections = sorted(system.connections, key=lambda each: each.service)
    children = [
        *(
            component_element(c, ports_of[c.instance], number)
            for number, c in enumerate(system.components)
        ),
        *(connector_element(each, ids) for each in connections),
    ]
    if system.activation:
        children.append(_element("Activation", {}, _steps(system.activation, ids)))
    attributes = {
        "id": system.id or f"RTSystem:rtgen:{system.name}:1.0.0",
        "version": "0.2",
        "abstract": system.abstract or system.name,
        "creationDate": system.created,
        "updateDate": system.updated,
    }
    children += _properties(system.properties)
    return _element("RtsProfile", attributes, children, "rts_profile_ext")


def _element(
    name: str,
    attributes: Mapping[str, str],
    children: Iterable[ProfileElement] = (),
    type_: str = "",
    *,
    visible: bool = False,
) -> ProfileElement:
    qualified: dict[Name, str] = {(XSI, "type"): f"rtsExt:{type_}"} if type_ else {}
    qualified |= {(RTS, key): value for key, value in attributes.items()}
    if visible:
        qualified[RTS_EXT, "visible"] = "true"
    return ProfileElement(
        name=(RTS, name), attributes=qualified, children=tuple(children)
    )


def _extension(name: str, attributes: Mapping[str, str]) -> ProfileElement:
    return ProfileElement(
        name=(RTS_EXT, name),
        attributes={(RTS_EXT, key): value for key, value in attributes.items()},
    )


def _properties(pairs: Iterable[tuple[str, str]]) -> Iterator[ProfileElement]:
    for name, value in pairs:
        yield _extension("Properties", {"name": name, "value": value})


def component_element(
    c: SystemComponent, ports: InstancePorts, number: int
) -> ProfileElement:
    """Return the element of a component; `number` places one that has no location."""
    row, column = divmod(number, _COLUMNS)
    place = c.location or (40 + column * _STEP[0], 60 + row * _STEP[1], -1, -1)
    names = ("x", "y", "width", "height")
    location = dict(zip(names, map(str, place), strict=True))
    rate = {} if c.rate is None else {"rate": str(c.rate)}
    kinds = (
        ("DataPorts", "dataport_ext", ports.data),
        ("ServicePorts", "serviceport_ext", ports.service),
    )
    return _element(
        "Components",
        {
            "id": c.id,
            "instanceName": c.instance,
            "pathUri": c.path_uri or f"localhost/{c.instance}.rtc",
            "compositeType": "None",
            "isRequired": "true" if c.required else "false",
            "activeConfigurationSet": c.active_set,
        },
        [
            *(
                _element(
                    kind, {"name": f"{c.instance}.{port}"}, (), type_, visible=True
                )
                for kind, type_, listed in kinds
                for port in listed
            ),
            *(
                _element(
                    "ConfigurationSets",
                    {"id": set_id},
                    (
                        _element("ConfigurationData", {"name": name, "data": text})
                        for name, text in values
                    ),
                )
                for set_id, values in c.configuration
            ),
            _element(
                "ExecutionContexts",
                {"id": "0", "kind": c.kind, **rate},
                (),
                "execution_context_ext",
            ),
            _extension("Location", {**location, "direction": "RIGHT"}),
        ],
        "component_ext",
        visible=True,
    )


def connector_element(connection: Connection, ids: Mapping[str, str]) -> ProfileElement:
    """Return the element of a connection; `ids` are those of the components, by instance."""
    properties = dict(connection.properties)
    attributes = {
        "connectorId": connection.id or connection.name,
        "name": connection.name,
    }
    kind = "Service" if connection.service else "Data"
    if not connection.service:
        for key, attribute in PROFILE_ATTRIBUTES.items():
            attributes[attribute] = properties.pop(key, ATTRIBUTE_DEFAULTS.get(key, ""))

    def end(name: str, reference: PortReference) -> ProfileElement:
        instance = reference.instance
        parts = {
            "componentId": ids[instance],
            "instanceName": instance,
            "portName": f"{instance}.{reference.port}",
        }
        return _element(f"{name}{kind}Port", parts, (), "target_port_ext")

    return _element(
        f"{kind}PortConnectors",
        attributes,
        [
            end("source", connection.source),
            end("target", connection.target),
            *_properties(properties.items()),
        ],
        f"{kind.lower()}port_connector_ext",
        visible=True,
    )


def _steps(
    steps: Iterable[Activation], ids: Mapping[str, str]
) -> Iterator[ProfileElement]:
    def component(name: str, instance: str) -> ProfileElement:
        parts = {"componentId": ids[instance], "instanceName": instance, "id": "0"}
        return _element(name, parts)

    for number, step in enumerate(steps, 1):
        if step.after:
            condition = _element(
                "Preceding",
                {"timeout": "0", "sendingTiming": "SYNC"},
                (component("PrecedingComponents", each) for each in step.after),
            )
        else:
            condition = _element("WaitTime", {"waitTime": str(step.wait_ms)})
        yield _element(
            "targets",
            {"sequence": str(number)},
            [condition, component("TargetComponent", step.instance)],
            "condition_ext",
        )


def _connected_ports(system: System) -> dict[str, InstancePorts]:
    """Return the ports in connectors, by instance."""
    ports: dict[str, tuple[dict[str, None], dict[str, None]]] = {
        c.instance: ({}, {}) for c in system.components
    }
    for connection in system.connections:
        for end in (connection.source, connection.target):
            ports[end.instance][connection.service].setdefault(end.port)
    return {
        instance: InstancePorts(tuple(data), tuple(service))
        for instance, (data, service) in ports.items()
    }
