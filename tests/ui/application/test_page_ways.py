"""The ways through the page: overview, commands, keys, palette, rename, time line, wires."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from heating_project import texts, write
from page_flaws import flaws, violations
from ui_bench import (
    QUIET,
    WIDE,
    by_both_hands,
    by_mouse,
    open_menu,
    opened,
    select,
    until,
)

from rtgen.cli import run as rtgen
from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
HEATER = "Heater0, Heater, ACTIVE"


@pytest.fixture(scope="module")
def look() -> tuple[int, str]:
    """Return one look, since these tests do not depend on it."""
    return WIDE


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("ways") / "project"


@pytest.fixture(scope="module")
def session(folder: Path) -> Iterator[Session]:
    write(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("RTGEN_CACHE_DIR", str(folder.parent / "cache"))
        patch.setattr(sys, "path", [*sys.path])
        assert rtgen(["generate", "-q"]) == 0
        file = "systems/warm"
        yield Session(CommandProject(QUIET, [file]), file, SimulatedClock)
    for name in [*sys.modules]:
        if name.partition(".")[0] in ("heating", "warmth"):
            del sys.modules[name]


@pytest.fixture(scope="module")
def page(browser: Any, server: Server) -> Iterator[Any]:
    """Yield a page whose time stands still."""
    with opened(browser, server.address(full=True)) as page:
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield page


def go(page: Any, session: Session, time: float) -> None:
    """Set the time of the run."""
    page.get_by_label("Go to time in seconds").fill(str(time))
    page.get_by_label("Go to time in seconds").press("Enter")
    until(page, lambda: session.now == time)
    page.get_by_label("Time of the run").get_by_text(f"{time:.3f} s").wait_for()


def test_the_overview_says_which_connection_loses_samples_and_why(
    page: Any, session: Session
) -> None:
    overview = page.locator(".panel")
    overview.get_by_text("2 components, 3 connections").wait_for()
    overview.get_by_text("No connection loses samples").wait_for()
    overview.get_by_text("disconnect").wait_for()
    go(page, session, 4.5)
    select(page, "Controller0")
    page.get_by_role("button", name="Deactivate Controller0").click()
    select(page, "")
    page.get_by_label("Speed").select_option("10")
    page.get_by_role("button", name="Play").click()
    lost = overview.get_by_role("region", name="Lost samples")
    lost.get_by_text("Heater0.temperature to Controller0.temperature").wait_for()
    lost.get_by_text(re.compile(r"^\d+ overwritten in a full buffer$")).wait_for()
    page.get_by_role("button", name="Pause").click()
    page.get_by_label("Speed").select_option("1")
    page.locator(".health.lossy").get_by_text(re.compile(r"\d+ lost")).wait_for()
    lost.get_by_role("button", name="Heater0.temperature to").click()
    wire = page.get_by_role("region", name="Connection", exact=True)
    wire.get_by_text(re.compile(r"^\d+ samples lost: \d+ overwritten")).wait_for()
    wire.get_by_text("Heating::Temperature").wait_for()
    subscription = wire.get_by_role("combobox", name="subscription type")
    assert subscription.input_value() in ("", "flush")
    assert violations(page) == []
    wire.get_by_role("button", name="Controller0").click()
    page.get_by_role("combobox", name="Component").filter(
        has=page.locator("option:checked", has_text="Controller0")
    ).wait_for()
    wire.get_by_role("button", name="Close the connection").click()
    wire.wait_for(state="detached")
    select(page, "")


def test_a_connection_is_looked_at_and_cut_by_keyboard(
    page: Any, session: Session
) -> None:
    edge = page.locator('.react-flow__edge[aria-label*="Controller0.power"]')
    edge.focus()
    page.keyboard.press("Enter")
    wire = page.get_by_role("region", name="Connection", exact=True)
    wire.get_by_text("Heating::Power").wait_for()
    before = len(session.system.connectors)
    wire.get_by_role("button", name="Cut").press("Enter")
    until(page, lambda: len(session.system.connectors) == before - 1)
    wire.wait_for(state="detached")
    page.get_by_role("button", name="Undo", disabled=False).press("Enter")
    until(page, lambda: len(session.system.connectors) == before)


def test_commands_are_found_by_their_names(page: Any, session: Session) -> None:
    go(page, session, 1.0)
    for way in ("Control+k", ""):
        if way:
            page.keyboard.press(way)
        else:
            page.get_by_role("button", name="Commands").click()
        field = page.get_by_role("combobox", name="Find a command")
        field.wait_for()
        assert violations(page) == []
        field.fill("select heat")
        page.get_by_role("option", name="Select Heater0").wait_for()
        page.keyboard.press("Enter")
        field.wait_for(state="detached")
        page.get_by_role("complementary").get_by_text("10 Hz periodic").wait_for()
        select(page, "")
    goal = page.get_by_label("Go to time in seconds")
    goal.focus()
    page.keyboard.press("Control+k")
    field.fill("compare")
    page.get_by_role("option", name="Keep to compare").wait_for()
    page.keyboard.press("Escape")
    goal.and_(page.locator(":focus")).wait_for()
    page.keyboard.press("Control+k")
    field.fill("view timel")
    page.keyboard.press("Enter")
    page.get_by_role("tab", name="Timeline", selected=True).wait_for()
    page.get_by_role("tab", name="Values").click()


def test_the_timeline_has_what_was_planned(page: Any, session: Session) -> None:
    go(page, session, 1.0)
    page.get_by_role("tab", name="Timeline").click()
    planned = page.locator("summary", has_text="planned, the next one at 2.000 s")
    planned.click()
    lines = page.get_by_role("list", name="Planned").get_by_role("listitem")
    count = lines.count()
    wire = "connect Heater0.temperature to Controller0.temperature"
    lines.filter(has_text=wire).wait_for()
    go(page, session, 3.2)
    happened = page.get_by_role("list", name="Timeline")
    happened.get_by_text(wire).wait_for()
    page.locator("summary", has_text="2 planned, the next one at 3.500 s").wait_for()
    assert 0 < lines.count() < count
    page.get_by_label("Kind").select_option("events")
    page.get_by_label("Component").last.select_option("Heater0")
    happened.get_by_text(wire).wait_for()
    happened.get_by_text("ACTIVE").first.wait_for(state="detached")
    page.evaluate("location.hash = ''")
    field = page.get_by_label("Go to time in seconds")
    for text, reason in (("soon", '"soon" is not a number'), ("-1", "not between")):
        field.fill(text)
        field.press("Enter")
        page.get_by_role("alert").get_by_text(reason).wait_for()
        assert field.get_attribute("aria-invalid") == "true"
        assert flaws(page) == violations(page) == []
    field.fill("3.2")
    page.get_by_role("alert").wait_for(state="detached")
    page.get_by_role("tab", name="Values").click()


def test_an_empty_view_leads_to_where_there_is_something(page: Any) -> None:
    select(page, "Controller0")
    page.get_by_role("tab", name="Services").click()
    page.get_by_text("This component provides no service.").wait_for()
    page.get_by_role("list", name="Components with something here").get_by_role(
        "button", name="Heater0", exact=True
    ).click()
    page.get_by_role("button", name="Call ").first.wait_for()
    select(page, "")
    page.get_by_role("tab", name="Map").click()
    page.get_by_role("button", name="Plots of numbers").press("Enter")
    page.get_by_role("tab", name="Plots", selected=True).wait_for()
    page.get_by_role("tab", name="Values").click()


def test_keys_of_players(page: Any, session: Session) -> None:
    go(page, session, 1.0)
    page.locator(".react-flow__pane").click(position={"x": 5, "y": 5})
    page.keyboard.press("?")
    keys = page.get_by_role("dialog", name="Keys")
    keys.get_by_text("play or pause").wait_for()
    assert violations(page) == []
    page.keyboard.press("Escape")
    keys.wait_for(state="detached")
    page.locator(".react-flow__pane").click(position={"x": 5, "y": 5})
    page.keyboard.press("Space")
    until(page, lambda: session.runner.playing)
    page.get_by_role("button", name="Pause").wait_for()
    page.keyboard.press("Space")
    until(page, lambda: not session.runner.playing)
    page.get_by_role("button", name="Play").wait_for()
    before = session.now
    page.keyboard.press(".")
    until(page, lambda: session.now > before)
    page.keyboard.press(",")
    page.get_by_role("status").get_by_text("looking back").wait_for()
    page.keyboard.press("l")
    page.get_by_role("status").get_by_text(re.compile("^live")).wait_for()


def test_components_are_filtered_and_dragged_to_their_place(
    page: Any, session: Session
) -> None:
    page.get_by_role("button", name="Components", exact=True).click()
    palette = page.get_by_role("navigation", name="Palette")
    palette.get_by_role("searchbox").fill("heat")
    add = palette.get_by_role("button", name="Add Heater")
    add.wait_for()
    assert palette.get_by_text("Demo").is_visible()
    palette.get_by_role("searchbox").fill("power watt")
    palette.get_by_text("No component has").wait_for()
    palette.get_by_role("searchbox").fill("heater")
    assert violations(page) == []
    add.drag_to(page.locator(".react-flow__pane"), target_position={"x": 300, "y": 80})
    until(page, lambda: "Heater1" in session.places)
    assert "Heater1" in session.system.instances
    page.get_by_role("button", name="Undo", disabled=False).click()
    until(page, lambda: "Heater1" not in session.system.instances)
    palette.get_by_role("button", name="Close the palette").click()
    palette.wait_for(state="detached")


@pytest.mark.nightly
@by_both_hands
def test_a_rename_shows_what_changes_before_it_does(
    page: Any, session: Session, folder: Path, press: Callable[[Any], None]
) -> None:
    go(page, session, 1.0)
    page.get_by_label(HEATER).wait_for()
    before = texts(folder)
    window = page.get_by_role("dialog", name="Rename")
    if press is by_mouse:
        open_menu(page.get_by_label(HEATER), press)
        page.get_by_role("menuitem", name="Rename").click()
    else:
        select(page, "Heater0")
        page.locator(".react-flow__pane").click(position={"x": 5, "y": 5})
        select(page, "Heater0")
        page.get_by_role("tab", name="Values").focus()
        page.keyboard.press("F2")
    window.wait_for()
    field = window.get_by_label("New name")
    field.fill("Controller0")
    field.press("Enter")
    window.get_by_role("alert").get_by_text("beside it").wait_for()
    what = window.get_by_role("combobox", name="What is renamed")
    what.select_option(label="component Heater")
    field.fill("Radiator")
    press(window.get_by_role("button", name="Show what changes"))
    changes = window.get_by_role("region", name="What changes")
    changes.get_by_text(
        "src/heating/heater.py becomes src/heating/radiator.py"
    ).wait_for()
    changes.get_by_text("+component Radiator {").wait_for()
    assert violations(page) == []
    assert texts(folder) == before
    press(window.get_by_role("button", name="Rename", exact=True))
    window.wait_for(state="detached")
    page.get_by_label("Heater0, Radiator, ACTIVE").wait_for()
    assert (folder / "src/heating/radiator.py").is_file()
    assert session.now == 1.0
    page.get_by_role("button", name="Undo", disabled=False).click()
    page.get_by_label(HEATER).wait_for()
    until(page, lambda: texts(folder) == before)


def test_the_time_line_has_marks_and_what_is_planned(
    page: Any, session: Session
) -> None:
    def marks(kind: str) -> int:
        path = page.locator(f".marks path.{kind}").get_attribute("d")
        return path.count("M")

    go(page, session, 2.5)
    until(page, lambda: marks("plan") == 5)
    planned = page.locator(".react-flow__edge.planned")
    planned.wait_for()
    assert marks("event") == 3
    assert marks("state") == 2
    page.get_by_text(re.compile("^at 3")).wait_for(state="detached")
    go(page, session, 3.2)
    planned.wait_for(state="detached")
    until(page, lambda: marks("plan") == 2)


COVERED = """() => {
    const boxes = [...document.querySelectorAll(".react-flow__node-component")].map(each => {
        const { x, y, width, height } = each.getBoundingClientRect();
        return [each.dataset.id, x + 3, y + 3, x + width - 3, y + height - 3];
    });
    const found = [];
    for (const wire of document.querySelectorAll(".react-flow__edge")) {
        const path = wire.querySelector("path");
        const [matrix, length] = [path.getScreenCTM(), path.getTotalLength()];
        for (let at = 12; at < length - 12; at += 4) {
            const { x, y } = path.getPointAtLength(at).matrixTransform(matrix);
            for (const [name, left, top, right, bottom] of boxes)
                if (x > left && x < right && y > top && y < bottom)
                    found.push(`${wire.getAttribute("aria-label")} behind ${name}`);
        }
    }
    return [...new Set(found)];
}"""
"""The wires that go through boxes."""


def test_wires_go_around_boxes(page: Any) -> None:
    for _ in range(2):
        page.locator(".wiring[aria-busy=false]").wait_for()
        until(page, lambda: page.evaluate(COVERED) == [])
        page.get_by_role("button", name="Arranged").click()


@pytest.mark.nightly
def test_a_small_map_shows_the_whole_wiring(page: Any) -> None:
    button = page.get_by_role("button", name="Small map")
    whole = page.get_by_role("img", name="Map of the wiring")
    button.press("Enter")
    whole.wait_for()
    boxes = whole.locator(".STATE_ACTIVE, .STATE_INACTIVE")
    until(page, lambda: boxes.count() == 2)
    assert violations(page) == []
    button.click()
    whole.wait_for(state="detached")


@pytest.mark.nightly
def test_a_page_has_no_flaw_for_axe(page: Any) -> None:
    for width, scheme in ((1440, "light"), (1024, "dark")):
        page.set_viewport_size({"width": width, "height": 900})
        page.emulate_media(color_scheme=scheme)
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        for name in ("", "Heater0"):
            select(page, name)
            assert violations(page) == [], (width, scheme, name)
