"""The content of the file of a session: the file with all edits, or the present system.

A session without a file saves the components of this and other processes as they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain, count
from typing import Any

from msgspec.structs import replace

from rtgen.compiler.backends.profiles.rts_profile import InstancePorts, system_text
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.profiles import profile_yaml
from rtgen.compiler.frontends.profiles.profile_yaml import YAML_SUFFIXES
from rtgen.compiler.model import Connection, PortReference, System, SystemComponent
from rtgen.facts.openrtm_ports import FOREIGN, KIND, foreign_instances
from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.system.joining import Connector
from rtgen.ui.changes import (
    NOWHERE,
    End,
    ends_of,
    new_component,
    ports_of,
    together,
)
from rtgen.ui.description import properties_of
from rtgen.ui.documents.profile import Change
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import restored
from rtgen.ui.session import Session


def content(session: Session, file: str) -> tuple[bytes, System]:
    """Return the content of a file to save, and the system in it.

    Raises DocumentError, UnquotableError.
    """
    if session.is_new:
        profile = profile_now(session)
        return text(session, profile, file).encode(), profile
    return session.edits.octets(file), session.edits.system


def component_now(session: Session, instance: str) -> SystemComponent:
    """Return a component with its current configuration and place."""
    component = session.system.component(instance)
    by_instance = {each.instance: each for each in session.profile.components}
    profile, sets = component.profile, component.configuration_sets
    before = by_instance.get(instance) or new_component(instance, profile.type_name)
    informing = tuple(each for each in before.configuration if each[0][:2] == "__")
    return replace(
        before,
        id=before.id
        or f"RTC:{profile.vendor}:{profile.category}:{profile.type_name}:{profile.version}",
        kind=profile.kind_of_context.name,
        active_set=sets.active,
        configuration=tuple(
            (set_id, tuple(sets.texts(set_id).items())) for set_id in sets.ids
        )
        + informing,
        location=_location(session, instance, before),
    )


def profile_now(session: Session) -> System:
    """Return the system with its present components and connections.

    Components of other processes become foreign ones (docs/corba.md). Those of the file that no
    naming service has now are kept, with their connections.
    """
    system = session.system
    by_name = {each.name: each for each in session.profile.connections}
    names = _remote_names(session)
    absent = _absent(session, names)
    instances = {*system.instances, *names.values(), *(c.instance for c in absent)}
    lost = {each.instance for each in absent}
    return replace(
        session.profile,
        components=(
            *(component_now(session, each) for each in system.instances),
            *(_remote_component(session, *each) for each in names.items()),
            *absent,
        ),
        connections=(
            *(_connection(each, by_name.get(each.name)) for each in session.connectors),
            *(
                _remote_connection(each, names)
                for each in session.remote.connections.values()
            ),
            *(
                each
                for each in by_name.values()
                if lost & {each.source.instance, each.target.instance}
            ),
        ),
        activation=tuple(
            step for step in session.profile.activation if step.instance in instances
        ),
        properties=_properties(session, (*names.values(), *lost)),
    )


def _remote_names(session: Session) -> dict[str, str]:
    """Return the names of components of other processes in the file, by those on the page."""
    before = {each.path_uri: each.instance for each in session.profile.components}
    taken = {*session.system.instances, *before.values()}
    names = {}
    for instance in session.remote.components:
        name = before.get(_path(instance), "")
        if not name:
            last = instance.rpartition("/")[2]
            numbered = (f"{last}_{number}" for number in count(2))
            name = next(each for each in chain([last], numbered) if each not in taken)
        taken.add(name)
        names[instance] = name
    return names


def _path(instance: str) -> str:
    return f"{instance}.{KIND}"


def _absent(session: Session, names: Mapping[str, str]) -> list[SystemComponent]:
    """Return the components of other processes that are in the file and in no naming service."""
    foreign = foreign_instances(session.profile.properties)
    return [
        each
        for each in session.profile.components
        if each.instance in foreign and each.instance not in names.values()
    ]


def _properties(
    session: Session, foreign: Iterable[str]
) -> tuple[tuple[str, str], ...]:
    properties = [each for each in session.profile.properties if each[0] != FOREIGN]
    stated = ", ".join(foreign)
    return (*properties, *([(FOREIGN, stated)] if stated else []))


def _remote_component(session: Session, instance: str, name: str) -> SystemComponent:
    component = session.remote.components[instance]
    by_instance = {each.instance: each for each in session.profile.components}
    before = by_instance.get(name) or new_component(name, component.type)
    profile = (component.vendor, component.category, component.type, component.version)
    return replace(
        before,
        id=before.id or f"RTC:{':'.join(profile)}",
        path_uri=_path(instance),
        active_set=component.active_set or before.active_set,
        configuration=tuple(
            (each.name, tuple((v.name, v.text) for v in each.values))
            for each in component.configuration_sets
        ),
        location=_location(session, instance, before),
    )


def _location(
    session: Session, instance: str, before: SystemComponent
) -> tuple[int, int, int, int] | None:
    place = session.places.get(instance)
    if place is None:
        return None
    width, height = before.location[2:] if before.location is not None else (-1, -1)
    return round(place[0]), round(place[1]), width, height


def _remote_connection(
    connection: ui.Connection, names: Mapping[str, str]
) -> Connection:
    source, target = (
        PortReference(instance=names.get(each.instance, each.instance), port=each.port)
        for each in (connection.source, connection.target)
    )
    properties = {each.name: each.text for each in restored(connection.properties)}
    return Connection(
        name=f"{source}_{target}",
        id=connection.name.rpartition(" ")[2],
        source=source,
        target=target,
        properties=tuple(properties.items()),
        service="dataport.data_type" not in properties,
        span=NOWHERE,
    )


def text(session: Session, profile: System, file: str) -> str:
    """Return the RtsProfile of the current system; YAML if the file has that suffix."""
    system = session.system
    ports = {instance: ports_of(system, instance) for instance in system.instances}
    for instance, name in _remote_names(session).items():
        ports[name] = _remote_ports(session, instance)
    for each in profile.components:
        ports.setdefault(each.instance, _stated_ports(profile, each.instance))
    written = str(system_text(profile, ports))
    if file.lower().endswith(YAML_SUFFIXES):
        return profile_yaml.to_yaml(located_xml.parse(written, file))
    return written


def _remote_ports(session: Session, instance: str) -> InstancePorts:
    kinds: dict[bool, list[str]] = {True: [], False: []}
    for port in session.remote.components[instance].ports:
        kinds[port.kind is ui.PortKind.PORT_SERVICE].append(port.name)
    return InstancePorts(tuple(kinds[False]), tuple(kinds[True]))


def remote_move(
    session: Session, instance: str, place: tuple[float, float]
) -> Change | None:
    """Return the effect of moving a component of another process on the file."""
    name, component = _foreign(session, instance)
    x, y = map(round, place)
    return together((component, lambda file: file.move(name, x, y)))


def remote_effect(session: Session, command: ui.Command) -> Change | None:
    """Return the effect of a command for components of other processes on the file.

    It is computed before the command is executed. Components that the file lacks are added to it.
    """
    value: Any = command.value
    match command.discriminator:
        case ui.CommandKind.COMMAND_SET:
            name, component = _foreign(session, value.instance)
            set_id = value.set or session.remote.components[value.instance].active_set
            parameter, text = value.parameter, value.text
            return together(
                (component, lambda file: file.configure(name, set_id, parameter, text))
            )
        case ui.CommandKind.COMMAND_ACTIVATE_SET:
            name, component = _foreign(session, value.instance)
            set_id = value.set
            return together(
                (component, lambda file: file.activate_set(name, set_id, ()))
            )
        case ui.CommandKind.COMMAND_CONNECT:
            return _remote_wire(session, value)
        case ui.CommandKind.COMMAND_CUT:
            wire = session.remote.connections[value]
            ends = [_written_end(session, e) for e in (wire.source, wire.target)]
            return session.changes.cut(value, ends)
    return None


def _foreign(session: Session, instance: str) -> tuple[str, Change | None]:
    """Return the name of a component in the file, and the change that adds it, if it lacks it."""
    if instance not in session.remote.components:
        return instance, None
    name = _remote_names(session)[instance]
    if session.changes.component(name) is not None:
        return name, None
    component = _remote_component(session, instance, name)
    ports = _remote_ports(session, instance)
    return name, lambda file: file.add_foreign(component, ports)


def _remote_wire(session: Session, command: ui.Connect) -> Change | None:
    pairs = [_foreign(session, e.instance) for e in (command.source, command.target)]
    ends = [_written_end(session, each) for each in (command.source, command.target)]
    properties = {each.name: each.text for each in command.properties}
    ports = map(session.remote.port, (command.source, command.target))
    types = [each.type for each in ports if each is not None]
    service = not any(types)
    if not service:
        type_ = next(filter(None, types)).replace("::", "/")
        properties.setdefault("dataport.data_type", f"IDL:{type_}:1.0")
    name = "_".join(f"{instance}.{port}" for instance, port in ends)
    joined = session.changes.join(
        command.name or name,
        ends,
        properties,
        service=service,
        added=[name for name, _ in pairs],
    )
    return together((*(change for _, change in pairs), joined))


def _written_end(session: Session, address: ui.PortAddress) -> End:
    name, _ = _foreign(session, address.instance)
    return name, address.port


def _stated_ports(profile: System, instance: str) -> InstancePorts:
    """Return the ports of a component that are connected."""
    ports: dict[bool, dict[str, None]] = {True: {}, False: {}}
    for each in profile.connections:
        for end in (each.source, each.target):
            if end.instance == instance:
                ports[each.service][end.port] = None
    return InstancePorts(tuple(ports[False]), tuple(ports[True]))


def _connection(connector: Connector, before: Connection | None) -> Connection:
    if before is not None:
        return before
    source, target = (
        PortReference(instance=instance, port=port)
        for instance, port in ends_of(connector)
    )
    properties = dict(properties_of(connector))
    if isinstance(connector, DataConnector):
        type_ = connector.source.type._descriptor_.repository_id
        properties.setdefault("dataport.data_type", type_)
    return Connection(
        name=connector.name,
        id=connector.name,
        source=source,
        target=target,
        properties=tuple(properties.items()),
        service=not isinstance(connector, DataConnector),
        span=NOWHERE,
    )
