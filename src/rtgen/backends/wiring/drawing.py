"""From the layout to SVG text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rtgen.backends.rendering import render_xml
from rtgen.backends.wiring.diagram import ComponentView, Diagram, Link, Tab, diagram_of
from rtgen.backends.wiring.placement import place
from rtgen.backends.wiring.routing import (
    HEADER,
    TAB,
    Frame,
    Geometry,
    route,
    subtitle,
    text_width,
)
from rtgen.model import PortKind, System

_COLOURS = (
    "#1f6fb4",
    "#d2691e",
    "#2e8b57",
    "#8e44ad",
    "#c0392b",
    "#0e8c8c",
    "#a67c00",
    "#c2508b",
    "#4f5d75",
    "#6b8e23",
)
_UNCONNECTED = "#9aa5b1"


@dataclass(frozen=True, slots=True)
class _Tab:
    kind: str
    x: float
    y: float
    colour: str
    text_x: float
    anchor: str
    name: str
    type: str
    tooltip: str
    connected: bool


@dataclass(frozen=True, slots=True)
class _Box:
    frame: Frame
    instance: str
    subtitle: str
    tabs: tuple[_Tab, ...]


@dataclass(frozen=True, slots=True)
class _Link:
    path: str
    colour: str
    service: bool
    tooltip: str


def render(system: System, profiles: Mapping[str, ComponentView]) -> str:
    """A system as SVG: data flows from left to right, feedback goes round.

    `profiles` maps component type to its ports; ports of a type that is not there are those that
    the connectors name.
    """
    diagram = diagram_of(system, profiles)
    geometry = route(diagram, place(diagram))
    colours = _colours(diagram)
    width = max(geometry.width, text_width(diagram.title, 16) + 64)
    return render_xml(
        "wiring/system.svg.j2",
        width=round(width),
        height=round(geometry.height),
        title=diagram.title,
        header=HEADER,
        tab=TAB,
        links=[
            _Link(path, colours[link.source], link.service, _link_tooltip(link))
            for link, path in zip(diagram.links, geometry.paths, strict=True)
        ],
        boxes=[
            _Box(
                geometry.frames[box],
                box.instance,
                subtitle(box),
                tuple(_tab(tab, geometry, colours) for tab in box.tabs),
            )
            for box in diagram.boxes
        ],
    )


def _colours(diagram: Diagram) -> dict[Tab, str]:
    """A colour for each type (each OutPort, where the type is unknown), for connected tabs."""
    by_type: dict[str, str] = {}
    colours: dict[Tab, str] = {}
    for link in diagram.links:
        key = (
            link.source.view.type
            or f"{link.source.box.instance}.{link.source.view.name}"
        )
        colour = by_type.setdefault(key, _COLOURS[len(by_type) % len(_COLOURS)])
        colours.setdefault(link.source, colour)
        colours.setdefault(link.target, colour)
    return colours


def _link_tooltip(link: Link) -> str:
    ends = (f"{tab.box.instance}.{tab.view.name}" for tab in (link.source, link.target))
    properties = (f"{name} = {value}" for name, value in link.properties)
    return "\n".join((" → ".join(ends), link.source.view.type, *properties)).strip()


def _tab(tab: Tab, geometry: Geometry, colours: Mapping[Tab, str]) -> _Tab:
    x, y = geometry.anchor(tab)
    view = tab.view
    state = "" if tab.connected else ", not connected"
    service = f" of {view.port}" if view.port not in ("", view.name) else ""
    return _Tab(
        kind=view.kind.value,
        x=x,
        y=y,
        colour=colours.get(tab, _UNCONNECTED),
        text_x=x + TAB if tab.is_left else x - TAB,
        anchor="start" if tab.is_left else "end",
        name=view.name,
        type=tab.type_label,
        tooltip=f"{_KINDS[view.kind]} {view.name}{service}: {view.type}{state}",
        connected=tab.connected,
    )


_KINDS = {
    PortKind.INPORT: "InPort",
    PortKind.OUTPORT: "OutPort",
    PortKind.PROVIDER: "Provider",
    PortKind.CONSUMER: "Consumer",
}
