"""Wiring diagrams: their content, and a layout without overlaps."""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import combinations, pairwise
from types import MappingProxyType

import pytest
from component_models import SPAN, component, port
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree
from msgspec.structs import replace

from rtgen.compiler.backends.wiring import (
    ComponentView,
    PortView,
    TimedConnection,
    render,
    view_of,
)
from rtgen.compiler.backends.wiring.diagram import Tab, diagram_of
from rtgen.compiler.backends.wiring.palette import DARK, LIGHT, Scheme, luminance
from rtgen.compiler.backends.wiring.placement import place
from rtgen.compiler.backends.wiring.router import Place
from rtgen.compiler.backends.wiring.routing import (
    MAX_WIDTH,
    Frame,
    Geometry,
    lay_out,
    route,
)
from rtgen.compiler.model import (
    Connection,
    PortKind,
    PortReference,
    System,
    SystemComponent,
)

Wire = tuple[str, str, str, str]


def system(
    names: list[str],
    wires: Sequence[Wire] = (),
    services: Sequence[Wire] = (),
    places: Mapping[str, tuple[int, int]] = MappingProxyType({}),
) -> System:
    return System(
        name="drive",
        id="RTSystem:Lab:drive:1.0.0",
        file="s.xml",
        abstract="",
        components=tuple(
            SystemComponent(
                instance=name,
                type=name[:-1],
                id=f"RTC:Lab:Move:{name[:-1]}:1.0.0",
                path_uri="",
                span=SPAN,
                rate=50.0,
                location=(*places[name], -1, -1) if name in places else None,
            )
            for name in names
        ),
        connections=tuple(
            Connection(
                name=f"{a}.{b}_{c}.{d}",
                source=PortReference(instance=a, port=b),
                target=PortReference(instance=c, port=d),
                service=service,
                span=SPAN,
                properties=(
                    ()
                    if service
                    else (("dataport.data_type", "IDL:RTC/TimedLong:1.0"),)
                ),
            )
            for service, joined in ((False, wires), (True, services))
            for a, b, c, d in joined
        ),
    )


CHAIN = [
    ("A0", "out", "B0", "in"),
    ("B0", "out", "C0", "in"),
    ("C0", "out", "A0", "back"),
]


def layout(system: System) -> tuple[dict[str, tuple[int, int]], Geometry]:
    diagram = diagram_of(system, {})
    cells = place(diagram)
    return {box.instance: cell for box, cell in cells.items()}, route(diagram, cells)


Line = tuple[Place, Place]


def lines(corners: Sequence[Place]) -> list[Line]:
    return [(min(pair), max(pair)) for pair in pairwise(corners)]


def is_behind(frame: Frame, line: Line) -> bool:
    (x1, y1), (x2, y2) = line
    return (
        x1 < frame.x + frame.width - 1
        and x2 > frame.x + 1
        and y1 < frame.y + frame.height - 1
        and y2 > frame.y + 1
    )


def cross(one: Line, other: Line) -> bool:
    """Return whether one line passes through the other one."""
    (x1, y1), (x2, y2) = one
    (x3, y3), (x4, y4) = other
    return (x1 < x3 == x4 < x2 and y3 < y1 == y2 < y4) or (
        x3 < x1 == x2 < x4 and y1 < y3 == y4 < y2
    )


def overlap(one: Line, other: Line) -> bool:
    """Return whether the lines have more than a place in common."""
    (x1, y1), (x2, y2) = one
    (x3, y3), (x4, y4) = other
    if y1 == y2 == y3 == y4:
        return min(x2, x4) > max(x1, x3)
    return x1 == x2 == x3 == x4 and min(y2, y4) > max(y1, y3)


def check_layout(system: System, *, fitted: bool = False) -> None:
    cells, geometry = layout(system)
    assert len(set(cells.values())) == len(cells)
    diagram = diagram_of(system, {})
    if fitted:
        geometry = lay_out(diagram)
        assert geometry.width <= MAX_WIDTH
    frames = list(geometry.frames.values())
    for one, other in combinations(frames, 2):
        apart = (
            one.x + one.width <= other.x
            or other.x + other.width <= one.x
            or one.y + one.height <= other.y
            or other.y + other.height <= one.y
        )
        assert apart
    for corners in geometry.wires:
        for line in lines(corners):
            (x1, y1), (x2, y2) = line
            assert (x1 == x2) is not (y1 == y2), corners
            assert 0 < x1 <= x2 < geometry.width
            assert 0 < y1 <= y2 < geometry.height
            assert not any(is_behind(frame, line) for frame in frames), corners
    targets: dict[Tab, set[Tab]] = defaultdict(set)
    for link in diagram.links:
        targets[link.source].add(link.target)
    wires = list(zip(diagram.links, geometry.wires, strict=True))
    for (link, corners), (another, others) in combinations(wires, 2):
        if not targets[link.source] & targets[another.source]:
            for one_line in lines(corners):
                assert not any(overlap(one_line, each) for each in lines(others))


def drawn_wires(svg: str) -> list[tuple[str, str, list[Line]]]:
    """Return the colour, the ends and the lines of each wire of a picture."""
    root = etree.fromstring(svg.encode())
    wires = []
    for path in root.iterfind(".//{*}path[{*}title]"):
        colour = path.getparent().get("class")
        x, y = 0.0, 0.0
        corners = []
        for command, text in re.findall(r"([A-Za-z])([^A-Za-z]+)", path.get("d")):
            assert command in "MHV"
            numbers = [float(number) for number in text.split(",")]
            x, y = {
                "M": (numbers[0], numbers[-1]),
                "H": (numbers[0], y),
                "V": (x, numbers[0]),
            }[command]
            corners.append((x, y))
        ends = path.findtext("{*}title").partition("\n")[0]
        wires.append((colour, ends, lines(corners)))
    return wires


def check_colours(svg: str) -> None:
    """Check that wires of one colour that cross come from one port."""
    wires = drawn_wires(svg)
    for (colour, ends, parts), (second, others, second_parts) in combinations(wires, 2):
        if colour == second and ends.split(" → ")[0] != others.split(" → ")[0]:
            for one in parts:
                assert not any(cross(one, each) for each in second_parts), (
                    ends,
                    others,
                )


def test_data_flows_from_left_to_right() -> None:
    cells, _ = layout(system(["C0", "B0", "A0"], CHAIN))
    assert sorted(column for column, _ in cells.values()) == [0, 1, 2]
    check_layout(system(["C0", "B0", "A0"], CHAIN))


def test_locations_decide_if_every_component_has_its_own() -> None:
    places = {"A0": (300, 20), "B0": (20, 30), "C0": (300, 400)}
    cells, _ = layout(system(["A0", "B0", "C0"], CHAIN, places=places))
    assert cells == {"A0": (1, 0), "B0": (0, 0), "C0": (1, 1)}


@pytest.mark.parametrize(
    "places",
    [{"A0": (300, 20), "B0": (20, 30)}, {"A0": (5, 5), "B0": (9, 9), "C0": (900, 9)}],
)
def test_missing_or_overlapping_locations_are_not_used(
    places: dict[str, tuple[int, int]],
) -> None:
    wires = CHAIN[:2]
    with_places, without = system(["A0", "B0", "C0"], wires, places=places), system(
        ["A0", "B0", "C0"], wires
    )
    assert layout(with_places)[0] == layout(without)[0]
    assert [cell for _, cell in sorted(layout(without)[0].items())] == [
        (0, 0),
        (1, 0),
        (2, 0),
    ]


PROFILES = {
    "A": ComponentView(
        "A",
        (
            PortView("out", PortKind.OUTPORT, "RTC::TimedLong"),
            PortView("idle", PortKind.INPORT, "IIS::Map"),
            PortView("brake", PortKind.CONSUMER, "Safety::Brake", "Safety"),
        ),
    ),
    "B": view_of(
        component(
            port("inport", "in"), port("provider", "brake", "Safety::Brake"), name="B"
        )
    ),
}


def texts(svg: str) -> list[str]:
    root = etree.fromstring(svg.encode())
    return [str(e.text) for e in root.iter("{http://www.w3.org/2000/svg}text")]


def test_every_port_is_shown_with_its_type() -> None:
    svg = render(system(["A0", "B0"], [("A0", "out", "B0", "in")]), PROFILES)
    shown = texts(svg)
    assert {
        "drive",
        "A0",
        "A · 50 Hz",
        "out",
        "idle",
        "Map",
        "brake",
        "in",
    } <= set(shown)
    assert shown.count("TimedLong") == 2
    assert svg.count('<g class="open">') == 3
    assert "InPort idle: IIS::Map, not connected" in svg


def test_tooltip_tells_ends_type_and_properties() -> None:
    svg = render(system(["A0", "B0"], [("A0", "out", "B0", "in")]), PROFILES)
    assert (
        "A0.out → B0.in&#10;RTC::TimedLong&#10;"
        "written at 50 Hz at most, the rate of A0&#10;dataport.data_type = IDL:RTC/TimedLong:1.0"
        in svg
    )


def test_service_links_run_from_consumer_to_provider() -> None:
    for wire in (("A0", "Safety", "B0", "brake"), ("B0", "brake", "A0", "Safety")):
        svg = render(system(["A0", "B0"], services=[wire]), PROFILES)
        assert svg.count('class="line service"') == 1
        assert "A0.brake → B0.brake&#10;Safety::Brake" in svg
        assert "Consumer brake of Safety: Safety::Brake" in svg


def test_types_without_profile_show_what_the_connectors_name() -> None:
    svg = render(
        system(["X0", "Y0"], [("X0", "p", "Y0", "q")], [("X0", "s", "Y0", "t")]), {}
    )
    assert {"p", "q", "s", "t", "TimedLong"} <= set(texts(svg))


def test_types_of_one_name_keep_their_modules() -> None:
    ports = (
        PortView("p", PortKind.INPORT, "RTC::T"),
        PortView("q", PortKind.INPORT, "IIS::T"),
    )
    shown = texts(render(system(["X0"]), {"X": ComponentView("X", ports)}))
    assert {"RTC::T", "IIS::T"} <= set(shown)


def test_markup_in_names_is_escaped() -> None:
    svg = render(system(["<a>0"], [("<a>0", "&", "<a>0", '"')]), {})
    assert {"<a>0", "&", '"'} <= set(texts(svg))


def test_a_system_without_components() -> None:
    assert texts(render(system([]), {})) == ["drive"]


def test_many_ports_that_carry_nothing_are_one_row() -> None:
    ports = tuple(PortView(f"p{n}", PortKind.OUTPORT, "RTC::T") for n in range(9))
    svg = render(
        system(["X0", "Y0"], [("X0", "p3", "Y0", "q")]),
        {"X": ComponentView("X", ports)},
    )
    assert "8 more ports" in texts(svg)
    assert "p3" in texts(svg)
    assert "OutPort p8: RTC::T" in svg


def with_sets(base: System, sets: Mapping[str, Mapping[str, str]]) -> System:
    """Return the system with these parameters in the active sets of its components."""
    return replace(
        base,
        components=tuple(
            replace(
                each,
                configuration=(("default", (*sets.get(each.instance, {}).items(),)),),
            )
            for each in base.components
        ),
    )


def can(network: str, node: str) -> dict[str, str]:
    return {"interface": "v", "channel": "can3", "network": network, "node_id": node}


CAN_PORTS = {
    name: ComponentView(
        name,
        (
            PortView("tpdo1", PortKind.OUTPORT, "D::Tpdo1"),
            PortView("rpdo2", PortKind.INPORT, "D::Rpdo2"),
        ),
    )
    for name in ("LDevice", "RDevice", "RProxy")
}


def test_a_can_bus_is_a_line_with_its_nodes() -> None:
    base = system(["LDevice0", "RDevice0", "RProxy0", "M0", "N0"])
    sets = {
        "LDevice0": can("arm", "1"),
        "RDevice0": can("arm", "2"),
        "RProxy0": can("arm", "2"),
        "M0": {k: v for k, v in can("arm", "").items() if k != "node_id"},
    }
    shown = texts(render(with_sets(base, sets), CAN_PORTS))
    assert "CAN can3 · arm" in shown
    nodes = [text for text in shown if text.startswith("CAN ")]
    assert nodes.count("CAN node 2") == 2
    assert nodes.count("CAN node 1") == nodes.count("CAN manager") == 1


@pytest.mark.parametrize(
    ("parameters", "label"),
    [
        ({"type": "TCP", "ipaddr": "10.0.0.2", "port": "8931"}, "TCP 10.0.0.2:8931"),
        ({"transport": "tcp", "host": "::1", "port": "9"}, "TCP ::1:9"),
        ({"type": "SERIA", "port": "/dev/ttyS3"}, "Serial line /dev/ttyS3"),
        ({"transport": "serial", "device": "COM3", "port": "8931"}, "Serial line COM3"),
    ],
)
def test_tcp_and_serial_links_are_lines(parameters: dict[str, str], label: str) -> None:
    svg = render(with_sets(system(["A0", "B0"]), {"A0": parameters}), {})
    assert label in texts(svg)
    assert svg.count('class="line medium"') == 1


def test_parameters_of_the_definition_attach_unless_the_set_says_otherwise() -> None:
    view = ComponentView("A", (), {"transport": "tcp", "host": "h", "port": "1"})
    assert "TCP h:1" in texts(render(system(["A0"]), {"A": view}))
    idle = with_sets(system(["A0"]), {"A0": {"transport": "none"}})
    assert "TCP h:1" not in texts(render(idle, {"A": view}))


def test_connections_of_a_timeline_are_dashed_with_their_times() -> None:
    base = system(["A0", "B0"], [("A0", "out", "B0", "in")])
    timeline = [
        TimedConnection(
            PortReference(instance="A0", port=source),
            PortReference(instance="B0", port=target),
            time,
        )
        for source, target, time in (
            ("out", "in", 3.0),
            ("out", "other", 12.5),
            ("out", "other", 40.0),
        )
    ]
    svg = render(base, {}, timeline)
    assert svg.count('class="line data timed"') == 1
    assert "12.5, 40 s" in texts(svg)
    assert "A0.out → B0.other" in svg
    assert "made at 12.5 s" in svg


@pytest.mark.parametrize("scheme", [LIGHT, DARK], ids=["light", "dark"])
def test_text_and_lines_have_enough_contrast(scheme: Scheme) -> None:
    for ink in (scheme.text, scheme.muted, *scheme.more(80)):
        for ground in (scheme.page, scheme.box):
            high, low = sorted((luminance(ink), luminance(ground)), reverse=True)
            assert (high + 0.05) / (low + 0.05) >= 4.5, (ink, ground)


def test_colours_differ() -> None:
    for scheme in (LIGHT, DARK):
        assert len({*scheme.more(80), scheme.border}) == 81


def test_each_colour_is_defined_for_light_and_dark() -> None:
    svg = render(system(["A0", "B0"], [("A0", "out", "B0", "in")]), PROFILES)
    light, _, dark = svg.partition("@media (prefers-color-scheme:dark)")
    for text in (light, dark):
        assert ".c0{color:#" in text
    assert not re.search(r'(fill|stroke)="#', svg)


NAMES = [f"{letter}0" for letter in "ABCDEFG"]
wires = st.lists(
    st.tuples(
        st.sampled_from(NAMES),
        st.sampled_from(["p", "q", "a_longer_name"]),
        st.sampled_from(NAMES),
        st.sampled_from(["r", "s"]),
    ),
    max_size=14,
    unique=True,
)
places = st.dictionaries(
    st.sampled_from(NAMES),
    st.tuples(st.integers(0, 600), st.integers(0, 400)),
    max_size=7,
)


@pytest.mark.sampled(0)
@given(wires, places)
def test_nothing_covers_anything(
    joined: list[Wire], located: dict[str, tuple[int, int]]
) -> None:
    drawn = system(NAMES, joined, places=located)
    check_layout(drawn)
    check_layout(drawn, fitted=True)
    svg = render(drawn, {})
    assert render(drawn, {}) == svg
    check_colours(svg)


def complete(count: int) -> System:
    """Return a system in which each component is connected with each one."""
    names = [f"N{number}0" for number in range(count)]
    joined = [(a, f"to{b}", b, f"of{a}") for a in names for b in names]
    return system(names, joined)


def test_more_wires_cross_than_there_are_usual_colours() -> None:
    drawn = complete(10)
    check_layout(drawn, fitted=True)
    svg = render(drawn, {})
    check_colours(svg)
    used = {colour for colour, _, _ in drawn_wires(svg)}
    light, _, dark = svg.partition("@media (prefers-color-scheme:dark)")
    assert len(used) > len(LIGHT.links)
    assert all(
        f".{colour}{{color:#" in text for colour in used for text in (light, dark)
    )


def test_ports_opposite_each_other_are_connected_crosswise() -> None:
    wires = [("A0", "p", "B0", "r"), ("A0", "q", "B0", "s"), ("B0", "p", "A0", "r")]
    ports = [PortView(name, PortKind.OUTPORT, "T") for name in "pq"]
    ports += [PortView(name, PortKind.INPORT, "T") for name in "sr"]
    views = {name: ComponentView(name, tuple(ports)) for name in "AB"}
    svg = render(system(["A0", "B0"], wires), views)
    parts = {ends: lines for _, ends, lines in drawn_wires(svg)}
    crosswise = [parts["A0.p → B0.r"], parts["A0.q → B0.s"]]
    assert not any(overlap(a, b) for a in crosswise[0] for b in crosswise[1])
    check_colours(svg)


def test_many_components_are_drawn_about_as_wide_as_high() -> None:
    names = [f"C{number}0" for number in range(300)]
    joined = [(a, "out", b, "in") for a, b in pairwise(names)]
    joined += [(a, "far", b, "far") for a, b in zip(names, names[7:], strict=False)]
    svg = render(system(names, joined), {})
    root = etree.fromstring(svg.encode())
    width, height = (float(root.attrib[name]) for name in ("width", "height"))
    assert width > MAX_WIDTH
    assert 1 / 4 < width / height < 4
    check_colours(svg)


def test_the_rate_of_a_periodic_connection_is_shown() -> None:
    base = system(["A0", "B0"], [("A0", "out", "B0", "in"), ("A0", "out", "B0", "too")])
    first, second = base.connections
    periodic = (
        *first.properties,
        ("dataport.subscription_type", "periodic"),
        ("dataport.publisher.push_rate", "12.5"),
    )
    drawn = replace(base, connections=(replace(first, properties=periodic), second))
    svg = render(drawn, {})
    assert texts(svg).count("12.5 Hz") == 1
    assert "delivered at 12.5 Hz" in svg
    assert svg.count("written at 50 Hz at most, the rate of A0") == 1
    without = replace(first, properties=periodic[:-1])
    assert "12.5 Hz" not in texts(render(replace(base, connections=(without,)), {}))


def test_a_rate_that_the_system_does_not_state_is_that_of_the_definition() -> None:
    base = system(["A0", "B0"])
    stated = replace(
        base, components=tuple(replace(c, rate=None) for c in base.components)
    )
    views = {
        "A": view_of(component(name="A")),
        "B": replace_rate(view_of(component(name="B")), None),
    }
    shown = texts(render(stated, views))
    assert f"A · {component(name='A').rate:g} Hz" in shown
    assert "B" in shown


def replace_rate(view: ComponentView, rate: float | None) -> ComponentView:
    return ComponentView(view.name, view.ports, view.parameters, rate)


def test_wires_that_part_or_join_have_a_dot_where_they_do() -> None:
    parting = system(
        ["A0", "B0", "C0"], [("A0", "o", "B0", "i"), ("A0", "o", "C0", "i")]
    )
    joining = system(
        ["A0", "B0", "C0"], [("A0", "o", "C0", "i"), ("B0", "o", "C0", "i")]
    )
    apart = system(["A0", "B0"], [("A0", "o", "B0", "i")])
    for drawn, number in ((parting, 1), (joining, 1), (apart, 0)):
        assert render(drawn, {}).count('r="3.5"') == number


def test_media_that_cross_have_unlike_colours() -> None:
    base = system(["A0", "B0", "C0", "D0"])
    tcp = {"type": "TCP", "ipaddr": "h", "port": "1"}
    line = {"type": "SERIA", "port": "/dev/ttyS3"}
    sets = {"A0": tcp, "B0": line, "C0": tcp, "D0": line}
    svg = render(with_sets(base, sets), {})
    root = etree.fromstring(svg.encode())
    colours = [
        e.getparent().get("class")
        for e in root.iterfind(".//{*}path[@class='line medium']")
    ]
    assert len({*colours}) == 2
