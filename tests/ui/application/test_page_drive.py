"""Robots driven by the page's joystick, seen on its map, and rewired while they drive."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import degrees, hypot
from pathlib import Path
from typing import Any

import pytest
from ui_bench import ROOT, WIDE, Finger, anew, by_keyboard, choose, pick, reach, until

from rtgen.runtime import System
from rtgen.ui.calls import Injector
from rtgen.ui.errors import IMPOSSIBLE, CommandError
from rtgen.ui.protocol import ui
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
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


def middle(pad: Any) -> tuple[float, float]:
    pad.scroll_into_view_if_needed()
    box = pad.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@contextmanager
def mouse(page: Any, pad: Any) -> Iterator[None]:
    x, y = middle(pad)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 50)
    yield
    page.mouse.up()


@contextmanager
def touch(page: Any, pad: Any) -> Iterator[None]:
    x, y = middle(pad)
    finger = Finger(page)
    finger.touch((x, y))
    finger.move((x, y - 50))
    yield
    finger.lift()


@contextmanager
def keyboard(page: Any, pad: Any) -> Iterator[None]:
    pad.focus()
    page.keyboard.down("ArrowUp")
    yield
    page.keyboard.up("ArrowUp")


@contextmanager
def gamepad(page: Any, pad: Any) -> Iterator[None]:
    del pad  # a gamepad drives while the view is open
    page.evaluate(PADS, [0, -1, 0, 0])
    yield
    page.evaluate(PADS, [0, 0, 0, 0])


PADS = "axes => { navigator.getGamepads = () => [{ connected: true, axes }]; }"
HANDS = (mouse, touch, keyboard, gamepad)


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("hand", HANDS, ids=lambda hand: hand.__name__)
def test_each_robot_is_driven_by_each_hand(
    stick: Any, session: Session, hand: Callable[..., Any], robot: str
) -> None:
    pad = take(stick, robot)
    with hand(stick, pad):
        until(stick, lambda: speed(session, robot) > 0.15)
    until(stick, lambda: speed(session, robot) < 0.01)
    assert all(speed(session, each) < 0.01 for each in ROBOTS)


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


@wide_only
def test_a_robot_stops_although_the_first_stop_is_refused(
    stick: Any, session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    put, refusals = Injector.put, []

    def refuse(self: Injector, system: System, command: ui.Inject) -> None:
        if not any(command.data[4:]) and len(refusals) < 3:
            refusals.append(command)
            raise CommandError(IMPOSSIBLE, "too many commands wait")
        put(self, system, command)

    monkeypatch.setattr(Injector, "put", refuse)
    take(stick, "RefHard0").focus()
    stick.keyboard.down("KeyW")
    until(stick, lambda: speed(session, "RefHard0") > 0.15)
    stick.keyboard.up("KeyW")
    until(stick, lambda: speed(session, "RefHard0") < 0.01)
    assert len(refusals) == 3
    assert {each.port.port for each in refusals} == {"moving_command"}


def test_a_gamepad_drives_sideways(stick: Any, session: Session) -> None:
    take(stick, "OmniWheel0")
    stick.evaluate(PADS, [0, 0, -1, 0])
    until(stick, lambda: speed(session, "OmniWheel0") > 0.15)
    velocity: Any = session.system.component("OmniWheel0").observables["velocity"]()
    assert velocity[1] > abs(velocity[0])
    stick.evaluate(PADS, [0, 0, 0, 0])
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
        text = f"x {x:z.3f} m, y {y:z.3f} m, {degrees(theta):z.1f}°"
        line = page.get_by_role("status", name=f"{robot}.self_position on the map")
        line.get_by_text(text).wait_for()
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


def press_key(page: Any, target: Any, key: str = "Enter") -> None:
    """Move the focus by Tab, and press a key."""
    reach(page, target)
    page.keyboard.press(key)


def following(session: Session, follower: str) -> str:
    """Return the leader of a robot, by the wiring."""
    [found] = [
        each.source.instance
        for each in session.whole().connections
        if (each.target.instance, each.target.port) == (follower, "target_position")
    ] or [""]
    return found


def change_leader_by_mouse(page: Any, session: Session, follower: str) -> None:
    """Cut a follower from its leader in the wiring, and connect it to the other one."""
    edge = page.locator(f'.react-flow__edge[aria-label*="to {follower}.target"]')
    edge.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Delete")
    until(page, lambda: not following(session, follower))
    edge.wait_for(state="detached")
    page.locator(".wiring[aria-busy=false]").wait_for()
    target = page.get_by_label(f"in port {follower}.target_position")
    page.get_by_label(f"out port {LEADERS[follower]}.self_position").drag_to(target)


def change_leader_by_keyboard(page: Any, session: Session, follower: str) -> None:
    """Do the same in the view of connections."""
    here = f"{follower}.target_position"
    open_connections(page, follower, "target_position (in)")
    cut = page.get_by_role("button", name=f"Cut {here} from ")
    press_key(page, cut)
    until(page, lambda: not following(session, follower))
    cut.wait_for(state="detached")
    there = f"{LEADERS[follower]}.self_position"
    press_key(page, page.get_by_role("button", name=f"Connect {here} with {there}"))


def open_connections(page: Any, instance: str, port: str) -> None:
    """Show what a port is connected with, and what fits it, by the keyboard alone."""
    press_key(
        page, page.locator(f'.react-flow__node[data-id="{instance}"]'), "Shift+F10"
    )
    choose(page, "Connections", by_keyboard)
    chooser = page.get_by_label("Chosen port")
    chooser.wait_for()
    for _ in range(40):
        page.keyboard.press("Tab")
        if chooser.and_(page.locator(":focus")).count():
            break
    chooser.and_(page.locator(":focus")).wait_for()
    pick(chooser, port, by_keyboard)


LEADERS = {"RefHard0": "SegwayRmp0", "BlackShip0": "OmniWheel0"}
"""The leaders after the exchange, by their followers."""


@pytest.mark.parametrize(
    "change_leader", [change_leader_by_mouse, change_leader_by_keyboard]
)
def test_followers_exchange_their_leaders(
    page: Any, session: Session, change_leader: Callable[..., None]
) -> None:
    """Experiment B1, by hand: connections are cut and drawn while all robots drive."""
    until(page, lambda: leader(session, "RefHard0") == [1])
    until(page, lambda: leader(session, "BlackShip0") == [2])
    for follower, leading in LEADERS.items():
        change_leader(page, session, follower)
        until(page, lambda f=follower, w=leading: following(session, f) == w)
    until(page, lambda: leader(session, "RefHard0") == [2])
    until(page, lambda: leader(session, "BlackShip0") == [1])
    for robot in ROBOTS:
        until(page, lambda robot=robot: speed(session, robot) > 0.05)
    anew(page, session)


def connect_by_mouse(page: Any) -> None:
    """Draw connections from a joystick to all robots, and take its stick."""
    for robot in ROBOTS:
        target = page.get_by_label(f"in port {robot}.moving_command")
        page.get_by_label("out port JoystickA0.moving_command").drag_to(target)
        edge = page.locator(
            f'.react-flow__edge[aria-label*="to {robot}.moving_command"]'
        )
        edge.wait_for(state="attached")
        page.locator(".wiring[aria-busy=false]").wait_for()
    take(page, "JoystickA0").focus()


def connect_by_keyboard(page: Any) -> None:
    """Do the same in the view of connections."""
    open_connections(page, "JoystickA0", "moving_command (out)")
    for robot in ROBOTS:
        end = f"JoystickA0.moving_command with {robot}.moving_command"
        button = page.get_by_role("button", name=f"Connect {end}")
        press_key(page, button)
        button.wait_for(state="detached")
    reach(page, page.get_by_role("tab", name="Connections"), "Shift+Tab")
    drive = page.get_by_role("tab", name="Drive", selected=True)
    for _ in range(12):
        page.keyboard.press("ArrowRight")
        if drive.count():
            break
    drive.wait_for()
    chooser = page.get_by_label("Driven port")
    reach(page, chooser)
    pick(chooser, "JoystickA0.moving_command", by_keyboard)
    reach(page, page.get_by_role("application", name="Joystick of JoystickA0"))


@pytest.mark.parametrize("connect", [connect_by_mouse, connect_by_keyboard])
@wide_only
def test_one_leads_four(
    stick: Any, session: Session, connect: Callable[[Any], None]
) -> None:
    """Experiment B2, by hand: one stick drives all robots once it is wired to them."""
    connect(stick)
    until(stick, lambda: len(session.system.connectors) == len(ROBOTS))
    stick.keyboard.down("ArrowUp")
    until(stick, lambda: all(speed(session, robot) > 0.15 for robot in ROBOTS))
    stick.keyboard.up("ArrowUp")
    until(stick, lambda: all(speed(session, robot) < 0.01 for robot in ROBOTS))
