"""Recordings on the page, one and two beside each other, by mouse and by keyboard."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from ui_bench import GOAL, QUIET, by_both_hands, by_mouse, opened, select, until

from rtgen.cli import run
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.recorded import Recorded
from rtgen.ui.serving import Server

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
PORT = "PathFollower0.velocity"


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return the recordings of two runs of two seconds; in the second the robot turns slower."""
    folder = tmp_path_factory.mktemp("recordings")
    command = ["run", str(GOAL), "--until", "2", "-q", "--record"]
    fast, slow = str(folder / "fast.mcap"), str(folder / "slow.mcap")
    assert run([*command, fast]) == 0
    assert run([*command, slow, "--set", "PathFollower0.max_w=0.1"]) == 0
    return [fast, slow]


@pytest.fixture(scope="module")
def session(recordings: list[str], look: object) -> Recorded:
    project = CommandProject(QUIET, [])
    return Recorded(recordings, project.describer, project.codec)


@pytest.fixture(scope="module")
def page(browser: Any, server: Server, look: tuple[int, str]) -> Iterator[Any]:
    with opened(browser, server.address(full=True), look) as page:
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield page


def shown(page: Any) -> float:
    text = page.get_by_label("Time of the run").inner_text()
    return float(text.removesuffix(" s"))


def slide(page: Any, part: float, press: Callable[[Any], None]) -> None:
    """Move the slider to its beginning (0) or its end (1), or with the mouse to a part."""
    slider = page.get_by_role("slider", name="Look at time")
    if press is by_mouse:
        box = slider.bounding_box()
        at = {"x": box["width"] * min(max(part, 0.01), 0.99), "y": box["height"] / 2}
        slider.click(position=at)
    else:
        slider.press("End" if part > 0.5 else "Home")
        if 0 < part < 1:
            for _ in range(3):
                slider.press("PageUp" if part <= 0.5 else "PageDown")


@by_both_hands
def test_one_is_played_and_scrubbed(
    page: Any, session: Recorded, press: Callable[[Any], None]
) -> None:
    last = session.history.last
    page.get_by_role("status").get_by_text("recording").wait_for()
    slide(page, 1, press)
    until(page, lambda: shown(page) > 0.9 * last)
    slide(page, 0.4, press)
    until(page, lambda: 0.1 * last < shown(page) < 0.9 * last)
    page.get_by_label("Odometry0, Odometry, ACTIVE").first.wait_for()
    slide(page, 0, press)
    until(page, lambda: shown(page) < 0.1 * last)
    begin = shown(page)
    press(page.get_by_role("button", name="Play"))
    until(page, lambda: shown(page) > begin + 0.3)
    pause = page.get_by_role("button", name="Pause")
    press(pause)
    page.get_by_role("button", name="Play").wait_for()
    assert shown(page) < last
    add = page.get_by_role("button", name="Activate all", exact=True)
    assert add.is_disabled()


def test_it_begins_at_its_beginning_and_has_speeds(
    browser: Any, server: Server, session: Recorded, look: tuple[int, str]
) -> None:
    last = session.history.last
    with opened(browser, server.address(full=True), look) as page:
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        assert shown(page) == session.history.first
        speed = page.get_by_label("Speed")
        assert speed.input_value() == "1"
        speed.select_option("10")
        play = page.get_by_role("button", name="Play")
        assert play.is_enabled()
        play.click()
        until(page, lambda: shown(page) == last)
        speed.select_option("0.1")
        play.click()
        until(page, lambda: 0.0 < shown(page) < 0.3 * last)
        page.get_by_role("button", name="Pause").click()
        assert shown(page) < 0.5 * last
        page.get_by_role("slider", name="Look at time").press("Home")
        page.keyboard.press(" ")
        page.get_by_role("button", name="Pause").wait_for()
        until(page, lambda: shown(page) > 0.0)
        page.keyboard.press(" ")
        play.wait_for()
        for key, step in ((".", 0.1), (".", 0.1), (",", -0.1)):
            before = shown(page)
            page.keyboard.press(key)
            until(
                page,
                lambda at=before + step: shown(page) == pytest.approx(at, abs=2e-3),
            )


CELLS = """rows => rows.map(
    row => [...row.querySelectorAll("td")].map(each => each.textContent)
)"""


@by_both_hands
def test_two_are_beside_each_other(
    page: Any, session: Recorded, press: Callable[[Any], None]
) -> None:
    select(page, "PathFollower0")
    press(page.get_by_role("tab", name="Values"))
    slide(page, 1, press)
    page.get_by_text("beside: ACTIVE").wait_for()
    values = page.get_by_role("region", name=PORT)
    values.get_by_role("columnheader", name="beside", exact=True).wait_for()
    beside = page.get_by_role("columnheader", name="beside", exact=True)
    rows = values.get_by_role("table").filter(has=beside).locator("tbody tr")

    def columns() -> list[tuple[str, ...]]:
        cells = rows.evaluate_all(CELLS)
        return [tuple(cell[at] for cell in cells) for at in (0, 1)]

    until(page, lambda: all(map(all, columns())) and columns()[0] != columns()[1])
