"""The page in a real browser: what is done on it is seen in the system behind it."""

from __future__ import annotations

import asyncio
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from patience import PATIENCE
from ui_bench import GOAL, QUIET

from rtgen.cli.ui import CommandProject
from rtgen.runtime import SimulatedClock
from rtgen.ui.server import PAGE
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
ODOMETRY = "Odometry0"
WHEELS = "RefHardRh30.OutWheelAngle"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright")
    program = os.environ.get("RTGEN_CHROMIUM") or shutil.which("chromium")
    if program is None:
        pytest.skip("no chromium: install it, or name one in RTGEN_CHROMIUM")
    if not (PAGE / "index.html").exists():
        pytest.skip("the page is not built: `make ui`")
    with playwright.sync_playwright() as driver:
        found = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture
def session() -> Session:
    return Session(CommandProject(QUIET, [str(GOAL)]), str(GOAL), SimulatedClock)


@pytest.fixture
def server(session: Session) -> Iterator[Server]:
    server = Server(session, "127.0.0.1", 0)
    ready = threading.Event()
    thread = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    thread.start()
    assert ready.wait(PATIENCE)
    yield server
    server.stop()
    thread.join(PATIENCE)
    assert not thread.is_alive()


@pytest.fixture(params=[(1440, "light"), (820, "dark")], ids=["wide", "narrow"])
def page(request: pytest.FixtureRequest, browser: Any, server: Server) -> Iterator[Any]:
    width, scheme = request.param
    size = {"width": width, "height": 900}
    page = browser.new_page(viewport=size, color_scheme=scheme)
    page.set_default_timeout(PATIENCE * 1000)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text))
    page.goto(server.address(full=True))
    page.get_by_role("button", name="Play").click()
    page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE").wait_for()
    yield page
    page.close()
    assert complaints == []


def until(page: Any, condition: Callable[[], bool]) -> None:
    """Waits for a condition behind the page, whose events are handled meanwhile."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        page.wait_for_timeout(20)


def state(session: Session, instance: str = ODOMETRY) -> str:
    return session.component(instance).current.name


def test_states_by_mouse(page: Any, session: Session) -> None:
    box = page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE")
    box.locator(".head").click(button="right")
    page.get_by_role("menuitem", name="Deactivate").click()
    until(page, lambda: state(session) == "STATE_INACTIVE")
    page.get_by_label(f"{ODOMETRY}, Odometry, INACTIVE").wait_for()
    page.get_by_role("button", name="Activate all", exact=True).click()
    until(page, lambda: state(session) == "STATE_ACTIVE")


def test_states_by_keyboard(page: Any, session: Session) -> None:
    page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE").focus()
    page.keyboard.press("Shift+F10")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    until(page, lambda: state(session) == "STATE_INACTIVE")


def test_a_connection_is_cut_and_drawn(page: Any, session: Session) -> None:
    def connected() -> bool:
        return any(
            f"{each.source.instance}.{each.source.port}" == WHEELS
            for each in session.whole().connections
        )

    assert connected()
    edge = page.locator(f'.react-flow__edge[aria-label*="{WHEELS}"]')
    edge.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Delete")
    until(page, lambda: not connected())
    source = page.get_by_label(f"out port {WHEELS}")
    source.drag_to(page.get_by_label(f"in port {ODOMETRY}.CurrentWheelAngle"))
    until(page, connected)


def test_ports_that_do_not_fit_are_refused_with_the_reason(
    page: Any, session: Session
) -> None:
    before = len(session.whole().connections)
    target = page.get_by_label("in port RefHardRh30.InTargetVelocity")
    page.get_by_label(f"out port {WHEELS}").hover()
    page.mouse.down()
    target.hover(force=True)
    page.locator(".port.refused").first.wait_for()
    target.hover(force=True)
    page.mouse.up()
    page.get_by_role("alert").wait_for()
    assert len(session.whole().connections) == before


def test_values_and_configuration(page: Any, session: Session) -> None:
    page.get_by_label("Component", exact=True).locator("select").select_option(
        "PathFollower0"
    )
    page.get_by_role("img", name="Values over time").first.wait_for()
    page.get_by_role("tab", name="Configuration").focus()
    page.keyboard.press("Enter")
    field = page.get_by_label("PathFollower0.max_v")
    field.fill("0.25")
    field.press("Enter")

    def text() -> str:
        component = session.component("PathFollower0")
        [active] = [
            each
            for each in component.configuration_sets
            if each.name == component.active_set
        ]
        return next(each.text for each in active.values if each.name == "max_v")

    until(page, lambda: text() == "0.25")


def test_time(page: Any, session: Session) -> None:
    page.get_by_role("button", name="Pause").click()
    until(page, lambda: not session.time().playing)
    before = session.now
    page.get_by_role("button", name="Step").focus()
    page.keyboard.press("Enter")
    until(page, lambda: session.now > before)
    page.get_by_role("button", name="Play").click()
    until(page, lambda: session.time().playing)
