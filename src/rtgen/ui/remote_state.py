"""State of the components of other processes, and its changes as events for pages."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from dataclasses import replace as dataclass_replace

from msgspec.structs import replace

from rtgen.facts import port_fitting
from rtgen.facts.connector_properties import PROFILE_ATTRIBUTES, embedded_data
from rtgen.facts.port_fitting import StatedInterface, StatedPort
from rtgen.ui.protocol import ui

_KINDS = {
    ui.PortKind.PORT_IN: port_fitting.IN_PORT,
    ui.PortKind.PORT_OUT: port_fitting.OUT_PORT,
    ui.PortKind.PORT_SERVICE: port_fitting.SERVICE_PORT,
}


@dataclass(frozen=True)
class RemoteRun:
    """A run that is shown instead of one of this process.

    Each further run of the system has a higher number. `ended` says why it is over, and how to go
    on; empty while it is not. `less` says that some of what happens is left out.
    """

    number: int = 0
    name: str = ""
    ended: str = ""
    doc: str = ""
    plan: tuple[ui.PlannedEvent, ...] = ()
    less: str = ""


@dataclass(frozen=True)
class RemoteState:
    """Naming services with the components and connections of other processes, by name."""

    services: tuple[ui.NamingService, ...] = ()
    components: Mapping[str, ui.Component] = field(default_factory=dict)
    connections: Mapping[str, ui.Connection] = field(default_factory=dict)
    statistics: Mapping[str, ui.Statistics] = field(default_factory=dict)
    flows: Sequence[ui.Flow] = ()
    chains: Sequence[ui.Chain] = ()
    run: RemoteRun = RemoteRun()

    @property
    def is_attached(self) -> bool:
        """Whether a run of another process is shown instead of one of this one."""
        return self.run.number > 0

    def known(self, known: Callable[[ui.Port], ui.Port]) -> RemoteState:
        """Return a copy whose ports are completed by a function."""
        components = {
            name: replace(each, ports=[*map(known, each.ports)])
            for name, each in self.components.items()
        }
        return dataclass_replace(self, components=components)

    def changes(self, before: RemoteState, now: float) -> Iterator[ui.Event]:
        """Return the changes as events in the order to apply them; `now` is the time [s]."""
        for name in before.connections.keys() - self.connections.keys():
            yield ui.Event.of_cut(name)
        for name in before.components.keys() - self.components.keys():
            yield ui.Event.of_removed(name)
        for name, component in self.components.items():
            former = before.components.get(name)
            if former is not None and former.current is not component.current:
                yield ui.Event.of_change(_change(former, component, now))
                former = replace(former, current=component.current)
            if former is not None and former.silent != component.silent:
                yield ui.Event.of_reported(_notice(component, now))
            if former != component:
                yield ui.Event.of_described(component)
        for name, connection in self.connections.items():
            if before.connections.get(name) != connection:
                yield ui.Event.of_connected(connection)
        if self.services != before.services:
            yield ui.Event.of_naming([*self.services])

    def fits(self, here: ui.PortAddress) -> Iterator[ui.Fit]:
        """Return which other ports fit a port, and for the rest the reason why not."""
        port = self.port(here)
        for there in self.ports():
            if there == here or port is None:
                continue
            yield ui.Fit(port=there, refused=self.obstacle(here, [port], there))

    def obstacle(
        self, here: ui.PortAddress, ports: Sequence[ui.Port], there: ui.PortAddress
    ) -> str:
        """Return why ports cannot be connected; empty if they can.

        `ports` are all ports of the first address: an InPort and an OutPort may share a name.
        """
        port = self.port(there)
        if port is None:
            return "there is no such port"
        refusals = [obstacle(each, port) for each in ports]
        if refusals and "" not in refusals:
            return refusals[0]
        ends = [here, there]
        for each in self.connections.values():
            if ends in ([each.source, each.target], [each.target, each.source]):
                return "they are connected already"
        return self.components[there.instance].silent

    def ports(self) -> Iterator[ui.PortAddress]:
        """Return the addresses of all ports."""
        for component in self.components.values():
            for port in component.ports:
                yield ui.PortAddress(instance=component.instance, port=port.name)

    def port(self, address: ui.PortAddress) -> ui.Port | None:
        """Return a port; None if there is none."""
        component = self.components.get(address.instance)
        ports = () if component is None else component.ports
        return next((each for each in ports if each.name == address.port), None)


def obstacle(one: ui.Port, other: ui.Port) -> str:
    """Return why two ports cannot be connected, by their profiles; empty if they can."""
    return port_fitting.obstacle(_stated(one), _stated(other))


def _stated(port: ui.Port) -> StatedPort:
    interfaces = (StatedInterface(each.type, each.provided) for each in port.interfaces)
    return StatedPort(_KINDS[port.kind], port.type, tuple(interfaces))


def restored(properties: Sequence[ui.Value]) -> list[ui.Value]:
    """Return the properties to restore a connection, without those added by its ends."""
    return [
        each
        for each in properties
        if each.name in embedded_data() or each.name in PROFILE_ATTRIBUTES
    ]


def _change(before: ui.Component, after: ui.Component, now: float) -> ui.StateChange:
    return ui.StateChange(
        time=now,
        instance=after.instance,
        handle=after.contexts[0].handle if after.contexts else 0,
        before=before.current,
        after=after.current,
        reason=after.reason if after.current is ui.State.STATE_ERROR else "",
    )


def _notice(component: ui.Component, now: float) -> ui.Notice:
    kind, text = "lost", component.silent
    if not text:
        kind, text = "found", "it answers again"
    return ui.Notice(time=now, kind=kind, instance=component.instance, text=text)
