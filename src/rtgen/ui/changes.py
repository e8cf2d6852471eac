"""The effects of a page's edits on the system's file; None for those that concern the run alone.

The run can differ from the file: a timeline, components and other processes change it, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from typing import TypeAlias

from msgspec.structs import replace

from rtgen.compiler.backends.profiles.rts_profile import InstancePorts
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import Connection, PortReference, System, SystemComponent
from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.system.joining import Connector, instances_of
from rtgen.runtime.system.system import System as RunningSystem
from rtgen.ui.documents.document import DocumentError
from rtgen.ui.documents.profile import Change, Profile
from rtgen.ui.edits import Edits

End: TypeAlias = tuple[str, str]
"""An instance and its port."""
NOWHERE = Span("", 1, 1, 1, 1)


def new_component(instance: str, type_: str) -> SystemComponent:
    """Return the model of a component that is not in the file."""
    return SystemComponent(
        instance=instance, type=type_, id="", path_uri="", span=NOWHERE
    )


def ends_of(connector: Connector) -> tuple[End, End]:
    """Return the ends of a connection."""
    source, target = instances_of(connector)
    return (
        (source, str(connector.source).removeprefix(f"{source}.")),
        (target, str(connector.target).removeprefix(f"{target}.")),
    )


def ports_of(system: RunningSystem, instance: str) -> InstancePorts:
    """Return the port names of a component."""
    component = system.component(instance)
    services = (port for port, _ in (*component.providers, *component.consumers))
    return InstancePorts(
        (*component.in_ports, *component.out_ports), (*dict.fromkeys(services),)
    )


class Changes:
    """Translates edits of a run to changes of its file, which `edits` has."""

    def __init__(self, edits: Edits, profile: System, system: RunningSystem) -> None:
        """Set up with the system that was assembled from the file, before time passes."""
        self._edits = edits
        self._profile = profile
        self._joined = {each.name: ends_of(each) for each in system.connectors}
        self._sets: dict[str, frozenset[str]] = {}
        for instance in system.instances:
            self._enter_sets(system, instance)

    @property
    def written(self) -> System:
        """The system of the file with all edits; as opened if they cannot be written."""
        try:
            return self._edits.system
        except DocumentError:
            return self._profile

    def component(self, instance: str) -> SystemComponent | None:
        """Return a component of the file."""
        components = self.written.components
        return next((c for c in components if c.instance == instance), None)

    def connection(self, name: str, ends: Sequence[End]) -> Connection | None:
        """Return the connection of the file that joins two ports, preferably one of that name."""
        joining = [
            (each.name != name, ends_of_each != tuple(ends), each)
            for each in self.written.connections
            if {*(ends_of_each := self._ends(each))} == {*ends}
        ]
        return min(joining, key=lambda each: each[:2])[2] if joining else None

    def _ends(self, connection: Connection) -> tuple[End, ...]:
        stated = connection.source, connection.target
        ends = self._joined.get(connection.name)
        if ends is not None and {e.instance for e in stated} == {e[0] for e in ends}:
            return ends
        return tuple((each.instance, each.port) for each in stated)

    def add(self, component: SystemComponent, system: RunningSystem) -> Change | None:
        """Return the effect of adding a component, which the system has."""
        profile = system.component(component.instance).profile
        parts = profile.vendor, profile.category, component.type, profile.version
        component_added = replace(component, id=f"RTC:{':'.join(parts)}")
        self._enter_sets(system, component.instance)
        ports = ports_of(system, component.instance)
        return lambda file: file.add(component_added, ports)

    def _enter_sets(self, system: RunningSystem, instance: str) -> None:
        sets = system.component(instance).configuration_sets
        self._sets[instance] = frozenset(sets.ids)

    def remove(self, instance: str) -> Change | None:
        """Return the effect of removing a component."""
        exists = self.component(instance) is not None
        return (lambda file: file.remove(instance)) if exists else None

    def move(self, instance: str, place: tuple[float, float]) -> Change | None:
        """Return the effect of moving a component."""
        x, y = map(round, place)
        exists = self.component(instance) is not None
        return (lambda file: file.move(instance, x, y)) if exists else None

    def configure(
        self, instance: str, set_id: str, parameter: str, text: str
    ) -> Change | None:
        """Return the effect of setting a parameter."""
        exists = self.component(instance) is not None
        if not exists:
            return None
        return lambda file: file.configure(instance, set_id, parameter, text)

    def activate_set(
        self, instance: str, set_id: str, values: Mapping[str, str]
    ) -> Change | None:
        """Return the effect of activating a set; `values` are those that it has now."""
        component = self.component(instance)
        if component is None:
            return None
        missing = set_id not in self._sets.get(instance, ())
        stated = tuple(values.items()) if missing else ()
        return lambda file: file.activate_set(instance, set_id, stated)

    def connect(
        self, connector: Connector, properties: Mapping[str, str]
    ) -> Change | None:
        """Return the effect of making a connection with these properties."""
        ends = ends_of(connector)
        stated = dict(properties)
        is_data = isinstance(connector, DataConnector)
        if isinstance(connector, DataConnector):
            type_ = connector.source.type._descriptor_.repository_id
            stated.setdefault("dataport.data_type", type_)
        return self.join(connector.name, ends, stated, service=not is_data)

    def join(
        self,
        name: str,
        ends: Sequence[End],
        properties: Mapping[str, str],
        *,
        service: bool,
        added: Iterable[str] = (),
    ) -> Change | None:
        """Return the effect of making a connection; `added` are instances that the file gets."""
        instances = {*added, *(c.instance for c in self.written.components)}
        if not {instance for instance, _ in ends} <= instances:
            return None
        if self.connection(name, ends) is not None:
            return None
        taken = {each.name for each in self.written.connections}
        names = (name if n == 1 else f"{name}_{n}" for n in count(1))
        free = next(each for each in names if each not in taken)
        source, target = (PortReference(instance=i, port=p) for i, p in ends)
        connection = Connection(
            name=free,
            id=free,
            source=source,
            target=target,
            properties=tuple(properties.items()),
            service=service,
            span=NOWHERE,
        )
        return lambda file: file.connect(connection)

    def adjust(
        self, name: str, ends: Sequence[End], properties: Mapping[str, str]
    ) -> Change | None:
        """Return the effect of other properties of the connection of two ports."""
        connection = self.connection(name, ends)
        if connection is None:
            return None
        connection_name = connection.name
        return lambda file: file.adjust(connection_name, properties)

    def cut(self, name: str, ends: Sequence[End]) -> Change | None:
        """Return the effect of cutting the connection of two ports."""
        connection = self.connection(name, ends)
        if connection is None:
            return None
        connection_name = connection.name
        return lambda file: file.cut(connection_name)


def together(changes: Iterable[Change | None]) -> Change | None:
    """Return several changes as one; None without any."""
    parts = [each for each in changes if each is not None]

    def change(file: Profile) -> None:
        for each in parts:
            each(file)

    return change if parts else None


def unwritten(_: Profile) -> None:
    """Leave the file as it is: what is saved is not derived from one."""
