"""The system of a session as a model, and as the text of an RtsProfile."""

from __future__ import annotations

from msgspec.structs import replace

from rtgen.backends.rts_profile import InstancePorts, system_text
from rtgen.diagnostics import Span
from rtgen.frontends import profile_yaml
from rtgen.frontends.kit import located_xml
from rtgen.frontends.profile_yaml import YAML_SUFFIXES
from rtgen.model import Connection, PortReference, System, SystemComponent
from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.system.joining import Connector, instances_of
from rtgen.ui.description import properties_of
from rtgen.ui.session import Session

_NOWHERE = Span("", 1, 1, 1, 1)


def new_component(instance: str, type_: str) -> SystemComponent:
    """A component that no file has."""
    return SystemComponent(
        instance=instance, type=type_, id="", path_uri="", span=_NOWHERE
    )


def component_now(session: Session, instance: str) -> SystemComponent:
    """A component with the configuration and the place that it has now."""
    component = session.system.component(instance)
    known = {each.instance: each for each in session.profile.components}
    profile, sets = component.profile, component.configuration_sets
    before = known.get(instance) or new_component(instance, profile.type_name)
    informing = tuple(each for each in before.configuration if each[0][:2] == "__")
    place = session.places.get(instance)
    size = before.location[2:] if before.location is not None else (-1, -1)
    return replace(
        before,
        id=before.id
        or f"RTC:{profile.vendor}:{profile.category}:{profile.type_name}:{profile.version}",
        active_set=sets.active,
        configuration=tuple(
            (set_id, tuple(sets.texts(set_id).items())) for set_id in sets.ids
        )
        + informing,
        location=None if place is None else (round(place[0]), round(place[1]), *size),
    )


def profile_now(session: Session) -> System:
    """The system with its components and connections as they are now."""
    system = session.system
    known = {each.name: each for each in session.profile.connections}
    instances = set(system.instances)
    return replace(
        session.profile,
        components=tuple(component_now(session, each) for each in system.instances),
        connections=tuple(
            _connection(each, known.get(each.name)) for each in session.connectors
        ),
        activation=tuple(
            step for step in session.profile.activation if step.instance in instances
        ),
    )


def text(session: Session, file: str) -> str:
    """The RtsProfile of the system as it is now, in YAML if the file's suffix says so."""
    ports = {}
    for instance in session.system.instances:
        component = session.system.component(instance)
        data = (*component.in_ports, *component.out_ports)
        services = dict.fromkeys(
            port for port, _ in (*component.providers, *component.consumers)
        )
        ports[instance] = InstancePorts(data, tuple(services))
    written = str(system_text(profile_now(session), ports))
    if file.lower().endswith(YAML_SUFFIXES):
        return profile_yaml.to_yaml(located_xml.parse(written, file))
    return written


def _connection(connector: Connector, before: Connection | None) -> Connection:
    if before is not None:
        return before
    source, target = instances_of(connector)
    properties = dict(properties_of(connector))
    is_data = isinstance(connector, DataConnector)
    if isinstance(connector, DataConnector):
        type_ = connector.source.type._descriptor_.repository_id
        properties.setdefault("dataport.data_type", type_)
    return Connection(
        name=connector.name,
        id=connector.name,
        source=_end(source, connector.source),
        target=_end(target, connector.target),
        properties=tuple(properties.items()),
        service=not is_data,
        span=_NOWHERE,
    )


def _end(instance: str, port: object) -> PortReference:
    return PortReference(instance=instance, port=str(port).removeprefix(f"{instance}."))
