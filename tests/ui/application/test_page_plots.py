"""Plots on the page: zoom, the cursor and its values, curves of several ports, files."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from page_flaws import violations
from ui_bench import WIDE, by_both_hands, select, until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
POSE = "Odometry0.OdometryPosition"
X, HEADING = "data.position.x", "data.heading"
VELOCITY = "PathFollower0.velocity"


@pytest.fixture(scope="module", params=[WIDE], ids=["wide"])
def look(request: pytest.FixtureRequest) -> tuple[int, str]:
    """Return the only look: what is shown does not depend on it."""
    found: tuple[int, str] = request.param
    return found


@pytest.fixture
def pose(page: Any, session: Session) -> Any:
    """Return the region of a pose whose run is paused after four seconds."""
    until(page, lambda: session.now > 4)
    if session.time().playing:
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play").wait_for()
    select(page, "Odometry0")
    page.get_by_role("tab", name="Values").click()
    region = page.get_by_role("region", name=POSE)
    plot = region.get_by_role("img", name="Values over time")
    plot.locator(".uplot").wait_for()
    plot.scroll_into_view_if_needed()
    return region


def row(region: Any, name: str) -> Any:
    """Return the row of a curve."""
    label = region.page.locator("label", has_text=re.compile(f"^{re.escape(name)}$"))
    return region.locator("tbody tr").filter(has=label)


def cells(region: Any, name: str = X) -> list[str]:
    """Return the cells of a curve: value, least, most, mean, deviation, unit."""
    found: list[str] = row(region, name).locator("td").all_inner_texts()
    return found


def zoomed(page: Any) -> tuple[float, float] | None:
    """Return the times that plots are zoomed to."""
    chosen = page.get_by_label("Plots show").first.evaluate(
        "each => each.selectedOptions[0].textContent"
    )
    found = re.fullmatch(r"(\S+) s to (\S+) s", chosen)
    return None if found is None else (float(found[1]), float(found[2]))


@pytest.mark.nightly
def test_a_drag_zooms_and_a_double_click_shows_all(page: Any, pose: Any) -> None:
    whole = cells(pose)
    [stamp] = pose.get_by_role("table", name=f"Texts of {POSE}").locator("tr").all()
    assert re.fullmatch(r"tm\s+\d+\.\d{9} s\s*", stamp.inner_text())
    box = pose.locator(".u-over").bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.5 * box["width"], y)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.75 * box["width"], y, steps=5)
    page.mouse.up()
    until(page, lambda: zoomed(page) is not None)
    first, last = zoomed(page) or (0.0, 0.0)
    assert 1 < first < last
    until(page, lambda: cells(pose)[3] != whole[3])
    # Every plot shows the same times, and a run that goes on changes none of it.
    page.get_by_role("button", name="Step").click()
    assert zoomed(page) == (first, last)
    pose.locator(".u-over").dblclick()
    until(page, lambda: zoomed(page) is None)


@pytest.mark.nightly
def test_keys_zoom_and_move_the_cursor(page: Any, pose: Any) -> None:
    pose.get_by_role("img", name="Values over time").focus()
    page.keyboard.press("+")
    until(page, lambda: zoomed(page) is not None)
    first, _ = zoomed(page) or (0.0, 0.0)
    page.keyboard.press("Shift+ArrowLeft")
    until(page, lambda: (zoomed(page) or (first,))[0] < first)
    page.keyboard.press("0")
    until(page, lambda: zoomed(page) is None)
    at = pose.get_by_role("status", name="Time at the cursor")
    page.keyboard.press("ArrowLeft")
    until(page, lambda: at.inner_text() != "")
    late = at.inner_text()
    page.keyboard.press("ArrowLeft")
    until(page, lambda: at.inner_text() != late)
    page.keyboard.press("Escape")
    until(page, lambda: at.inner_text() == "")


@pytest.mark.nightly
def test_the_table_has_the_values_at_the_cursor(page: Any, pose: Any) -> None:
    page.mouse.move(5, 5)  # where the test before has left it may be a plot
    cursor = pose.get_by_role("status", name="Time at the cursor")
    until(page, lambda: cursor.inner_text() == "")
    newest = float(cells(pose)[0])
    box = pose.locator(".u-over").bounding_box()
    page.mouse.move(box["x"] + 2, box["y"] + 50)
    until(page, lambda: float(cells(pose)[0]) != newest)
    value, least, most, mean, spread = map(float, cells(pose)[:5])
    assert value == pytest.approx(least, abs=0.02)
    assert least < mean < most
    assert 0 < spread < most - least
    # The cursor of one plot is that of all.
    wheels = page.get_by_role("region", name="RefHardRh30.OutWheelAngle")
    at = wheels.get_by_role("status", name="Time at the cursor")
    until(page, lambda: at.inner_text() != "")
    page.mouse.move(5, 5)
    until(page, lambda: float(cells(pose)[0]) == newest)


@pytest.mark.nightly
def test_curves_are_hidden_until_they_are_shown_again(page: Any, pose: Any) -> None:
    box = row(pose, HEADING).get_by_role("checkbox")
    box.uncheck()
    until(page, lambda: cells(pose, HEADING)[1] == "")
    page.get_by_role("tab", name="Map").click()
    page.get_by_role("tabpanel", name="Map").wait_for()
    page.get_by_role("tab", name="Values").click()
    assert not box.is_checked()
    box.check()
    until(page, lambda: cells(pose, HEADING)[1] != "")


@pytest.mark.nightly
def test_a_row_is_dragged_into_another_plot(page: Any, pose: Any) -> None:
    # What is dragged, and where to, are seen at once.
    page.set_viewport_size({"width": WIDE[0], "height": 1700})
    wheels = page.get_by_role("region", name="RefHardRh30.OutWheelAngle")
    target = wheels.get_by_role("img", name="Values over time").first
    row(pose, HEADING).locator("th").drag_to(target)
    added = row(wheels, f"{POSE} {HEADING}")
    added.wait_for()
    until(page, lambda: added.locator("td").all_inner_texts()[1] != "")
    remove = wheels.get_by_role("button", name=f"Remove {POSE}")
    remove.click()
    added.wait_for(state="detached")
    page.set_viewport_size({"width": WIDE[0], "height": 900})


@by_both_hands
def test_several_ports_share_a_plot(
    page: Any, pose: Any, press: Callable[[Any], None]
) -> None:
    tab = page.get_by_role("tab", name="Plots")
    press(tab)
    press(page.get_by_role("button", name="New plot"))
    region = page.get_by_role("region", name="Plot 1")
    for port in (POSE, VELOCITY):
        region.get_by_label("Add a port to Plot 1").select_option(port)
    for member in (X, HEADING):
        row(region, f"{POSE} {member}").wait_for()
    region.get_by_role("row", name=VELOCITY).first.wait_for()
    # Metres and radians, then metres and radians per second.
    region.get_by_role("img", name="Plot 1").nth(1).locator(".uplot").wait_for()
    assert violations(page) == []
    press(region.get_by_role("button", name="Remove Plot 1"))
    region.wait_for(state="detached")


@pytest.mark.nightly
def test_curves_are_saved(page: Any, pose: Any, tmp_path: Path) -> None:
    with page.expect_download() as found:
        pose.get_by_role("button", name="as CSV").click()
    found.value.save_as(tmp_path / "pose.csv")
    with (tmp_path / "pose.csv").open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head[0] == "time [s]"
    assert any(each.endswith("x [m]") for each in head)
    times = [float(row[0]) for row in rows]
    assert times == sorted(times)
    assert times[-1] > 4
    with page.expect_download() as found:
        pose.get_by_role("button", name="as PNG").press("Enter")
    found.value.save_as(tmp_path / "pose.png")
    octets = (tmp_path / "pose.png").read_bytes()
    assert octets.startswith(b"\x89PNG")
    width, height = (int.from_bytes(octets[i : i + 4], "big") for i in (16, 20))
    assert width > 300
    assert height > 200
