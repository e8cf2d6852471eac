"""The page on a phone and on a tablet: a view fills the screen, everything is reached by touch."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from page_flaws import too_small, violations
from patience import PATIENCE
from ui_bench import Finger, until

from rtgen.ui.serving import Server
from rtgen.ui.session import Session

PHONE, TABLET = (390, 844), (820, 1180)
pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
LEGIBLE = 9
"""The least size of the letters of a name [px]."""


@pytest.fixture(
    scope="module",
    params=[PHONE, pytest.param(TABLET, marks=pytest.mark.nightly)],
    ids=["phone", "tablet"],
)
def look(request: pytest.FixtureRequest) -> tuple[int, int]:
    """Return the size of a screen; each has a server of its own."""
    found: tuple[int, int] = request.param
    return found


@pytest.fixture(scope="module")
def page(browser: Any, server: Server, look: tuple[int, int]) -> Iterator[Any]:
    """Yield a page on a screen that is touched."""
    width, height = look
    context = browser.new_context(
        viewport={"width": width, "height": height}, has_touch=True, locale="en"
    )
    page = context.new_page()
    page.set_default_timeout(PATIENCE * 1000)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text))
    page.goto(server.address(full=True))
    page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
    yield page
    context.close()
    assert complaints == [], complaints


def show(page: Any, name: str) -> None:
    bar = page.get_by_role("navigation", name="Views")
    bar.get_by_role("button", name=name, exact=True).tap()


@contextmanager
def more(page: Any) -> Iterator[Any]:
    """Open what a phone has no room for in its head."""
    show(page, "More")
    window = page.get_by_role("dialog", name="More")
    window.wait_for()
    yield window
    page.keyboard.press("Escape")
    window.wait_for(state="detached")


BOXES = """() => {
    const of = each => {
        const { left, top, right, bottom } = each.getBoundingClientRect();
        return [left, top, right, bottom];
    };
    const outer = of(document.querySelector(".wiring"));
    const names = [...document.querySelectorAll(".head strong")].map(each => {
        const scale = each.getBoundingClientRect().width / each.offsetWidth;
        return parseFloat(getComputedStyle(each).fontSize) * scale;
    });
    return [outer, [...document.querySelectorAll(".box")].map(of), names];
}"""


def test_the_whole_wiring_is_seen_at_first(page: Any, session: Session) -> None:
    def fits() -> bool:
        (left, top, right, bottom), boxes, names = page.evaluate(BOXES)
        return (
            len(boxes) == len(session.system.instances)
            and all(left <= box[0] and box[2] <= right for box in boxes)
            and all(top <= box[1] and box[3] <= bottom for box in boxes)
            and min(names) >= LEGIBLE
        )

    until(page, fits)


WIDTH = "document.documentElement.scrollWidth - innerWidth"


def check(page: Any, what: str) -> None:
    assert too_small(page) == [], what
    assert page.evaluate(WIDTH) <= 0, what
    assert violations(page) == [], what


def test_each_view_fills_the_screen(page: Any, look: tuple[int, int]) -> None:
    for name in ("Values", "Map", "Drive", "Time", "Wiring"):
        show(page, name)
        button = page.get_by_role("navigation", name="Views").locator("[aria-current]")
        until(page, lambda name=name, b=button: b.all_inner_texts() == [name])
        screens = page.locator(".screen:visible")
        until(page, lambda s=screens: s.count() == 1)
        assert screens.bounding_box()["width"] == look[0]
        check(page, name)
    with more(page) as window:
        check(page, "More")
        window.get_by_role("button", name="Console").tap()
        page.get_by_role("searchbox", name="Filter of the console").wait_for()
    check(page, "Console")
    show(page, "Wiring")


def test_a_box_is_touched_for_its_values(page: Any) -> None:
    show(page, "Wiring")
    page.get_by_label("Odometry0, Odometry, ").locator(".head").tap()
    page.get_by_role("button", name="Details").tap()
    panel = page.get_by_role("complementary")
    panel.get_by_text("100 Hz periodic").wait_for()
    for view in ("Connections", "Configuration", "Services", "Values"):
        page.get_by_role("tab", name=view).tap()
        page.get_by_role("tab", name=view, selected=True).wait_for()
        check(page, view)


def test_ports_are_joined_by_touch(page: Any, session: Session) -> None:
    def joined() -> bool:
        return any(
            (each.source.port, each.target.instance) == ("OutWheelAngle", "Odometry0")
            for each in session.whole().connections
        )

    assert joined()
    show(page, "Wiring")
    page.get_by_label("Odometry0, Odometry, ").locator(".head").tap()
    page.get_by_role("button", name="Details").tap()
    page.get_by_role("tab", name="Connections").tap()
    page.get_by_label("Chosen port").select_option("CurrentWheelAngle")
    page.get_by_role("button", name="Cut Odometry0.CurrentWheelAngle from").tap()
    until(page, lambda: not joined())
    connect = "Connect Odometry0.CurrentWheelAngle with RefHardRh30.OutWheelAngle"
    page.get_by_role("button", name=connect, exact=True).tap()
    until(page, joined)
    show(page, "Wiring")


def test_the_stick_is_reached_and_pulled(page: Any, session: Session) -> None:
    show(page, "Drive")
    page.get_by_label("Driven port").select_option("RefHardRh30.InTargetVelocity")
    stick = page.get_by_role("application", name="Joystick of RefHardRh30")
    stick.wait_for()
    box = stick.bounding_box()
    bar = page.get_by_role("navigation", name="Views").bounding_box()
    footer = page.locator("footer").bounding_box()
    assert box["y"] + box["height"] <= min(bar["y"], footer["y"])
    assert box["y"] >= page.locator("header").bounding_box()["height"]
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    finger = Finger(page)
    finger.touch((x, y))
    finger.move((x, y - 50))
    command = page.get_by_role("status", name="Command")
    until(page, lambda: not command.inner_text().startswith("0.00 m/s"))
    finger.lift()
    until(page, lambda: command.inner_text().startswith("0.00 m/s"))
    show(page, "Wiring")


def test_time_is_set_and_files_are_reached(page: Any, session: Session) -> None:
    show(page, "Time")
    page.get_by_label("Go to time in seconds").fill("1.5")
    page.get_by_role("button", name="Go", exact=True).tap()
    until(page, lambda: session.now == 1.5)
    show(page, "Wiring")
    page.get_by_role("button", name="Step").tap()
    until(page, lambda: session.now > 1.5)
    if page.get_by_role("textbox", name="File of the system").is_visible():
        return
    with more(page) as window:
        window.get_by_role("textbox", name="File of the system").wait_for()
        window.get_by_role("button", name="Activate all", exact=True).wait_for()
