"""What a wiring diagram shows: boxes with ports, and links between ports."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from rtgen.model import Component, PortKind, PortReference, System

_DATA_PORTS = (PortKind.INPORT, PortKind.OUTPORT)
_LEFT = (PortKind.INPORT, PortKind.PROVIDER)


@dataclass(frozen=True, slots=True)
class PortView:
    """A port as seen from outside. For an interface, `port` is the service port it belongs to."""

    name: str
    kind: PortKind
    type: str
    port: str = ""


@dataclass(frozen=True, slots=True)
class ComponentView:
    """A component type as seen from outside."""

    name: str
    ports: tuple[PortView, ...]


def view_of(component: Component) -> ComponentView:
    """The view of a component that was defined."""
    ports = (PortView(p.name, p.kind, str(p.type), p.port) for p in component.ports)
    return ComponentView(component.name[-1], tuple(ports))


@dataclass(slots=True, eq=False)
class Tab:
    """A port in the diagram; `row` counts down its side of the box.

    `type_label` is the type's name without modules, unless that would be ambiguous.
    """

    view: PortView
    box: Box
    row: int
    connected: bool = False
    type_label: str = ""

    @property
    def is_left(self) -> bool:
        """Whether it sits on the side where connections arrive."""
        return self.view.kind in _LEFT


@dataclass(slots=True, eq=False)
class Box:
    """An instance of a component in the diagram."""

    instance: str
    type: str
    rate: float | None
    location: tuple[int, int] | None
    tabs: list[Tab] = field(default_factory=list)

    def add(self, view: PortView) -> Tab:
        """A new tab for the port, below those of its side."""
        left = view.kind in _LEFT
        tab = Tab(view, self, sum(each.is_left is left for each in self.tabs))
        self.tabs.append(tab)
        return tab

    @property
    def rows(self) -> int:
        """How many tabs the fuller side has."""
        return max((tab.row + 1 for tab in self.tabs), default=0)


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A connection, from a tab at a right side to one at a left side."""

    source: Tab
    target: Tab
    service: bool
    properties: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Diagram:
    """Boxes in the order of the system, links in the order of its connectors."""

    title: str
    boxes: tuple[Box, ...]
    links: tuple[Link, ...]


def diagram_of(system: System, profiles: Mapping[str, ComponentView]) -> Diagram:
    """The diagram of a system; what no profile tells is taken from the connectors."""
    boxes = {
        c.instance: Box(c.instance, c.type, c.rate, c.location and c.location[:2])
        for c in system.components
    }
    for box in boxes.values():
        for view in profiles[box.type].ports if box.type in profiles else ():
            box.add(view)
    links: list[Link] = []
    for connection in system.connections:
        ends = boxes.get(connection.source.instance), boxes.get(
            connection.target.instance
        )
        source, target = ends
        if source is None or target is None:
            continue
        if connection.service:
            pairs = _service_pairs(source, connection.source, target, connection.target)
        else:
            type_ = _type_of_id(
                dict(connection.properties).get("dataport.data_type", "")
            )
            out = _data_tab(source, connection.source.port, PortKind.OUTPORT, type_)
            pairs = [
                (out, _data_tab(target, connection.target.port, PortKind.INPORT, type_))
            ]
        for left, right in pairs:
            left.connected = right.connected = True
            links.append(Link(left, right, connection.service, connection.properties))
    _label_types([tab for box in boxes.values() for tab in box.tabs])
    return Diagram(system.name, tuple(boxes.values()), tuple(links))


def _label_types(tabs: Sequence[Tab]) -> None:
    named: dict[str, set[str]] = defaultdict(set)
    for tab in tabs:
        named[_unqualified(tab.view.type)].add(tab.view.type)
    for tab in tabs:
        short = _unqualified(tab.view.type)
        tab.type_label = short if len(named[short]) == 1 else tab.view.type


def _unqualified(type_: str) -> str:
    return type_.rpartition("::")[2]


def _type_of_id(repository_id: str) -> str:
    """`IDL:RTC/TimedLong:1.0` to `RTC::TimedLong`."""
    return repository_id.removeprefix("IDL:").rpartition(":")[0].replace("/", "::")


def _data_tab(box: Box, name: str, kind: PortKind, type_: str) -> Tab:
    for tab in box.tabs:
        if tab.view.kind is kind and tab.view.name == name:
            return tab
    return box.add(PortView(name, kind, type_))


def _service_pairs(
    source: Box, source_end: PortReference, target: Box, target_end: PortReference
) -> Iterable[tuple[Tab, Tab]]:
    """Consumer and provider of each interface that the two service ports share."""
    ends = (_interfaces(source, source_end.port), _interfaces(target, target_end.port))
    pairs = [
        (consumer, provider)
        for users, servers in (ends, ends[::-1])
        for consumer in users
        for provider in servers
        if consumer.view.kind is PortKind.CONSUMER
        and provider.view.kind is PortKind.PROVIDER
        and consumer.view.type == provider.view.type
    ]
    if pairs:
        return pairs
    user = _service_tab(source, source_end.port, PortKind.CONSUMER)
    return [(user, _service_tab(target, target_end.port, PortKind.PROVIDER))]


def _interfaces(box: Box, port: str) -> list[Tab]:
    return [
        t for t in box.tabs if t.view.kind not in _DATA_PORTS and t.view.port == port
    ]


def _service_tab(box: Box, port: str, kind: PortKind) -> Tab:
    for tab in _interfaces(box, port):
        if tab.view.kind is kind:
            return tab
    return box.add(PortView(port, kind, "", port))
