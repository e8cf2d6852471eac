"""Panes of views: by presets, menus, dragging; resized, exchanged, remembered, in the address."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from page_flaws import flaws, violations
from ui_bench import (
    WIDE,
    by_both_hands,
    by_keyboard,
    by_mouse,
    choose,
    opened,
    select,
    until,
)

from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]


@pytest.fixture(scope="module")
def look() -> tuple[int, str]:
    """Return one look, since these tests do not depend on it."""
    return WIDE


@pytest.fixture
def panes(browser: Any, server: Server) -> Iterator[Any]:
    """Yield a page with the panes of a first visit."""
    with opened(browser, server.address(full=True)) as page:
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield page


def shown(page: Any) -> list[str]:
    """Return the views that are seen, the main pane first."""
    found: list[str] = page.locator("[data-tab][aria-selected=true]").all_inner_texts()
    return found


def arrange(page: Any, name: str, press: Callable[[Any], None] = by_mouse) -> None:
    press(page.get_by_role("button", name="Layout"))
    choose(page, name, press)


def pane(page: Any, view: str, item: str, press: Callable[[Any], None]) -> None:
    """Choose an item of the menu of the pane that shows a view."""
    press(page.get_by_role("button", name=f"Pane of {view}", exact=True))
    choose(page, item, press)


def address(page: Any) -> str:
    """Return the panes in the address."""
    found: str = page.evaluate("location.hash")
    return found


PRESETS = {
    "Wire": ["Wiring", "Values"],
    "Drive": ["Map", "Drive", "Wiring"],
    "Compare": ["Plots", "Values", "Timeline"],
}


@by_both_hands
def test_presets_arrange_the_panes(panes: Any, press: Callable[[Any], None]) -> None:
    for name in (*PRESETS, "Wire"):
        arrange(panes, name, press)
        until(panes, lambda name=name: shown(panes) == PRESETS[name])
        if press is by_mouse:
            panes.locator(".wiring[aria-busy=true]").wait_for(state="detached")
            assert violations(panes) == [], name
            assert flaws(panes) == [], name


def test_what_is_empty_is_not_offered(panes: Any) -> None:
    """The system has no bus, and calls no board."""
    before = shown(panes)
    panes.get_by_role("button", name="Layout").click()
    bus = panes.get_by_role("menuitem", name="Bus There is no CAN bus.")
    assert bus.is_disabled()
    bus.click(force=True)
    panes.keyboard.press("Escape")
    panes.get_by_role("button", name="Pane of Wiring", exact=True).click()
    assert panes.get_by_role("menuitem", name="Show Buses here").is_disabled()
    assert panes.get_by_role("menuitem", name="Show Map here").is_enabled()
    panes.keyboard.press("Escape")
    panes.keyboard.press("Control+k")
    panes.get_by_role("combobox", name="Find a command").fill("view bo")
    board = panes.get_by_role("option", name="View Boards", disabled=True)
    board.get_by_text("No board has been called.").wait_for()
    panes.keyboard.press("Escape")
    assert shown(panes) == before


@by_both_hands
def test_panes_are_split_exchanged_and_closed(
    panes: Any, press: Callable[[Any], None]
) -> None:
    # Tabs that have no room scroll, and are in a menu.
    row = panes.locator("[data-tab-list]").last
    more = panes.get_by_role("button", name="More views")
    for view in ("Timeline", "Values"):
        press(more)
        choose(panes, view, press)
        until(panes, lambda view=view: shown(panes) == ["Wiring", view])
        tab = panes.get_by_role("tab", name=view).bounding_box()
        assert tab["x"] >= row.bounding_box()["x"]
        assert tab["x"] + tab["width"] <= more.bounding_box()["x"]
        assert row.bounding_box()["height"] < 1.5 * tab["height"]
    pane(panes, "Values", "Values below the others", press)
    until(panes, lambda: shown(panes) == ["Wiring", "Connections", "Values"])
    pane(panes, "Values", "Show Map here", press)
    until(panes, lambda: shown(panes) == ["Wiring", "Connections", "Map"])
    press(panes.get_by_role("button", name="Exchange Map with the main pane"))
    until(panes, lambda: shown(panes) == ["Map", "Connections", "Wiring"])
    panes.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
    alone = panes.locator("[data-tabset]").filter(has=panes.locator("[data-view=Map]"))
    pane(panes, "Map", "This pane alone", press)
    until(panes, lambda: alone.bounding_box()["width"] == WIDE[0])
    pane(panes, "Map", "All panes", press)
    until(panes, lambda: alone.bounding_box()["width"] < WIDE[0])
    pane(panes, "Wiring", "Close Wiring", press)
    until(panes, lambda: shown(panes) == ["Map", "Connections", "Values"])
    panes.keyboard.press("Control+k")
    panes.get_by_role("combobox", name="Find a command").fill("view wiring")
    panes.keyboard.press("Enter")
    panes.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()


def test_a_tab_is_dragged_to_a_pane_of_its_own(panes: Any) -> None:
    box = panes.locator(".wiring").bounding_box()
    panes.get_by_role("tab", name="Map").hover()
    panes.mouse.down()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] - 20
    panes.mouse.move(x, y - 40, steps=5)
    panes.mouse.move(x, y, steps=5)
    panes.locator("[data-drop-indicator][data-region=bottom]").wait_for()
    panes.mouse.up()
    until(panes, lambda: shown(panes) == ["Wiring", "Map", "Values"])
    map_of = panes.get_by_role("img", name="Map, scale bar").bounding_box()
    assert map_of["y"] > panes.locator(".wiring").bounding_box()["y"] + 100


def test_panes_are_resized_and_remembered(panes: Any) -> None:
    grip = panes.get_by_role("separator", name="Width of the panes")
    wiring = panes.locator(".wiring")
    before = wiring.bounding_box()["width"]
    grip.focus()
    panes.keyboard.press("ArrowLeft")
    until(panes, lambda: wiring.bounding_box()["width"] < before - 10)
    between = wiring.bounding_box()["width"]
    x, y = panes.evaluate("""() => {
            const box = document.querySelector("[role=separator]").getBoundingClientRect();
            return [box.x, box.y + box.height / 2];
        }""")
    panes.mouse.move(x, y)
    panes.mouse.down()
    panes.mouse.move(x - 150, y, steps=4)
    panes.mouse.up()
    until(panes, lambda: wiring.bounding_box()["width"] < between - 100)
    after = wiring.bounding_box()["width"]
    until(panes, lambda: "Wiring~" in address(panes))
    panes.reload()
    wiring.locator(".react-flow__node").first.wait_for()
    assert abs(wiring.bounding_box()["width"] - after) < 4
    # Without an address, the panes are those of the last page.
    panes.goto(re.sub("#.*", "", panes.url))
    panes.reload()
    wiring.locator(".react-flow__node").first.wait_for()
    assert abs(wiring.bounding_box()["width"] - after) < 4


def test_an_address_shows_the_same_elsewhere(
    panes: Any, browser: Any, server: Server
) -> None:
    arrange(panes, "Drive")
    panes.get_by_role("tab", name="Values").click()
    select(panes, "Odometry0")
    until(panes, lambda: shown(panes) == ["Map", "Drive", "Values"])
    until(panes, lambda: "component=Odometry0" in address(panes))
    with opened(browser, f"{server.address(full=True)}{address(panes)}") as other:
        other.get_by_role("complementary").get_by_text("100 Hz periodic").wait_for()
        assert shown(other) == ["Map", "Drive", "Values"]
        assert "token" not in other.url
    for nonsense in ("#panes=((", "#panes=Wiring~x,", "#panes=%ZZ&component=Nobody"):
        with opened(browser, f"{server.address(full=True)}{nonsense}") as other:
            other.locator(".wiring .react-flow__node").first.wait_for()


def test_views_beside_each_other_all_get_their_samples(
    panes: Any, session: Session
) -> None:
    select(panes, "PathFollower0")
    arrange(panes, "Drive")
    panes.get_by_role("tab", name="Values").click()
    panes.get_by_label("Go to time in seconds").fill("3")
    by_keyboard(panes.get_by_role("button", name="Go", exact=True))
    until(panes, lambda: session.now >= 3)
    panes.get_by_role("rowheader", name="va").first.wait_for()
    panes.get_by_role(
        "status", name="Odometry0.OdometryPosition on the map"
    ).get_by_text(re.compile(r"x -?\d")).first.wait_for()


def test_the_console_says_what_was_asked_and_refused(panes: Any) -> None:
    panes.get_by_role("tab", name="Console").click()
    lines = panes.get_by_role("list", name="Console").get_by_role("listitem")
    panes.get_by_role("button", name="Deactivate all", exact=True).click()
    lines.get_by_text("asked").first.wait_for()
    panes.get_by_label("Go to time in seconds").fill("-1")
    panes.get_by_role("button", name="Go", exact=True).click()
    lines.get_by_text("is not between").wait_for()
    panes.get_by_role("searchbox", name="Filter of the console").fill("between")
    until(panes, lambda: lines.count() == 1)
    panes.get_by_role("button", name="Activate all", exact=True).click()
