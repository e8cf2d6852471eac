"""The gallery's systems on the page: legible, nothing covered or cut, lines that hardly cross.

`make pictures` runs this with RTGEN_PICTURES=yes, which takes the pictures of docs/ui.md.
"""

from __future__ import annotations

import io
import itertools
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from ui_bench import QUIET, ROOT, opened, select, until

from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
PICTURES = ROOT / "docs" / "images" / "ui"
WIRINGS = ROOT / "docs" / "images" / "gallery"
MOST_COLOURS = Image.Quantize.MAXCOVERAGE
"""Keeps the colours of thin curves, which median cut replaces."""
TEXT_PX = 9
"""The least height of the letters of a port's name."""
RECTANGLES = (
    "all => all.map(each => { const r = each.getBoundingClientRect();"
    " return [r.left, r.top, r.right, r.bottom]; })"
)
Point = tuple[float, float]


@dataclass(frozen=True)
class Look:
    """The content of a picture: the run at a time, a component, a view beside it."""

    file: str
    time: float
    component: str
    tab: str
    height: int = 900

    @property
    def name(self) -> str:
        """The name of the picture."""
        return Path(self.file).stem


LOOKS = (
    Look("specs/navigation/rh3_goal.xml", 5, "Odometry0", "Values"),
    Look("specs/navigation/rh3_path.xml", 20, "Odometry0", "Map"),
    Look("specs/navigation/obstacles.xml", 20, "ObstacleMonitor0", "Map", 1000),
    Look("specs/navigation/map.xml", 20, "DispPosition0", "Map"),
    Look("specs/tecs/rh3_board.xml", 5, "MotorBoardMarshaller0", "Services"),
    Look("specs/canopen/rh3_beego.xml", 3, "LeftWheel0", "Values"),
    Look("specs/canopen/fourx.xml", 3, "RefHardFourX0", "Values", 1240),
    Look("specs/canopen/pdo_linking.xml", 3, "Motor0", "Buses"),
    Look("specs/interfaces/phase3.xml", 5, "TravelControl0", "Configuration"),
    Look("specs/experiments/interchange", 5, "RefHard0", "Values"),
    Look("specs/experiments/two_robots", 10, "RefHard0", "Map"),
    Look("specs/experiments/chain", 10, "RefHard0", "Map"),
    Look("specs/experiments/leader_exchange", 40, "RefHard0", "Timeline"),
    Look("specs/experiments/one_to_four", 40, "JoystickA0", "Drive"),
    Look("specs/embedded/environment.xml", 5, "ObstacleMonitor0", "Map"),
)


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        project = CommandProject(QUIET, [look.file for look in LOOKS])
        yield Session(project, LOOKS[0].file, SimulatedClock)


@pytest.fixture
def still(browser: Any, server: Any) -> Iterator[Any]:
    """Yield a page whose time stands still."""
    with opened(browser, server.address(full=True)) as page:
        yield page


def show(page: Any, session: Session, look: Look) -> None:
    """Show a system, as the page arranges it."""
    page.set_viewport_size({"width": 1440, "height": look.height})
    page.get_by_role("combobox", name="System").select_option(look.file)
    until(page, lambda: session.file == look.file)
    page.get_by_role("heading", name=session.profile.name, exact=True).wait_for()
    page.locator(".wiring[aria-busy=false]").wait_for()
    first = session.system.instances[0]
    page.locator(f'.react-flow__node[data-id="{first}"]').wait_for()
    page.evaluate("new Promise(done => setTimeout(done, 100))")


def picture(page: Any, session: Session, look: Look) -> None:
    """Write the picture of a system, at its time."""
    select(page, look.component)
    page.get_by_role("tab", name=look.tab).click()
    page.get_by_label("Go to time in seconds").fill(str(look.time))
    page.get_by_role("button", name="Go", exact=True).click()
    until(page, lambda: session.now >= look.time)
    page.wait_for_timeout(1000)
    with Image.open(io.BytesIO(page.screenshot())) as taken:
        small = taken.convert("RGB").quantize(256, MOST_COLOURS, kmeans=1)
        small.save(PICTURES / f"{look.name}.png", optimize=True)


def test_systems_of_the_gallery_can_be_read(still: Any, session: Session) -> None:
    for look in LOOKS:
        show(still, session, look)
        boxes = still.locator(".box").evaluate_all(RECTANGLES)
        assert len(boxes) == len(session.system.instances), look.name
        nodes = still.locator(".bus-node").evaluate_all(RECTANGLES)
        for one, other in itertools.combinations([*boxes, *nodes], 2):
            assert not overlap(one, other), look.name
        scale = (boxes[0][2] - boxes[0][0]) / still.locator(".box").first.evaluate(
            "each => each.offsetWidth"
        )
        letters = still.locator(".head strong").first.evaluate(
            "each => parseFloat(getComputedStyle(each).fontSize)"
        )
        assert letters * scale >= TEXT_PX, look.name
        cut = still.locator(
            ".box span, .head, .head strong, .bus-node strong"
        ).evaluate_all(
            "all => all.filter(each => each.scrollWidth > each.clientWidth)"
            ".map(each => each.textContent)"
        )
        assert cut == [], look.name
        wires = still.locator(".react-flow__edge:not(.planned) .react-flow__edge-path")
        drawn = wires.evaluate_all("all => all.map(each => each.getAttribute('d'))")
        assert len(drawn) == len(session.system.connectors), look.name
        assert crossings(drawn) <= crossings(diagram(look.name)), look.name
        if os.environ.get("RTGEN_PICTURES"):
            picture(still, session, look)


def test_each_system_of_the_gallery_has_its_picture_in_the_docs() -> None:
    page = (ROOT / "docs" / "ui.md").read_text(encoding="utf-8")
    for look in LOOKS:
        assert f"rtgen ui {look.file}\n" in page
        assert re.search(rf"!\[[^]]{{30,}}\]\(images/ui/{look.name}\.png\)", page)
    assert {path.stem for path in PICTURES.iterdir()} == {look.name for look in LOOKS}


def overlap(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two boxes (left, top, right, bottom) cover each other."""
    return (
        one[0] < other[2]
        and other[0] < one[2]
        and one[1] < other[3]
        and other[1] < one[3]
    )


def diagram(name: str) -> list[str]:
    """Return the lines of the SVG of a system in the gallery."""
    svg = (WIRINGS / f"{name}_wiring.svg").read_text(encoding="utf-8")
    lines = re.findall(r'<path class="line[^"]*" d="([^"]+)"', svg)
    assert lines
    return lines


def crossings(lines: Sequence[str]) -> int:
    """Return how often lines cross each other."""
    return sum(
        crosses(*one, *other)
        for first, second in itertools.combinations(map(points, lines), 2)
        for one in itertools.pairwise(first)
        for other in itertools.pairwise(second)
    )


def crosses(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Return whether the line from a to b crosses the one from c to d."""

    def side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return (
        side(a, b, c) * side(a, b, d) < -1e-6 and side(c, d, a) * side(c, d, b) < -1e-6
    )


def points(path: str) -> list[Point]:
    """Return the points of an SVG path with absolute M, L, H, V, Q and C; curves in 12 parts."""
    found: list[Point] = []
    for command, text in re.findall(r"([MLHVQC])([^MLHVQC]*)", path):
        numbers = [float(each) for each in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)]
        if command == "H":
            found.append((numbers[0], found[-1][1]))
        elif command == "V":
            found.append((found[-1][0], numbers[0]))
        elif command in "ML":
            found.append((numbers[0], numbers[1]))
        else:
            control = [found[-1], *zip(numbers[::2], numbers[1::2], strict=True)]
            found += [curve(control, part / 12) for part in range(1, 13)]
    return found


def curve(control: Sequence[Point], part: float) -> Point:
    """Return the point of a Bezier curve, by de Casteljau."""
    while len(control) > 1:
        control = [
            (p[0] + (q[0] - p[0]) * part, p[1] + (q[1] - p[1]) * part)
            for p, q in itertools.pairwise(control)
        ]
    return control[0]
