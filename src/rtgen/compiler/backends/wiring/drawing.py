"""Renders the layout as SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rtgen.compiler.backends.kit.rendering import render as render_template
from rtgen.compiler.backends.wiring.diagram import (
    ComponentView,
    Diagram,
    Link,
    LinkStyle,
    Tab,
    TimedConnection,
    diagram_of,
)
from rtgen.compiler.backends.wiring.media import with_media
from rtgen.compiler.backends.wiring.palette import DARK, LIGHT
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
    media: tuple[tuple[float, str], ...]
    link: str


@dataclass(frozen=True, slots=True)
class _Link:
    path: str
    colour: str
    style: str
    tooltip: str


@dataclass(frozen=True, slots=True)
class _Medium:
    trunk: tuple[float, float, float]
    risers: str
    label: str


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
    colours = _Colours(diagram)
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
        light=LIGHT,
        dark=DARK,
        title_size=TITLE_SIZE,
        name_size=NAME_SIZE,
        text_size=TEXT_SIZE,
        header=HEADER,
        tab=TAB,
        links=[
            _Link(path, colours.of_tab[link.source], _style(link), _link_tooltip(link))
            for link, path in zip(diagram.links, geometry.paths, strict=True)
        ],
        media=[
            _Medium(
                geometry.trunks[medium],
                geometry.risers[medium],
                medium.label,
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
                    (geometry.media_row(box, index), node)
                    for index, (_, node) in enumerate(box.media)
                ),
                (links or {}).get(box.type, ""),
            )
            for box in diagram.boxes
        ],
    )


class _Colours:
    """The CSS class of each connected port's colour.

    Each type has a colour, and each OutPort of unknown type another one.
    """

    def __init__(self, diagram: Diagram) -> None:
        self._numbers: dict[str, int] = {}
        self.of_tab: dict[Tab, str] = {}
        for link in diagram.links:
            view = link.source.view
            colour = self._class(view.type or f"{link.source.box.instance}.{view.name}")
            self.of_tab.setdefault(link.source, colour)
            self.of_tab.setdefault(link.target, colour)

    def _class(self, key: str) -> str:
        number = self._numbers.setdefault(key, len(self._numbers))
        return f"c{number % len(LIGHT.links)}"


def _style(link: Link) -> str:
    return f"{link.style.value} timed" if link.times else link.style.value


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
    return "\n".join(
        (" → ".join(ends), link.source.view.type, *times, *properties)
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
