"""Robots driven by the page's joystick, seen on its map, and rewired while they drive."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, hypot
from pathlib import Path
from typing import Any

import pytest
from ui_bench import ROOT, WIDE, anew, until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
ROBOTS = ("OmniWheel0", "SegwayRmp0", "RefHard0", "BlackShip0")
wide_only = pytest.mark.parametrize("look", [WIDE], indirect=True)


@pytest.fixture(scope="module")
def shown() -> tuple[Path, None]:
    return ROOT / "specs/experiments/leader_exchange/system.xml", None


@pytest.fixture
def stick(page: Any, session: Session) -> Iterator[Any]:
    """Yield the page with its joystick; no other input, and robots never stop by themselves."""

    def leave_alone() -> None:
        for connector in [*session.system.connectors]:
            session.system.disconnect(connector.name)
        for robot in ROBOTS:
            sets = session.system.component(robot).configuration_sets
            sets.set("CommandTimeout", "0")

    session.runner.submit(leave_alone)
    until(page, lambda: not session.system.connectors)
    page.get_by_role("tab", name="Drive").click()
    yield page
    anew(page, session)


def take(page: Any, robot: str) -> Any:
    """Choose a robot; return its stick."""
    page.get_by_label("Driven port").select_option(f"{robot}.moving_command")
    return page.get_by_role("application", name=f"Joystick of {robot}.moving_command")


def speed(session: Session, robot: str) -> float:
    """Return the true speed of a robot's body [m/s]."""
    velocity: Any = session.system.component(robot).observables["velocity"]()
    return hypot(velocity[0], velocity[1]) if velocity else 0.0


def pull(page: Any, stick: Any) -> None:
    """Pull the stick forward by mouse."""
    stick.scroll_into_view_if_needed()
    box = stick.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 50)


@pytest.mark.parametrize("robot", ROBOTS)
def test_each_robot_is_driven_by_mouse_and_keyboard(
    stick: Any, session: Session, robot: str
) -> None:
    pad = take(stick, robot)
    pull(stick, pad)
    until(stick, lambda: speed(session, robot) > 0.15)
    stick.mouse.up()
    until(stick, lambda: speed(session, robot) < 0.01)
    pad.focus()
    stick.keyboard.down("ArrowUp")
    until(stick, lambda: speed(session, robot) > 0.15)
    stick.keyboard.up("ArrowUp")
    until(stick, lambda: speed(session, robot) < 0.01)


HIDE = """() => {
    Object.defineProperty(document, "hidden", { get: () => true, configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
}"""
SHOW = "() => delete document.hidden"
BLUR = "() => window.dispatchEvent(new Event('blur'))"
LEAVE = "() => document.activeElement.blur()"


@pytest.mark.parametrize("ending", [HIDE, BLUR, LEAVE], ids=["hidden", "blur", "focus"])
@wide_only
def test_a_robot_stops_when_the_page_is_left(
    stick: Any, session: Session, ending: str
) -> None:
    take(stick, "RefHard0").focus()
    stick.keyboard.down("KeyW")
    until(stick, lambda: speed(session, "RefHard0") > 0.15)
    stick.evaluate(ending)
    until(stick, lambda: speed(session, "RefHard0") < 0.01)
    stick.evaluate(SHOW)
    stick.keyboard.up("KeyW")


def test_a_robot_is_driven_by_touch(stick: Any, session: Session) -> None:
    pad = take(stick, "BlackShip0")
    pad.scroll_into_view_if_needed()
    box = pad.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = stick.context.new_cdp_session(stick)

    def send(kind: str, *points: tuple[float, float]) -> None:
        found = [{"x": x, "y": y} for x, y in points]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": found})

    send("touchStart", (x, y))
    send("touchMove", (x, y - 50))
    until(stick, lambda: speed(session, "BlackShip0") > 0.15)
    send("touchEnd")
    until(stick, lambda: speed(session, "BlackShip0") < 0.01)


def test_a_gamepad_drives_sideways(stick: Any, session: Session) -> None:
    take(stick, "OmniWheel0")
    pads = "navigator.getGamepads = () => [{ connected: true, axes: [0, 0, %s, 0] }]"
    stick.evaluate(pads % "-1")
    until(stick, lambda: speed(session, "OmniWheel0") > 0.15)
    velocity: Any = session.system.component("OmniWheel0").observables["velocity"]()
    assert velocity[1] > abs(velocity[0])
    stick.evaluate(pads % "0")
    until(stick, lambda: speed(session, "OmniWheel0") < 0.01)


COLOURED = """canvas => {
    const { width, height } = canvas;
    const copy = new OffscreenCanvas(width, height);
    const context = copy.getContext("2d", { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4)
        if (Math.max(data[i], data[i + 1], data[i + 2]) > data[i] + 60
            || data[i] > Math.max(data[i + 1], data[i + 2]) + 60) count += 1;
    return count;
}"""


def test_the_map_shows_where_robots_are(page: Any, session: Session) -> None:
    page.get_by_role("tab", name="Map").focus()
    page.keyboard.press("Enter")
    goal = page.get_by_label("Go to time in seconds")
    goal.fill("6")
    goal.press("Enter")
    until(page, lambda: session.now > 6.0 and speed(session, "OmniWheel0") > 0.05)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    for robot in ROBOTS:
        position: Any = session.system.component(robot).observables["odometry"]()
        x, y, theta = position
        text = f"x {x:.3f} m, y {y:.3f} m, {degrees(theta):.1f}°"
        line = page.get_by_role("status", name=f"{robot}.self_position on the map")
        line.get_by_text(text.replace("-0.000", "0.000")).wait_for()
    picture = page.get_by_role("img", name="Map, scale bar")
    # Movements before the map was opened have left trails.
    with_trails = picture.evaluate(COLOURED)
    page.get_by_role("button", name="Clear trails").click()
    until(page, lambda: picture.evaluate(COLOURED) < with_trails)
    before = picture.get_attribute("aria-label")
    picture.focus()
    for _ in range(6):
        page.keyboard.press("+")
    until(page, lambda: picture.get_attribute("aria-label") != before)
    page.get_by_role("button", name="Play").click()


def leader(session: Session, robot: str) -> list[int]:
    component: Any = session.system.component(robot)
    return list(component._leader)


def following(session: Session, follower: str) -> str:
    """Return the leader of a robot, by the wiring."""
    [found] = [
        each.source.instance
        for each in session.whole().connections
        if (each.target.instance, each.target.port) == (follower, "target_position")
    ] or [""]
    return found


def test_followers_exchange_their_leaders(page: Any, session: Session) -> None:
    """Experiment B1, by hand: connections are cut and drawn while all robots drive."""
    until(page, lambda: leader(session, "RefHard0") == [1])
    until(page, lambda: leader(session, "BlackShip0") == [2])
    for follower in ("RefHard0", "BlackShip0"):
        edge = page.locator(f'.react-flow__edge[aria-label*="to {follower}.target"]')
        edge.focus()
        page.keyboard.press("Enter")
        page.keyboard.press("Delete")
        until(page, lambda follower=follower: not following(session, follower))
    for leading, follower in (("SegwayRmp0", "RefHard0"), ("OmniWheel0", "BlackShip0")):
        target = page.get_by_label(f"in port {follower}.target_position")
        page.get_by_label(f"out port {leading}.self_position").drag_to(target)
        until(page, lambda f=follower, w=leading: following(session, f) == w)
    until(page, lambda: leader(session, "RefHard0") == [2])
    until(page, lambda: leader(session, "BlackShip0") == [1])
    for robot in ROBOTS:
        until(page, lambda robot=robot: speed(session, robot) > 0.05)
    anew(page, session)


@wide_only
def test_one_leads_four(stick: Any, session: Session) -> None:
    """Experiment B2, by hand: one stick drives all robots once it is wired to them."""
    for robot in ROBOTS:
        target = stick.get_by_label(f"in port {robot}.moving_command")
        stick.get_by_label("out port JoystickA0.moving_command").drag_to(target)
    until(stick, lambda: len(session.system.connectors) == len(ROBOTS))
    take(stick, "JoystickA0").focus()
    stick.keyboard.down("ArrowUp")
    until(stick, lambda: all(speed(session, robot) > 0.15 for robot in ROBOTS))
    stick.keyboard.up("ArrowUp")
    until(stick, lambda: all(speed(session, robot) < 0.01 for robot in ROBOTS))
