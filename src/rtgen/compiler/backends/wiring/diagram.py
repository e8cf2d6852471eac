"""Content of a wiring diagram: boxes with ports, links between ports, and media."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from rtgen.compiler.model import Component, PortKind, PortReference, System
from rtgen.facts import connector_properties

_DATA_PORTS = (PortKind.INPORT, PortKind.OUTPORT)
_LEFT = (PortKind.INPORT, PortKind.PROVIDER)
_MAX_IDLE = 3
"""Maximum number of unconnected ports drawn on one side of a box."""


@dataclass(frozen=True, slots=True)
class PortView:
    """A port in the diagram. For an interface, `port` is the service port it belongs to."""

    name: str
    kind: PortKind
    type: str
    port: str = ""


@dataclass(frozen=True, slots=True)
class ComponentView:
    """A component type in the diagram; `parameters` maps names to default texts.

    `rate` is that of instances without their own [Hz].
    """

    name: str
    ports: tuple[PortView, ...]
    parameters: Mapping[str, str] = field(default_factory=dict)
    rate: float | None = None


def view_of(component: Component) -> ComponentView:
    """Return the view of a defined component."""
    ports = (PortView(p.name, p.kind, str(p.type), p.port) for p in component.ports)
    parameters = {
        p.name: "" if p.default is None else str(p.default)
        for p in component.configuration
    }
    rate = component.rate if component.activity == "PERIODIC" else None
    return ComponentView(component.name[-1], tuple(ports), parameters, rate)


@dataclass(frozen=True, slots=True)
class TimedConnection:
    """A connection made by a timeline, `time` seconds after the start of the run."""

    source: PortReference
    target: PortReference
    time: float


class LinkStyle(Enum):
    """How a link is drawn."""

    DATA = "data"
    SERVICE = "service"
    PDO = "pdo"


@dataclass(slots=True, eq=False)
class Tab:
    """A port in the diagram; `row` counts down its side of the box.

    `type_label` is the type's name without modules, unless that would be ambiguous. `views` are
    the ports that the tab stands for, if it stands for several.
    """

    view: PortView
    box: Box
    row: int
    connected: bool = False
    type_label: str = ""
    views: tuple[PortView, ...] = ()

    @property
    def is_left(self) -> bool:
        """Whether it sits on the side where connections arrive."""
        return self.view.kind in _LEFT


@dataclass(slots=True, eq=False)
class Box:
    """An instance of a component in the diagram.

    `media` are the media that it is attached to, each with the component's role.
    """

    instance: str
    type: str
    rate: float | None
    location: tuple[int, int] | None
    tabs: list[Tab] = field(default_factory=list)
    media: list[tuple[Medium, str]] = field(default_factory=list)

    def add(self, view: PortView) -> Tab:
        """Add a tab for the port below those of its side, and return it."""
        left = view.kind in _LEFT
        tab = Tab(view, self, sum(each.is_left is left for each in self.tabs))
        self.tabs.append(tab)
        return tab

    def collapse(self) -> None:
        """Replace several unconnected ports of a side by one tab."""
        for left in (True, False):
            side = [tab for tab in self.tabs if tab.is_left is left]
            idle = [tab for tab in side if not tab.connected]
            if len(idle) <= _MAX_IDLE:
                continue
            tabs = [tab for tab in side if tab.connected]
            views = tuple(tab.view for tab in idle)
            view = PortView(f"{len(idle)} more ports", views[0].kind, "")
            tabs.append(Tab(view, self, 0, views=views))
            for row, tab in enumerate(tabs):
                tab.row = row
            self.tabs = [tab for tab in self.tabs if tab.is_left is not left] + tabs

    @property
    def rows(self) -> int:
        """Number of tabs on the side with more tabs."""
        return max((tab.row + 1 for tab in self.tabs), default=0)


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A connection, from a tab on the right of a box to one on the left.

    `times` are the seconds at which a timeline makes it; empty if it exists at the start.
    """

    source: Tab
    target: Tab
    style: LinkStyle
    properties: tuple[tuple[str, str], ...] = ()
    times: tuple[float, ...] = ()

    @property
    def rate(self) -> float | None:
        """Samples per second of a periodic connection; None if the writer decides."""
        return connector_properties.push_rate(dict(self.properties))


@dataclass(frozen=True, slots=True, eq=False)
class Medium:
    """A bus or line that transports data between components, and the data's names on it."""

    label: str
    number: int
    nodes: list[tuple[Box, str]]


@dataclass(frozen=True, slots=True)
class Diagram:
    """Boxes in the order of the system, links in the order of its connectors."""

    title: str
    boxes: tuple[Box, ...]
    links: tuple[Link, ...]
    media: tuple[Medium, ...] = ()


def diagram_of(
    system: System,
    profiles: Mapping[str, ComponentView],
    timeline: Sequence[TimedConnection] = (),
) -> Diagram:
    """Return the diagram of a system; missing profiles are derived from the connectors."""
    boxes = {
        c.instance: Box(
            c.instance,
            c.type,
            profiles[c.type].rate if c.rate is None and c.type in profiles else c.rate,
            c.location and c.location[:2],
        )
        for c in system.components
    }
    for box in boxes.values():
        for view in profiles[box.type].ports if box.type in profiles else ():
            box.add(view)
    links: dict[tuple[Tab, Tab], Link] = {}
    for connection in system.connections:
        source = boxes.get(connection.source.instance)
        target = boxes.get(connection.target.instance)
        if source is None or target is None:
            continue
        if connection.service:
            pairs = _service_pairs(source, connection.source, target, connection.target)
            style = LinkStyle.SERVICE
        else:
            type_ = _type_of_id(
                dict(connection.properties).get("dataport.data_type", "")
            )
            out = _data_tab(source, connection.source.port, PortKind.OUTPORT, type_)
            pairs = [
                (out, _data_tab(target, connection.target.port, PortKind.INPORT, type_))
            ]
            style = LinkStyle.DATA
        for pair in pairs:
            links[pair] = Link(*pair, style, connection.properties)
    for link in _timed_links(boxes, timeline):
        links.setdefault((link.source, link.target), link)
    for link in links.values():
        link.source.connected = link.target.connected = True
    _label_types([tab for box in boxes.values() for tab in box.tabs])
    return Diagram(system.name, tuple(boxes.values()), tuple(links.values()))


def _timed_links(
    boxes: Mapping[str, Box], timeline: Sequence[TimedConnection]
) -> Iterable[Link]:
    times: dict[tuple[Tab, Tab], list[float]] = defaultdict(list)
    styles: dict[tuple[Tab, Tab], LinkStyle] = {}
    for link in timeline:
        source, target = boxes[link.source.instance], boxes[link.target.instance]
        service = bool(_interfaces(source, link.source.port))
        if service:
            pairs = _service_pairs(source, link.source, target, link.target)
        else:
            out = _data_tab(source, link.source.port, PortKind.OUTPORT, "")
            pairs = [(out, _data_tab(target, link.target.port, PortKind.INPORT, ""))]
        for pair in pairs:
            times[pair].append(link.time)
            styles[pair] = LinkStyle.SERVICE if service else LinkStyle.DATA
    for pair, made_at in times.items():
        yield Link(*pair, styles[pair], times=tuple(made_at))


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
    """Convert `IDL:RTC/TimedLong:1.0` to `RTC::TimedLong`."""
    return repository_id.removeprefix("IDL:").rpartition(":")[0].replace("/", "::")


def _data_tab(box: Box, name: str, kind: PortKind, type_: str) -> Tab:
    for tab in box.tabs:
        if tab.view.kind is kind and tab.view.name == name:
            return tab
    return box.add(PortView(name, kind, type_))


def _service_pairs(
    source: Box, source_end: PortReference, target: Box, target_end: PortReference
) -> list[tuple[Tab, Tab]]:
    """Return consumer and provider of each interface common to the two service ports."""
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
