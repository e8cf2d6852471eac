"""RTObjects of a process, and their names in a naming service."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtgen.facts.openrtm_ports import (
    IN,
    KIND,
    OUT,
    SERVICE,
    known_name,
    registered_names,
)
from rtgen.facts.port_fitting import IN_PORT
from rtgen.runtime.corba.naming import Naming
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.component import RtObject
from rtgen.runtime.corba.rt_objects.ends import (
    PORT_TYPE,
    DataEnd,
    ServiceEnd,
    port_type,
)
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.port_ends import End
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.ports import Provider, ServicePort
from rtgen.runtime.system.joining import Connector
from rtgen.runtime.timing.guards import Guard

if TYPE_CHECKING:
    from rtgen.runtime.system.system import System


class RtObjects:
    """Publishes components as `<instance>.rtc`. Methods raise TransportError."""

    def __init__(self, orb: Orb, objects: Objects, naming: Naming) -> None:
        self.exported = Exported(orb)
        self.system: System | None = None
        self.ids: dict[str, str] = {}
        self._objects = objects
        self._naming = naming
        self._published: dict[str, RtObject] = {}
        self._waiting: list[RtObject] | None = None
        """Components that `publishing` will bind; None outside of it."""

    def publish(
        self, component: Component, references: Mapping[Provider[Any], Any]
    ) -> None:
        """Publish a component; `references` are the objects of its providers."""
        instance = component.instance_name
        ports = [
            PortService(self, instance, name, end)
            for name, end in self._ends(component, references)
        ]
        made = RtObject(component, ports, self.exported, self._published)
        self._published[instance] = made
        if self._waiting is None:
            self._bind(made)
        else:
            self._waiting.append(made)

    def _bind(self, made: RtObject) -> None:
        name = made.component.instance_name, KIND
        self._naming.bind_object(name, made.reference)

    @contextmanager
    def publishing(self) -> Iterator[None]:
        """See `PublishingTransport`."""
        waiting: list[RtObject] = []
        self._waiting = waiting
        try:
            yield
        finally:
            self._waiting = None
        for made in waiting:
            self._bind(made)

    def withdraw(self, instance: str) -> None:
        """Withdraw a component's name, then the component."""
        made = self._published.pop(instance, None)
        if made is not None:
            try:
                self._naming.unbind_object((instance, KIND), made.reference)
            finally:
                made.close()

    def port(self, end: InPort[Any] | OutPort[Any] | ServicePort) -> PortService | None:
        """Return the port service of a port; None after it was withdrawn."""
        place = (
            (end.instance, end.port)
            if isinstance(end, ServicePort)
            else (end.owner, end.name)
        )
        type_ = port_type(end)
        ports = self.ports_at(*place)
        return next((p for p in ports if p.end.properties[PORT_TYPE] == type_), None)

    def own(self, reference: Any) -> RtObject | PortService | None:
        """Return the component or port of this process for a reference; None if there is none."""
        found = self.exported.local(reference)
        return found if isinstance(found, RtObject | PortService) else None

    def ports_at(self, instance: str, port: str) -> list[PortService]:
        """Return a component's ports of that name; an InPort and an OutPort may share one."""
        made = self._published.get(instance)
        return [each for each in (made.ports if made else ()) if each.end.port == port]

    def at(self, connector: Connector) -> list[PortService]:
        """See `Ports`; the OutPort, or the first port of a service connection, comes first."""
        found = [
            port
            for made in tuple(self._published.values())
            for port in made.ports
            if port.end.has(connector)
        ]
        return sorted(found, key=lambda p: p.end.properties[PORT_TYPE] == IN_PORT)

    def give_up(self, place: str, reason: str) -> None:
        """See `Ports`."""
        for made in tuple(self._published.values()):
            for port in made.ports:
                port.lose_all(place, reason)

    def _guard(self) -> Guard:
        assert self.system is not None  # connections are made while it runs
        return self.system.clock.guard()

    def _ends(
        self, component: Component, references: Mapping[Provider[Any], Any]
    ) -> list[tuple[str, End]]:
        """Return the ports with OpenRTM's names."""
        services = [port for port, _ in (*component.providers, *component.consumers)]
        keys = [
            *((IN, name) for name in component.in_ports),
            *((OUT, name) for name in component.out_ports),
            *((SERVICE, name) for name in services),
        ]
        found: list[tuple[str, End]] = []
        for (way, name), registered in registered_names(keys).items():
            known = known_name(registered)
            end: End
            if way == SERVICE:
                port = ServicePort(component, name)
                end = ServiceEnd(port, known, self._objects, self.exported, references)
            else:
                data = component.in_ports if way == IN else component.out_ports
                end = DataEnd(data[name], self.exported, self._guard)
            found.append((known, end))
        return found
