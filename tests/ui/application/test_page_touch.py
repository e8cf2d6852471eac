"""The page by fingers alone, on a phone, a tablet and a laptop with a touch screen."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from attached_program import attached, running
from page_flaws import too_small, violations
from patience import PATIENCE
from ui_bench import (
    GOAL,
    QUIET,
    ROOT,
    Finger,
    Point,
    centre,
    serving,
    until,
)

from rtgen.cli import run as rtgen
from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
PHONE, TABLET, LAPTOP = (390, 844), (820, 1180), (1440, 900)
ROOM = 1001
"""The least width of a page with panes [px]."""
POSE = "Odometry0.OdometryPosition"


class Hand:
    """A page that is touched, and the run that it shows."""

    def __init__(self, page: Any, session: Session) -> None:
        self.page, self.session = page, session
        self.finger = Finger(page)
        width = page.viewport_size["width"]
        self.has_panes, self.is_phone = width >= ROOM, width == PHONE[0]

    def tap(self, name: str, role: str = "button") -> None:
        """Touch what has exactly this name."""
        self.page.get_by_role(role, name=name, exact=True).tap()

    def more(self, view: str) -> None:
        """Open a view that has no place in the bar, or among the tabs that are seen."""
        page = self.page
        if not self.has_panes:
            self.tap("More")
            page.get_by_role("dialog", name="More").get_by_role(
                "button", name=view, exact=True
            ).first.tap()
            return
        tab = page.get_by_role("tab", name=view, exact=True)
        hidden = page.get_by_role("button", name="More views")
        if tab.get_attribute("aria-selected") == "true":
            return
        hidden.last.tap()
        item = page.get_by_role("menuitem", name=view, exact=True)
        page.get_by_role("menuitem").first.wait_for()
        if item.is_visible():
            item.tap()
        else:
            page.touchscreen.tap(5, 5)
            tab.tap()

    def show(self, view: str) -> None:
        """Open a view."""
        bar = self.page.get_by_role("navigation", name="Views")
        name = "Time" if view == "Timeline" else view
        button = bar.get_by_role("button", name=name, exact=True)
        if self.has_panes and view == "Wiring":
            return
        if not self.has_panes and button.count():
            button.tap()
        else:
            self.more(view)

    def component(self, name: str, view: str = "Values") -> None:
        """Touch a box, and open a view of it."""
        self.show("Wiring")
        self.page.get_by_label(f"{name}, ").locator(".head").tap()
        self.details()
        tab = self.page.get_by_role("tab", name=view, exact=True)
        tab.tap()
        until(self.page, lambda: tab.get_attribute("aria-selected") == "true")

    def details(self) -> None:
        """Open what is told of the touched box or wire; panes show it at once."""
        if not self.has_panes:
            self.tap("Details")

    def pick(self, chooser: Any, name: str) -> None:
        """Choose an option of a list."""
        chooser.tap()
        chooser.get_by_role("option", name=name, exact=True).tap()

    def check(self) -> None:
        """Nothing is too small for a finger, wider than the page, or a flaw for axe."""
        assert too_small(self.page) == []
        assert self.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert violations(self.page) == []


@contextmanager
def touched(
    browser: Any, server: Server, look: tuple[int, int], part: str = ""
) -> Iterator[Any]:
    """Yield a page on a screen that is touched; it must report no errors."""
    width, height = look
    context = browser.new_context(
        viewport={"width": width, "height": height}, has_touch=True, locale="en"
    )
    page = context.new_page()
    page.set_default_timeout(PATIENCE * 1000)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text))
    page.goto(f"{server.address(full=True)}{part}")
    yield page
    context.close()
    assert complaints == [], complaints


@pytest.fixture(
    scope="module",
    params=[PHONE, TABLET, LAPTOP],
    ids=["phone", "tablet", "laptop"],
)
def look(request: pytest.FixtureRequest) -> tuple[int, int]:
    """Return the size of a screen; each has a server of its own."""
    found: tuple[int, int] = request.param
    return found


@pytest.fixture(scope="module")
def page(browser: Any, server: Server, look: tuple[int, int]) -> Iterator[Any]:
    """Yield a page whose run stands still after three seconds."""
    with touched(browser, server, look) as page:
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield page


@pytest.fixture(scope="module")
def hand(page: Any, session: Session) -> Hand:
    """Return the hand on a page whose run stands still after some seconds."""
    hand = Hand(page, session)
    hand.tap("Play")
    until(page, lambda: session.now > 3)
    hand.tap("Pause")
    page.get_by_role("button", name="Play").wait_for()
    return hand


def test_1_components_of_the_page(
    browser: Any, server: Server, look: tuple[int, int]
) -> None:
    with touched(browser, server, look, "#components") as page:
        hand = Hand(page, None)  # type: ignore[arg-type]
        page.get_by_role("heading", name="Components of the page").wait_for()
        hand.check()
        hand.tap("Pressed")
        page.get_by_role("button", name="Pressed", pressed=False).wait_for()
        hand.pick(page.get_by_label("Select"), "first")
        assert page.get_by_label("Select").input_value() == "a"
        far = page.get_by_role("radio", name="far")
        far.tap()
        assert far.is_checked()
        page.get_by_role("checkbox", name="off").tap()
        assert page.get_by_role("checkbox", name="off").is_checked()
        slider = page.get_by_role("slider", name="Slider")
        hand.finger.drag(centre(slider), 30, 0)
        until(page, lambda: int(slider.input_value()) > 60)
        hand.tap("Timeline", "tab")
        page.get_by_role("rowheader", name="Timeline").wait_for()
        hand.tap("Open the window")
        hand.tap("Close A window")
        hand.tap("Ask the question")
        page.get_by_role("alertdialog").get_by_role("button", name="Discard").tap()
        hand.tap("Open the menu")
        assert too_small(page) == []
        hand.tap("Rename", "menuitem")
        page.get_by_role("menu").wait_for(state="detached")
        left = page.get_by_text("left pane")
        before = left.bounding_box()["width"]
        x, y = centre(page.get_by_role("separator", name="Width of the panes"))
        hand.finger.drag((x + 8, y), -60, 0)
        until(page, lambda: left.bounding_box()["width"] < before - 40)


def test_2_panes(hand: Hand) -> None:
    page = hand.page
    if not hand.has_panes:
        for view in ("Map", "Plots", "Wiring"):
            hand.show(view)
            until(page, lambda: page.locator(".screen:visible").count() == 1)
        return
    views = page.locator("[data-tab][aria-selected=true]")

    def seen(*names: str) -> None:
        until(page, lambda: views.all_inner_texts() == [*names])

    hand.check()
    wiring = page.locator(".wiring")
    before = wiring.bounding_box()["width"]
    grip = page.get_by_role("separator", name="Width of the panes")
    x, y = centre(grip)
    hand.finger.drag((x + 8, y), -150, 0)
    until(page, lambda: wiring.bounding_box()["width"] < before - 100)
    place = wiring.bounding_box()
    tab = centre(page.get_by_role("tab", name="Connections", exact=True))
    bottom = place["x"] + place["width"] / 2, place["y"] + place["height"] - 20
    hand.finger.drag(tab, bottom[0] - tab[0], bottom[1] - tab[1])
    seen("Wiring", "Connections", "Values")
    hand.tap("Exchange Values with the main pane")
    seen("Values", "Connections", "Wiring")
    hand.tap("Pane of Connections")
    hand.tap("Close Connections", "menuitem")
    seen("Values", "Wiring")
    for preset, names in {
        "Drive": ("Map", "Drive", "Wiring"),
        "Wire": ("Wiring", "Values"),
    }.items():
        hand.tap("Layout")
        hand.tap(preset, "menuitem")
        seen(*names)
    page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()


REACHED = """each => {
    const path = each.querySelector("path");
    for (let at = 0; at < path.getTotalLength(); at += 4) {
        const { x, y } = path.getPointAtLength(at).matrixTransform(path.getScreenCTM());
        if (each.contains(document.elementFromPoint(x, y))) return [x, y];
    }
}"""
"""The first point of a wire that no other one covers."""
SHIFT = "each => each.style.transform"


def port(hand: Hand, instance: str, name: str) -> Point:
    found = f'[data-nodeid="{instance}"][data-handleid="{name}"]'
    return centre(hand.page.locator(found).last)


def has(session: Session, source: str, target: str) -> bool:
    return any(
        f"{each.source.instance}.{each.source.port}" == source
        and f"{each.target.instance}.{each.target.port}" == target
        for each in session.whole().connections
    )


def test_3_wiring(hand: Hand) -> None:
    page, session = hand.page, hand.session
    hand.show("Wiring")
    view = page.locator(".react-flow__viewport")

    def moved(before: str) -> bool:
        return bool(view.evaluate(SHIFT) != before)

    fit = page.get_by_role("button", name="Fit View")
    fit.tap()
    whole = view.evaluate(SHIFT)
    box = page.get_by_label("OmniTo2WD0, ")
    # Boxes are most of a phone's screen: fingers on them move it as well.
    hand.finger.drag(centre(box), 40, 60)
    until(page, lambda: moved(whole))
    shifted = view.evaluate(SHIFT)
    hand.finger.pinch(centre(box), 30, 60)
    until(
        page,
        lambda: view.evaluate(SHIFT).split("scale")[1] != shifted.split("scale")[1],
    )
    fit.tap()
    until(page, lambda: not moved(whole))
    page.get_by_label("Navigation0, ").locator(".head").tap()
    page.locator(".box.selected", has_text="Navigation0").wait_for()
    source, target = "RefHardRh30.PlantPose", "Odometry0.LocalizedPosition"
    fit.tap()
    x, y = port(hand, *source.split("."))
    to = port(hand, *target.split("."))
    hand.finger.drag((x + 6, y), to[0] - x - 10, to[1] - y)
    until(page, lambda: has(session, source, target))
    wire = page.locator(f'.react-flow__edge[aria-label*="{source}"]')
    wire.wait_for()
    hand.tap("Undo")
    until(page, lambda: not has(session, source, target))
    wire.wait_for(state="detached")
    hand.tap("Arranged")
    fit.tap()
    page.locator(".wiring[aria-busy=false]").wait_for()
    at = session.places.get("PathFollower0")
    head = page.get_by_label("PathFollower0, ").locator(".head")
    hand.finger.drag(centre(head), 30, 40)
    until(page, lambda: session.places.get("PathFollower0") != at)
    hand.tap("Undo")
    until(page, lambda: session.places.get("PathFollower0") == at)
    hand.tap("Arranged")
    fit.tap()
    hand.check()
    hand.component("Navigation0")
    hand.tap("Remove Navigation0")
    until(page, lambda: "Navigation0" not in session.system.instances)
    hand.tap("Undo")
    until(page, lambda: "Navigation0" in session.system.instances)


WHEELS = "RefHardRh30.OutWheelAngle"
LENGTH = "dataport.inport.buffer.length"


def test_4_inspector(hand: Hand) -> None:
    page, session = hand.page, hand.session

    def length() -> str | None:
        [found] = [
            each
            for each in session.whole().connections
            if f"{each.source.instance}.{each.source.port}" == WHEELS
        ] or [None]
        return found and {e.name: e.text for e in found.properties}.get(LENGTH, "")

    hand.show("Wiring")
    hand.tap("Fit View")
    x, y = page.locator(f'.react-flow__edge[aria-label*="{WHEELS}"]').evaluate(REACHED)
    page.touchscreen.tap(x, y)
    hand.details()
    wire = page.get_by_role("region", name="Connection", exact=True)
    wire.get_by_text("Buffer of the InPort").tap()
    field = wire.get_by_label("inport length")
    field.tap()
    field.fill("3")
    hand.check()
    wire.get_by_role("button", name="Show what changes").tap()
    window = page.get_by_role("dialog", name="Properties of the connection")
    window.locator(".added").get_by_text('value="3"').wait_for()
    hand.check()
    window.get_by_role("button", name="Apply").tap()
    until(page, lambda: length() == "3")
    window.wait_for(state="detached")
    wire.get_by_role("button", name="RefHardRh30", exact=True).tap()
    wire.get_by_role("button", name="Close the connection").tap()
    wire.wait_for(state="detached")


def shown(page: Any) -> float:
    text = page.get_by_label("Time of the run").inner_text()
    return float(text.removesuffix(" s"))


def test_5_time_line(hand: Hand) -> None:
    page, session = hand.page, hand.session
    slider = page.get_by_role("slider", name="Look at time")
    x, y = centre(slider)
    page.touchscreen.tap(x, y)
    until(page, lambda: 0.4 < shown(page) / session.now < 0.6)
    width = slider.bounding_box()["width"]
    hand.finger.drag((x, y), -0.25 * width, 0)
    until(page, lambda: 0.1 < shown(page) / session.now < 0.4)
    # The components became active at 0 s: a touch near that mark means it.
    page.touchscreen.tap(slider.bounding_box()["x"] + 17, y)
    until(page, lambda: shown(page) == 0.0)
    hand.tap("Live")
    until(page, lambda: abs(shown(page) - session.now) < 0.001)
    before = session.now
    hand.tap("Step")
    until(page, lambda: session.now > before)
    hand.show("Timeline")
    hand.pick(page.get_by_label("Kind"), "states")
    page.get_by_role("list", name="Timeline").get_by_text("ACTIVE").first.wait_for()
    hand.check()
    hand.pick(page.get_by_label("Kind"), "all kinds")


def test_6_plots(hand: Hand) -> None:
    page = hand.page
    hand.component("Odometry0")
    region = page.get_by_role("region", name=POSE)
    picture = region.locator(".u-over").first
    picture.wait_for()
    cursor = region.get_by_role("status", name="Time at the cursor")
    x, y = centre(picture)
    page.touchscreen.tap(x, y)
    until(page, lambda: cursor.inner_text() != "")
    tapped = cursor.inner_text()
    hand.finger.drag((x, y), -40, 0)
    until(page, lambda: cursor.inner_text() not in ("", tapped))
    span = page.get_by_label("Plots show").first
    chosen = "each => each.selectedOptions[0].textContent"
    hand.finger.pinch((x, y), 20, 60)
    until(page, lambda: " s to " in span.evaluate(chosen))
    first = span.evaluate(chosen)
    hand.finger.touch((x - 30, y), (x + 30, y))
    hand.finger.move((x - 10, y), (x + 50, y))
    hand.finger.lift()
    until(page, lambda: span.evaluate(chosen) != first)
    region.get_by_role("button", name="Show all times").tap()
    until(page, lambda: " s to " not in span.evaluate(chosen))
    tick = region.get_by_role("checkbox").first
    tick.tap()
    assert not tick.is_checked()
    tick.tap()
    hand.check()
    # A row of a table cannot be dragged by a finger: its port is chosen.
    hand.show("Plots")
    page.get_by_text("To compare two runs").wait_for()
    page.get_by_text("or drag a row").wait_for(state="hidden")
    hand.tap("New plot")
    plot = page.get_by_role("region", name="Plot 1")
    hand.pick(plot.get_by_label("Add a port to Plot 1"), POSE)
    plot.get_by_role("row", name=f"{POSE} data.heading").wait_for()
    hand.check()
    plot.get_by_role("button", name="Remove Plot 1").tap()
    plot.wait_for(state="detached")


def test_6_map(hand: Hand) -> None:
    page = hand.page
    hand.show("Map")
    area = page.get_by_role("img", name="Map, scale bar")
    legend = page.get_by_role("list", name="On the map")
    legend.get_by_text("goal at x").first.wait_for()
    fit = page.get_by_role("button", name="Fit", exact=True)
    scale = area.get_attribute("aria-label")
    hand.finger.pinch(centre(area), 30, 110)
    until(page, lambda: area.get_attribute("aria-label") != scale)
    until(page, lambda: fit.get_attribute("aria-pressed") == "false")
    fit.tap()
    until(page, lambda: area.get_attribute("aria-label") == scale)
    hand.finger.drag(centre(area), 50, 30)
    until(page, lambda: fit.get_attribute("aria-pressed") == "false")
    hand.tap("Measure")
    measured = page.get_by_role("status", name="Measured")
    measured.get_by_text("drag").wait_for()
    hand.finger.drag(centre(area), 80, 0)
    measured.get_by_text(re.compile(r"m, -?0\.0°")).wait_for()
    hand.tap("Measure")
    tick = legend.get_by_role("checkbox").first
    tick.tap()
    legend.get_by_text("hidden").wait_for()
    tick.tap()
    fit.tap()
    hand.check()


def test_8_commands_and_palette(hand: Hand) -> None:
    page, session = hand.page, hand.session
    hand.tap("Commands")
    find = page.get_by_role("combobox", name="Find a command")
    find.tap()
    hand.check()
    find.fill("keys")
    page.get_by_role("option").first.tap()
    page.get_by_role("dialog", name="Keys").wait_for()
    hand.check()
    hand.tap("Close Keys")
    if hand.is_phone:
        hand.more("Components")
    else:
        hand.tap("Keys")
        hand.tap("Close Keys")
        hand.tap("Components")
    palette = page.get_by_role("navigation", name="Palette")
    search = palette.get_by_role("searchbox")
    search.tap()
    search.fill("odometry")
    hand.check()
    palette.get_by_role("button", name="Add Odometry", exact=True).tap()
    until(page, lambda: "Odometry1" in session.system.instances)
    palette.get_by_role("button", name="Close the palette").tap()
    hand.show("Wiring")
    head = page.get_by_label("Odometry1, ").locator(".head")
    hand.tap("Arranged")
    hand.tap("Fit View")
    hand.finger.drag(centre(head), 25, 35)
    until(page, lambda: "Odometry1" in session.places)
    hand.tap("Arranged")
    while "Odometry1" in session.system.instances:
        hand.tap("Undo")
        page.wait_for_timeout(20)
    page.get_by_label("Odometry1, ").wait_for(state="detached")


def test_9_more_views(hand: Hand) -> None:
    for view in ("Console", "Timeline", "Drive", "Configuration", "Services"):
        if view in ("Configuration", "Services"):
            hand.component("Odometry0", view)
        else:
            hand.show(view)
        hand.check()
    hand.show("Wiring")


def test_7_bus(browser: Any, look: tuple[int, int]) -> None:
    file = ROOT / "specs/canopen/fourx.xml"
    session = Session(CommandProject(QUIET, [str(file)]), str(file), SimulatedClock)

    def state() -> str:
        [found] = [n for b in session.whole().buses for n in b.nodes if n.node_id == 1]
        return found.nmt_state

    with (
        serving(Server(session, "127.0.0.1", 0)) as server,
        touched(browser, server, look) as page,
    ):
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        hand = Hand(page, session)
        hand.tap("Play")
        hand.show("Buses")
        page.get_by_role("row", name="front_left operational").wait_for()
        frames = page.get_by_role("table", name="Frames")
        field = page.get_by_label("Filter", exact=True)
        field.tap()
        field.fill("kind:heartbeat")
        frames.get_by_text("tpdo1", exact=True).first.wait_for(state="detached")
        hand.tap("Hold")
        page.get_by_role("button", name="Hold", pressed=True).wait_for()
        hand.check()
        hand.tap("Hold")
        page.get_by_role("button", name="NMT command to front_left").tap()
        hand.tap("stop", "menuitem")
        until(page, lambda: state() == "stopped")
        page.get_by_role("button", name="NMT command to front_left").tap()
        hand.tap("start", "menuitem")
        until(page, lambda: state() == "operational")
        objects = page.get_by_role("region", name="Object dictionary")
        hand.pick(objects.get_by_label("Node"), "front_left")
        for branch in ("Communication", "1018h Identity"):
            objects.locator("summary", has_text=re.compile(f"^{branch}")).tap()
        objects.get_by_role("button", name="Read all of 1018h Identity").tap()
        objects.get_by_role("status", name="Value of 1018h:1").get_by_text(
            "0x"
        ).wait_for()
        hand.check()
        search = objects.get_by_label("Objects", exact=True)
        search.tap()
        search.fill("6083")
        objects.get_by_label("New value of 6083h:0").fill("1234")
        objects.get_by_role("button", name="Write 6083h:0").tap()
        objects.get_by_role("status", name="Value of 6083h:0").get_by_text(
            "1234", exact=True
        ).wait_for()


def test_10_recording_beside_an_attached_run(
    browser: Any,
    look: tuple[int, int],
    sockets: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    del sockets  # the folder of the run's socket
    file = tmp_path / "slow.mcap"
    assert rtgen(["run", str(GOAL), "--until", "1", "--record", str(file), "-q"]) == 0
    monkeypatch.chdir(tmp_path)
    with (
        running(str(GOAL), "--clock", "sim", "--rate", "0.5", "-q") as program,
        attached(program.path) as session,
        serving(Server(session, "127.0.0.1", 0)) as server,
        touched(browser, server, look) as page,
    ):
        page.locator(".react-flow__node").first.wait_for()
        hand = Hand(page, session)
        hand.show("Timeline")
        hand.tap("Compare with a recording")
        hand.tap("slow.mcap", "menuitem")
        beside = page.get_by_role("button", name="Beside: slow.mcap")
        beside.wait_for()
        hand.component("PathFollower0")
        page.get_by_role("columnheader", name="beside", exact=True).first.wait_for()
        hand.tap("Deactivate PathFollower0")
        page.get_by_label("PathFollower0, PathFollower, INACTIVE").wait_for(
            state="attached"
        )
        hand.check()
        hand.show("Timeline")
        hand.tap("Compare with a recording")
        hand.tap("Compare with nothing", "menuitem")
        beside.wait_for(state="detached")
