"""The page shows the past by the slider, in a real browser, while the run goes on."""

from __future__ import annotations

import csv
import itertools
import re
from pathlib import Path
from typing import Any

import pytest
from ui_bench import select, until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]


def shown(page: Any) -> float:
    text = page.get_by_label("Time of the run").inner_text()
    return float(text.removesuffix(" s"))


def test_everything_follows_the_slider(page: Any, session: Session) -> None:
    select(page, "Odometry0")
    values = page.get_by_role("region", name="Odometry0.OdometryPosition")
    values.get_by_role("table").last.wait_for()
    state = page.locator(".panel .state")
    until(page, lambda: session.now > 1.5)
    page.get_by_role("button", name="Deactivate Odometry0").click()
    until(page, lambda: state.inner_text() == "INACTIVE")

    slider = page.get_by_role("slider", name="Look at time")
    slider.focus()
    page.keyboard.press("Home")
    page.get_by_role("status").get_by_text("looking back").wait_for()
    until(page, lambda: shown(page) == 0.0 and state.inner_text() == "ACTIVE")
    assert page.get_by_role(
        "button", name="Activate Odometry0", exact=True
    ).is_disabled()

    page.keyboard.press("End")
    until(page, lambda: state.inner_text() == "INACTIVE")

    def is_at_slider() -> bool:
        return slider.get_attribute("aria-valuetext") == f"{shown(page):.3f} s"

    for _ in range(2):
        last = shown(page)
        page.keyboard.press("PageDown")
        until(page, lambda last=last: shown(page) < last and is_at_slider())
    values.get_by_role("table").last.wait_for()
    here = shown(page)
    assert 0.0 < here < session.now
    page.get_by_role("tab", name="Timeline").click()
    listed = page.locator(".panel").locator("time")
    until(page, lambda: listed.count() > 0)
    times = listed.all_inner_texts()
    assert max(float(each.removesuffix(" s")) for each in times) <= here
    filtered(page)
    before = session.now
    until(page, lambda: session.now > before + 0.5)
    assert shown(page) == here

    page.get_by_role("button", name="Live").press("Enter")
    page.get_by_role("status").get_by_text(re.compile("^live")).wait_for()
    until(page, lambda: shown(page) > before)
    page.get_by_role("button", name="Pause").click()
    assert page.get_by_role("button", name="Live").is_disabled()
    page.get_by_role("button", name="Play").click()


def filtered(page: Any) -> None:
    """Filter the timeline by kind, component and words, which the address keeps."""
    lines = page.get_by_role("list", name="Timeline").get_by_role("listitem")
    page.get_by_label("Kind").select_option("states")
    group = page.get_by_role("group", name="Filter of the timeline")
    group.get_by_label("Component").select_option("Odometry0")
    words = group.get_by_role("searchbox", name="Words")
    words.fill("active")
    until(page, lambda: lines.count() > 0)
    for text in lines.all_inner_texts():
        assert text.split(maxsplit=2)[2] in ("Odometry0 ACTIVE", "Odometry0 INACTIVE")
    words.fill("no such words")
    page.get_by_text("The filter leaves none of").wait_for()
    page.get_by_role("tab", name="Console").click()
    page.get_by_role("tab", name="Timeline").click()
    assert words.input_value() == "no such words"
    assert "kind=state&of=Odometry0&words=no" in page.evaluate("location.hash")
    page.evaluate("location.hash = ''")
    until(page, lambda: words.input_value() == "" and lines.count() > 1)


def test_a_run_is_kept_beside_the_next_one(page: Any, session: Session) -> None:
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("tab", name="Map").click()
    figure = page.get_by_role("status", name="Odometry0.OdometryPosition on the map")
    figure.get_by_text(re.compile(r"x -?\d")).wait_for()
    place = figure.inner_text()
    page.get_by_role("button", name="Keep to compare").press("Enter")
    until(page, lambda: session.beside.keeps)
    page.get_by_role("status", name="Two runs").wait_for()
    assert figure.inner_text() == place
    page.get_by_role("button", name="Play").click()
    select(page, "Odometry0")
    page.get_by_role("tab", name="Values").click()
    goal = page.get_by_label("Go to time in seconds")
    goal.fill("0.5")
    goal.press("Enter")
    values = page.get_by_role("region", name="Odometry0.OdometryPosition")
    values.get_by_role("columnheader", name="beside", exact=True).wait_for()
    values.get_by_role("rowheader", name="data.heading").wait_for()
    page.get_by_text("beside: ACTIVE").wait_for()
    page.get_by_role("button", name="Beside: the run before").click()
    values.get_by_role("columnheader", name="beside", exact=True).wait_for(
        state="detached"
    )


def test_plots_say_what_is_left_out(
    page: Any, session: Session, tmp_path: Path
) -> None:
    select(page, "PathFollower0")
    page.get_by_role("tab", name="Values").click()
    page.get_by_label("Plots show").select_option("the last 5 s")
    values = page.get_by_role("region", name="PathFollower0.velocity")
    values.get_by_role("img", name="Values over time").wait_for()
    page.get_by_label("Speed").select_option("5")
    values.get_by_text("Older parts of the plot show only some").wait_for()
    until(page, lambda: session.now > 12)
    page.get_by_label("Speed").select_option("1")
    page.get_by_label("Plots show").select_option("the run")
    with page.expect_download() as found:
        values.get_by_role("button", name="as CSV").click()
    found.value.save_as(tmp_path / "velocity.csv")
    with (tmp_path / "velocity.csv").open(newline="", encoding="utf-8") as file:
        times = [float(row[0]) for row in [*csv.reader(file)][1:]]
    assert times[0] < 1 < 12 <= times[-1]
    assert max(b - a for a, b in itertools.pairwise(times)) < 1
