"""Describes a running system in the messages of the protocol (docs/ui-protocol.md)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from inspect import getdoc
from typing import Any, Final

from rtgen.compiler.model import Connection
from rtgen.runtime.distribution.local_runs import Planned
from rtgen.runtime.return_codes import LifeCycleState
from rtgen.runtime.rtc.component import Component as Rtc
from rtgen.runtime.rtc.profiles import ComponentProfile, ParameterProfile, PortProfile
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.servants import ServiceError, operations_of
from rtgen.runtime.system.joining import Connector, instances_of
from rtgen.runtime.system.latency import Latency
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.member_units import MemberUnits, units_of
from rtgen.tools.recording.channels import cdr_encoder
from rtgen.ui.protocol import ui
from rtgen.ui.type_table import NO_TYPE, TypeTable

STATES_BY_NAME: Final = {
    "CREATED_STATE": ui.State.STATE_CREATED,
    "INACTIVE_STATE": ui.State.STATE_INACTIVE,
    "ACTIVE_STATE": ui.State.STATE_ACTIVE,
    "ERROR_STATE": ui.State.STATE_ERROR,
}
STATES: Final = {LifeCycleState[name]: state for name, state in STATES_BY_NAME.items()}


class Description:
    """Describes the parts of a system; types are entered in `types`."""

    def __init__(self, types: TypeTable) -> None:
        self.types = types
        self._numbers: dict[Any, int] = {}

    def type_number(self, type_: Any) -> int:
        """Return the number of the type of a port; NO_TYPE if its samples are JSON."""
        if type_ not in self._numbers:
            number = (
                NO_TYPE
                if cdr_encoder(type_) is None
                else self.types.number(type_._descriptor_)
            )
            self._numbers[type_] = number
        return self._numbers[type_]

    def component(
        self,
        system: System,
        instance: str,
        place: tuple[float, float] | None,
        *,
        finishes: bool = False,
    ) -> ui.Component:
        """Describe a component with its ports, parameters and state."""
        component = system.component(instance)
        profile, sets = component.profile, component.configuration_sets
        context = system.context(instance)
        return ui.Component(
            instance=instance,
            type=profile.type_name,
            category=profile.category,
            vendor=profile.vendor,
            version=profile.version,
            doc=profile.description,
            current=STATES[system.state(instance)],
            reason=component.reason,
            contexts=[
                ui.ExecutionContext(
                    handle=context.participants[0].handle,
                    rate=context.get_rate(),
                    kind=context.get_kind().name,
                    running=context.is_running(),
                )
            ],
            ports=self.ports(component),
            parameters=[parameter(each) for each in sets.parameters],
            configuration_sets=[
                ui.ConfigurationSet(name=each, values=_values(sets.texts(each)))
                for each in sets.ids
            ],
            active_set=sets.active,
            placed=place is not None,
            where=ui.Location(*(place or (0.0, 0.0))),
            observables=[*component.observables],
            finishes=finishes,
        )

    def ports(self, component: Rtc) -> list[ui.Port]:
        """Describe the ports of a component, data ports first."""
        profile = component.profile
        described = {p.name: p for p in profile.ports if not p.port}
        data_ports = [
            self._data_port(
                kind, name, port.type, described.get(name), units_of(profile, port)
            )
            for kind, ports in (
                (ui.PortKind.PORT_IN, component.in_ports),
                (ui.PortKind.PORT_OUT, component.out_ports),
            )
            for name, port in ports.items()
        ]
        interfaces = (
            (port, self._interface(name, each.interface, provided=provided))
            for provided, those in (
                (True, component.providers),
                (False, component.consumers),
            )
            for (port, name), each in those.items()
        )
        return [*data_ports, *service_ports(interfaces)]

    def _data_port(
        self,
        kind: ui.PortKind,
        name: str,
        type_: Any,
        profile: PortProfile | None,
        units: MemberUnits,
    ) -> ui.Port:
        return ui.Port(
            name=name,
            kind=kind,
            type=type_._descriptor_.name,
            type_number=self.type_number(type_),
            unit=profile.unit if profile is not None else "",
            units=member_units(units),
            doc=profile.description if profile is not None else "",
        )

    def _interface(
        self, name: str, interface: Any, *, provided: bool
    ) -> ui.ServiceInterface:
        return ui.ServiceInterface(
            name=name,
            type=interface._descriptor_.name,
            provided=provided,
            operations=self.operations(interface),
        )

    def operations(self, interface: Any) -> list[ui.Operation]:
        """Return the operations of an interface, with reasons for those that pages cannot call."""
        try:
            calls = calls_of(interface)
        except ServiceError:
            calls = {}
        operations = []
        for operation, call in calls.items():
            refused = call.refused
            if any((*call.request_objects, *call.reply_objects)):
                refused = refused or "objects are passed"
            numbers = [NO_TYPE, NO_TYPE]
            for i, type_ in enumerate((call.request, call.reply)):
                if type_ is not None and not refused:
                    numbers[i] = self.types.number(type_._descriptor_)
                    if numbers[i] == NO_TYPE:
                        refused = "a page has no codec of its types"
            operations.append(
                ui.Operation(
                    name=operation,
                    request=numbers[0],
                    reply=numbers[1],
                    doc=_doc(interface, operation),
                    refused=refused,
                )
            )
        return operations


def service_ports(
    interfaces: Iterable[tuple[str, ui.ServiceInterface]],
) -> Iterator[ui.Port]:
    """Yield the service ports of interfaces, each with the name of its port."""
    kind, by_port = ui.PortKind.PORT_SERVICE, dict[str, list[ui.ServiceInterface]]()
    for port, interface in interfaces:
        by_port.setdefault(port, []).append(interface)
    for name, own in by_port.items():
        yield ui.Port(name=name, kind=kind, type_number=NO_TYPE, interfaces=own)


def _doc(interface: Any, operation: str) -> str:
    """Return the documentation of an operation in its definition."""
    member = getattr(interface, operations_of(interface)[operation].python_name)
    return getdoc(member) or ""


def member_units(units: MemberUnits) -> list[ui.Value]:
    """Describe the units of the members of samples."""
    return [ui.Value(".".join(path), unit) for path, unit in units.units.items()]


def connection(connector: Connector) -> ui.Connection:
    """Describe a connection."""
    source, target = instances_of(connector)
    return ui.Connection(
        name=connector.name,
        source=_address(source, connector.source),
        target=_address(target, connector.target),
        properties=_values(properties_of(connector)),
    )


def written_connection(connection: Connection) -> ui.Connection:
    """Describe a connection of a system's file."""
    return ui.Connection(
        name=connection.name,
        source=ui.PortAddress(connection.source.instance, connection.source.port),
        target=ui.PortAddress(connection.target.instance, connection.target.port),
        properties=[ui.Value(*pair) for pair in connection.properties],
    )


def properties_of(connector: Connector) -> Mapping[str, str]:
    """Return the properties of a connection; none for a service of another process."""
    properties: Mapping[str, str] = getattr(connector, "properties", {})
    return properties


def planned(event: Planned) -> ui.PlannedEvent:
    """Describe an event of the timeline."""
    source, target = ui.PortAddress(*event.source), ui.PortAddress(*event.target)
    return ui.PlannedEvent(event.time / SECOND, event.kind, event.text, source, target)


def chain(latency: Latency) -> ui.Chain:
    """Describe the latency of a chain of connections."""
    times = latency.least, latency.median, latency.late, latency.greatest
    seconds = (each / SECOND for each in times)
    return ui.Chain(latency.name, [*latency.ports], latency.samples, *seconds)


def flow(name: str, losses: Mapping[str, int], rate: float) -> ui.Flow:
    """Describe what became of the samples of a connection; `rate` in 1/s, negative if unknown."""
    return ui.Flow(
        name=name,
        rate=rate,
        lost=sum(losses.values()),
        details=", ".join(f"{n} {what}" for what, n in losses.items()),
    )


def palette_entry(profile: ComponentProfile) -> ui.PaletteEntry:
    """Describe a component type with the names of its ports."""
    ports: dict[str, ui.Port] = {}
    for each in profile.ports:
        if not each.port:
            is_in = each.kind == "inport"
            ports[each.name] = ui.Port(
                name=each.name,
                kind=ui.PortKind.PORT_IN if is_in else ui.PortKind.PORT_OUT,
                type=each.type,
                type_number=NO_TYPE,
                unit=each.unit,
                doc=each.description,
            )
            continue
        service = ports.setdefault(
            each.port,
            ui.Port(name=each.port, kind=ui.PortKind.PORT_SERVICE, type_number=NO_TYPE),
        )
        service.interfaces.append(
            ui.ServiceInterface(
                name=each.instance, type=each.type, provided=each.kind == "provider"
            )
        )
    return ui.PaletteEntry(
        type=profile.type_name,
        category=profile.category,
        doc=profile.description,
        ports=[*ports.values()],
    )


def statistics(system: System, instances: Iterable[str]) -> list[ui.Statistics]:
    """Return the statistics of components."""
    statistics_of = []
    for instance in instances:
        now = system.statistics(instance)
        statistics_of.append(
            ui.Statistics(
                instance=instance,
                ticks=now.ticks,
                overruns=now.overruns,
                lost=now.lost,
                awaited=now.awaited,
                impaired=now.condition,
            )
        )
    return statistics_of


def _address(instance: str, port: object) -> ui.PortAddress:
    name = str(port).removeprefix(f"{instance}.")
    return ui.PortAddress(instance=instance, port=name)


def parameter(profile: ParameterProfile) -> ui.Parameter:
    """Describe a configuration parameter."""
    constraint = profile.constraint
    if not constraint and (profile.minimum, profile.maximum) != (None, None):
        least = "" if profile.minimum is None else f"{profile.minimum}<="
        most = "" if profile.maximum is None else f"<={profile.maximum}"
        constraint = f"{least}x{most}"
    return ui.Parameter(
        name=profile.name,
        type=profile.type,
        default_value=profile.default,
        unit=profile.unit,
        constraint=constraint,
        widget=profile.widget,
        doc=profile.description,
    )


def _values(pairs: Mapping[str, str]) -> list[ui.Value]:
    return [ui.Value(name=name, text=text) for name, text in pairs.items()]
