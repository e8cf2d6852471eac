"""Renders the layout as SVG."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rtgen.compiler.backends.kit.rendering import render as render_template
from rtgen.compiler.backends.wiring.crossings import coloured, crossings
from rtgen.compiler.backends.wiring.diagram import (
    ComponentView,
    Diagram,
    Link,
    LinkStyle,
    Medium,
    Tab,
    TimedConnection,
    diagram_of,
)
from rtgen.compiler.backends.wiring.media import with_media
from rtgen.compiler.backends.wiring.palette import DARK, LIGHT
from rtgen.compiler.backends.wiring.router import Place
from rtgen.compiler.backends.wiring.routing import (
    HEADER,
    MARGIN,
    NAME_SIZE,
    TAB,
    TEXT_SIZE,
    TITLE_SIZE,
    Frame,
    Geometry,
    lay_out,
    notes,
    subtitle,
    text_width,
)
from rtgen.compiler.model import PortKind, System
from rtgen.compiler.model.can_bus import Bus

_LEGEND_ROW = 24
_SAMPLE = 34
_GAP = 4
"""Half of the gap in a wire below another one."""
_BORDER = -1
"""The number of the colour of borders, which media have."""


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
    note: str
    tooltip: str


@dataclass(frozen=True, slots=True)
class _Box:
    frame: Frame
    instance: str
    subtitle: str
    tabs: tuple[_Tab, ...]
    media: tuple[tuple[float, str, str], ...]
    link: str


@dataclass(frozen=True, slots=True)
class _Link:
    """A link; the first one of a source has the gaps in the wires that they cross, and its dots."""

    path: str
    halo: str
    dots: Sequence[Place]
    colour: str
    style: str
    tooltip: str


@dataclass(frozen=True, slots=True)
class _Medium:
    trunk: tuple[float, float, float]
    risers: str
    label: str
    colour: str


@dataclass(frozen=True, slots=True)
class _Sample:
    x: float
    style: str
    text: str


def render(
    system: System,
    profiles: Mapping[str, ComponentView],
    timeline: Sequence[TimedConnection] = (),
    buses: Sequence[Bus] = (),
    links: Mapping[str, str] | None = None,
) -> str:
    """Draw a system as SVG: data flow from left to right, feedback returns around the boxes.

    `profiles` maps a component type to its ports; those of a type without profile are derived from
    the connectors. `timeline` has the connections made during a run, `buses` the networks of the
    project, with bit rates and PDO links. `links` maps component types to the link targets of their
    boxes.
    """
    diagram = with_media(
        diagram_of(system, profiles, timeline),
        system,
        {name: view.parameters for name, view in profiles.items()},
        buses,
    )
    geometry = lay_out(diagram)
    colours = _Colours(diagram, geometry)
    times = notes(diagram)
    samples = _legend(diagram)
    end = samples[-1].x + _SAMPLE + text_width(samples[-1].text, TEXT_SIZE)
    width = max(
        geometry.width,
        text_width(diagram.title, TITLE_SIZE) + 64,
        end + MARGIN if len(samples) > 1 else 0,
    )
    legend = len(samples) > 1
    return render_template(
        "wiring/system.svg.j2",
        width=round(width),
        height=round(geometry.height + (_LEGEND_ROW if legend else 0)),
        legend_y=round(geometry.height),
        legend=samples if legend else [],
        sample_width=_SAMPLE - 8,
        title=diagram.title,
        schemes=[(each, each.more(colours.count)) for each in (LIGHT, DARK)],
        title_size=TITLE_SIZE,
        name_size=NAME_SIZE,
        text_size=TEXT_SIZE,
        header=HEADER,
        tab=TAB,
        links=[*_links(diagram, geometry, colours)],
        media=[
            _Medium(
                geometry.trunks[medium],
                " ".join(_path(line) for line in geometry.risers[medium]),
                medium.label,
                colours.of[medium],
            )
            for medium in diagram.media
        ],
        boxes=[
            _Box(
                geometry.frames[box],
                box.instance,
                subtitle(box),
                tuple(_tab(tab, geometry, colours, times) for tab in box.tabs),
                tuple(
                    (geometry.media_row(box, index), node, colours.of[medium])
                    for index, (medium, node) in enumerate(box.media)
                ),
                (links or {}).get(box.type, ""),
            )
            for box in diagram.boxes
        ],
    )


class _Colours:
    """The CSS class of the colour of each link, medium and connected port.

    Each type has a colour, and each OutPort of unknown type another one; a medium has that of
    borders. Wires that cross have unlike colours, by which one of them differs from its type.
    """

    def __init__(self, diagram: Diagram, geometry: Geometry) -> None:
        paths: list[tuple[Tab | Medium, Sequence[Place]]] = []
        for medium in diagram.media:
            left, right, height = geometry.trunks[medium]
            lines = (*geometry.risers[medium], ((left, height), (right, height)))
            paths += ((medium, line) for line in lines)
        for link, corners in zip(diagram.links, geometry.wires, strict=True):
            paths.append((link.source, corners))
        numbers: dict[str, int] = {}
        wishes: dict[Tab | Medium, int] = dict.fromkeys(diagram.media, _BORDER)
        for link in diagram.links:
            view = link.source.view
            key = view.type or f"{link.source.box.instance}.{view.name}"
            number = numbers.setdefault(key, len(numbers))
            wishes[link.source] = number % len(LIGHT.links)
        self.crossings = crossings(paths)
        chosen = coloured(wishes, self.crossings, len(LIGHT.links))
        self.count = max((number + 1 for number in chosen.values()), default=0)
        self.of = {
            wire: "bus" if number == _BORDER else f"c{number}"
            for wire, number in chosen.items()
        }
        self.of_tab: dict[Tab, str] = {}
        for link in sorted(diagram.links, key=lambda each: bool(each.times)):
            for tab in (link.source, link.target):
                self.of_tab.setdefault(tab, self.of[link.source])


def _links(diagram: Diagram, geometry: Geometry, colours: _Colours) -> Iterator[_Link]:
    """Yield the links: those of a source together, the first ones and lasting ones on top."""
    wires: dict[tuple[bool, Tab], list[tuple[Link, str]]] = {}
    for link, corners in zip(diagram.links, geometry.wires, strict=True):
        group = wires.setdefault((not link.times, link.source), [])
        group.append((link, _path(corners)))
    number = {link.source: -place for place, link in enumerate(diagram.links)}
    order = sorted(wires, key=lambda each: (each[0], number[each[1]]))
    height = {source: place for place, (_, source) in enumerate(order)}
    dots = _junctions(diagram, geometry)
    gaps: defaultdict[Tab, list[str]] = defaultdict(list)
    for (one, other), places in colours.crossings.items():
        above, mark = one, f"v-{_GAP} v{2 * _GAP}"
        if isinstance(one, Medium) or (
            isinstance(other, Tab) and height[one] < height[other]
        ):
            above, mark = other, f"h-{_GAP} h{2 * _GAP}"
        if isinstance(above, Tab):
            gaps[above] += (f"M{_n(x)},{_n(y)} {mark}" for x, y in sorted(places))
    for lasting, source in order:
        halo = " ".join(gaps.pop(source, ()))
        marks = sorted(dots.pop(source, ()))
        for link, path in wires[lasting, source]:
            style = f"{link.style.value} timed" if link.times else link.style.value
            colour = colours.of[link.source]
            yield _Link(path, halo, marks, colour, style, _link_tooltip(link))
            halo, marks = "", []


def _junctions(diagram: Diagram, geometry: Geometry) -> dict[Tab, set[Place]]:
    """Map sources to the places at which wires of one source part, or those to one target join."""
    ways: dict[Tab, list[tuple[Tab, Sequence[Place]]]] = defaultdict(list)
    for link, corners in zip(diagram.links, geometry.wires, strict=True):
        for tab in (link.source, link.target):
            ways[tab].append((link.source, corners))
    dots: dict[Tab, set[Place]] = defaultdict(set)
    for paths in ways.values():
        if len(paths) == 1:
            continue
        lines: dict[tuple[bool, float], list[tuple[float, float]]] = defaultdict(list)
        for _, corners in paths:
            for (x1, y1), (x2, y2) in pairwise(corners):
                if y1 == y2:
                    lines[True, y1].append((min(x1, x2), max(x1, x2)))
                else:
                    lines[False, x1].append((min(y1, y2), max(y1, y2)))
        joined = {line: _joined(parts) for line, parts in lines.items()}
        for source, corners in paths:
            for x, y in corners[1:-1]:
                ways_on = ((x, joined[True, y]), (y, joined[False, x]))
                if any(low < at < high for at, ends in ways_on for low, high in ends):
                    dots[source].add((x, y))
    return dots


def _joined(parts: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the parts of a line, those that touch as one."""
    joined: list[tuple[float, float]] = []
    for low, high in sorted(parts):
        if joined and low <= joined[-1][1]:
            low, high = joined[-1][0], max(joined.pop()[1], high)
        joined.append((low, high))
    return joined


def _path(corners: Sequence[Place]) -> str:
    """Return a line along corners as data of an SVG path."""
    (x, y), *others = corners
    path = f"M{_n(x)},{_n(y)}"
    for next_x, next_y in others:
        path += f" V{_n(next_y)}" if next_x == x else f" H{_n(next_x)}"
        x = next_x
    return path


def _n(value: float) -> str:
    """Return a length with at most one decimal."""
    return f"{value:.1f}".removesuffix(".0")


_LEGEND = {
    LinkStyle.DATA.value: "data",
    LinkStyle.SERVICE.value: "service",
    LinkStyle.PDO.value: "PDO, carried by the bus",
    "timed": "made during the run, at the time shown",
    "medium": "bus or line",
}


def _legend(diagram: Diagram) -> list[_Sample]:
    """Return a sample of each style of line in the diagram."""
    styles = {link.style.value for link in diagram.links if not link.times}
    if any(link.times for link in diagram.links):
        styles.add("timed")
    if diagram.media:
        styles.add("medium")
    samples: list[_Sample] = []
    x = float(MARGIN)
    for style, text in _LEGEND.items():
        if style in styles or style == LinkStyle.DATA.value:
            samples.append(_Sample(x, style, text))
            x += _SAMPLE + text_width(text, TEXT_SIZE) + 24
    return samples


def _link_tooltip(link: Link) -> str:
    ends = (f"{tab.box.instance}.{tab.view.name}" for tab in (link.source, link.target))
    properties = (f"{name} = {value}" for name, value in link.properties)
    times = (f"made at {time:g} s" for time in link.times)
    rate = link.source.box.rate
    rates = (
        [f"delivered at {link.rate:g} Hz"]
        if link.rate is not None
        else (
            [f"written at {rate:g} Hz at most, the rate of {link.source.box.instance}"]
            if rate is not None and link.style is LinkStyle.DATA
            else []
        )
    )
    return "\n".join(
        (" → ".join(ends), link.source.view.type, *rates, *times, *properties)
    ).strip()


def _tab(
    tab: Tab, geometry: Geometry, colours: _Colours, times: Mapping[Tab, str]
) -> _Tab:
    x, y = geometry.anchor(tab)
    view = tab.view
    state = "" if tab.connected else ", not connected"
    service = f" of {view.port}" if view.port not in ("", view.name) else ""
    tooltip = f"{_KINDS[view.kind]} {view.name}{service}: {view.type}{state}"
    if tab.views:
        tooltip = "Not connected:\n" + "\n".join(
            f"{_KINDS[each.kind]} {each.name}: {each.type}" for each in tab.views
        )
    return _Tab(
        kind="several" if tab.views else view.kind.value,
        x=x,
        y=y,
        colour=colours.of_tab.get(tab, "open"),
        text_x=x + TAB if tab.is_left else x - TAB,
        anchor="start" if tab.is_left else "end",
        name=view.name,
        type=tab.type_label,
        note=times.get(tab, ""),
        tooltip=tooltip,
    )


_KINDS = {
    PortKind.INPORT: "InPort",
    PortKind.OUTPORT: "OutPort",
    PortKind.PROVIDER: "Provider",
    PortKind.CONSUMER: "Consumer",
}
