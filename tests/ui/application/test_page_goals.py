"""Goals and bodies on the page's map, measuring and following, by mouse and by keyboard."""

from __future__ import annotations

import re
from typing import Any

import pytest
from page_flaws import violations
from ui_bench import WIDE, by_keyboard, pick, until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
LABEL = "Map, scale bar"
GOAL = "Navigation0.path"
BODY = "Odometry0.OdometryPosition"
DRAWN = """picture => {
    const { width, height } = picture;
    const copy = new OffscreenCanvas(width, height);
    const pen = copy.getContext("2d", { willReadFrequently: true });
    pen.drawImage(picture, 0, 0);
    const { data } = pen.getImageData(0, 0, width, height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4)
        if (Math.max(...data.slice(i, i + 3)) - Math.min(...data.slice(i, i + 3)) > 40) count += 1;
    return count;
}"""
"""The number of coloured pixels."""
DRAWN_AGAIN = """() => new Promise(
    done => requestAnimationFrame(() => requestAnimationFrame(done))
)"""
"""Waits until the page shows what has happened."""


@pytest.fixture(scope="module", params=[WIDE], ids=["wide"])
def look(request: pytest.FixtureRequest) -> tuple[int, str]:
    found: tuple[int, str] = request.param
    return found


@pytest.fixture
def area(page: Any, session: Session) -> Any:
    """Return the map of a run that is paused after the robot has left its first place."""
    until(page, lambda: session.now > 7)
    if session.time().playing:
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play").wait_for()
    page.get_by_role("tab", name="Map").click()
    words = page.get_by_role("status", name=f"{BODY} on the map")
    words.get_by_text("x ").wait_for()
    page.get_by_role("button", name="Fit", exact=True).click()
    return page.get_by_role("img", name=LABEL)


def test_goals_have_no_trail(page: Any, area: Any) -> None:
    goal = page.get_by_role("status", name=f"{GOAL} on the map")
    goal.get_by_text(re.compile("^goal at x ")).wait_for()
    body = page.get_by_role("status", name=f"{BODY} on the map")
    body.get_by_text(re.compile("^x ")).wait_for()
    with_trails = area.evaluate(DRAWN)
    page.get_by_role("button", name="Clear trails").click()
    until(page, lambda: area.evaluate(DRAWN) < with_trails)


def test_a_distance_is_measured_by_mouse(page: Any, area: Any) -> None:
    page.get_by_role("button", name="Measure").click()
    box = area.bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 200, box["y"] + 100, steps=3)
    page.mouse.up()
    measured = page.get_by_role("status", name="Measured")
    measured.get_by_text(re.compile(r"^[0-9.]+ m, 0\.0°$")).wait_for()
    page.get_by_role("button", name="Measure").click()
    until(page, lambda: measured.inner_text() == "")


def test_a_distance_is_measured_by_keyboard(page: Any, area: Any) -> None:
    page.get_by_role("button", name="Measure").press("Enter")
    area.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    measured = page.get_by_role("status", name="Measured")
    measured.get_by_text(re.compile(r"^[0-9.]+ m, 90\.0°$")).wait_for()
    assert violations(page) == []
    page.keyboard.press("Escape")
    until(page, lambda: measured.inner_text() == "")


def test_the_map_follows_a_body(page: Any, area: Any) -> None:
    """What is followed is in the middle, until the map is moved."""
    follow = page.locator(".map").get_by_role("combobox")
    pick(follow, BODY, by_keyboard)
    box = area.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def middle() -> str:
        # Also a mouse that does not move sees a map that does.
        page.mouse.move(x + 1, y)
        page.mouse.move(x, y)
        found: str = page.locator(".map .at span").inner_text()
        return found

    def where() -> str:
        words = page.get_by_role("status", name=f"{BODY} on the map").inner_text()
        return str(re.sub(r", [-0-9.]+°$", "", words))

    def distance() -> float:
        one, other = (
            [float(each) for each in re.findall(r"-?\d+\.\d+", text)]
            for text in (middle(), where())
        )
        return max(abs(a - b) for a, b in zip(one, other, strict=True))

    until(page, lambda: distance() < 0.05)
    area.focus()
    page.keyboard.press("ArrowLeft")
    until(page, lambda: follow.input_value() == "")
    until(page, lambda: distance() > 0.05)


COUNTED_WHEELS = "() => { wheels = 0; addEventListener('wheel', () => wheels++); }"


def numbers(words: Any) -> list[float]:
    """Return the coordinates that the page says."""
    return [*map(float, re.findall(r"-?\d+\.\d+", words.inner_text()))]


def test_the_wheel_zooms_around_the_mouse(page: Any, area: Any) -> None:
    box = area.bounding_box()
    x, y = round(box["x"]) + 60, round(box["y"]) + 60
    at = page.locator(".map .at span")
    page.mouse.move(x, y)
    page.evaluate(DRAWN_AGAIN)
    before, scale = at.inner_text(), area.get_attribute("aria-label")
    numbers_before = numbers(at)
    assert len(numbers_before) == 2
    page.evaluate(COUNTED_WHEELS)
    for _ in range(4):
        page.mouse.wheel(0, -400)
    # The mouse shall not move on before the last of them.
    until(page, lambda: page.evaluate("wheels") == 4)
    until(page, lambda: area.get_attribute("aria-label") != scale)
    page.mouse.move(x + 1, y)
    until(page, lambda: at.inner_text() != before)
    page.mouse.move(x, y)
    # To the last of three decimals, which a number halfway between two may have either way.
    until(page, lambda: numbers(at) == pytest.approx(numbers_before, abs=0.0011))
