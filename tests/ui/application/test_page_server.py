"""Two pages of a server, one of them read-only, and a server that ends and starts again."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from ui_bench import GOAL, QUIET, opened, serving, until

from rtgen.ui.project_systems import CommandProject
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
ODOMETRY = "Odometry0"


@pytest.fixture(scope="module")
def looking(browser: Any, server: Server) -> Iterator[Any]:
    """Yield a page whose token is read-only."""
    with opened(browser, server.address(full=False)) as page:
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield page


def test_two_pages_are_in_step(page: Any, looking: Any, session: Session) -> None:
    box = page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE")
    box.locator(".head").click(button="right")
    page.get_by_role("menuitem", name="Deactivate").click()
    looking.get_by_label(f"{ODOMETRY}, Odometry, INACTIVE").wait_for()
    page.get_by_role("button", name="Components").click()
    page.get_by_role("button", name="Add Odometry", exact=True).press("Enter")
    looking.get_by_label("Odometry1, Odometry, INACTIVE").wait_for()
    page.get_by_role("button", name="Undo", disabled=False).click()
    looking.get_by_label("Odometry1, Odometry, INACTIVE").wait_for(state="detached")
    page.get_by_role("button", name="Activate all", exact=True).click()
    looking.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE").wait_for()


def test_one_that_is_loaded_again_finds_its_state(page: Any, session: Session) -> None:
    page.get_by_role("button", name="Pause").click()
    until(page, lambda: not session.runner.playing)
    now = f"{session.now:.3f} s"
    page.reload()
    page.get_by_label("Time of the run").get_by_text(now).wait_for()
    page.get_by_role("tab", name="Timeline").click()
    lines = page.locator(".panel").get_by_role("listitem")
    lines.get_by_text("ACTIVE").first.wait_for()
    page.get_by_role("button", name="Play").click()
    page.get_by_role("button", name="Pause").wait_for()


@pytest.mark.usefixtures("page")
def test_one_that_may_only_look_changes_nothing(looking: Any, session: Session) -> None:
    looking.get_by_text("live, read only").wait_for()
    looking.get_by_role("button", name="Components").click()
    buttons = (
        *("Activate all", "Deactivate all", "Reset all", "Undo", "Redo", "Save"),
        *("Pause", "Step", "Go", "Keep to compare", "Add Odometry"),
    )
    for name in buttons:
        button = looking.get_by_role("button", name=name, exact=True)
        assert button.is_disabled(), name
    before = len(session.whole().connections)
    box = looking.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE")
    box.locator(".head").click(button="right")
    assert not looking.get_by_role("menu").is_visible()
    edge = looking.locator(".react-flow__edge").first
    edge.focus()
    looking.keyboard.press("Enter")
    looking.keyboard.press("Delete")
    looking.get_by_role("tab", name="Configuration").click()
    assert looking.locator(".parameters input:enabled").count() == 0
    looking.get_by_role("tab", name="Drive").click()
    looking.get_by_text("This page may only look.").wait_for()
    assert len(session.whole().connections) == before


@pytest.fixture(scope="module")
def look() -> tuple[int, str]:
    """Return one look, since these tests do not depend on it."""
    return 1440, "light"


def test_a_server_that_ends_is_told_and_found_again(browser: Any) -> None:
    def made(port: int, known: Server | None = None) -> Server:
        session = Session(CommandProject(QUIET, [str(GOAL)]), str(GOAL))
        tokens = known.tokens if known else None
        return Server(session, "127.0.0.1", port, tokens=tokens)

    page = browser.new_page()
    link = page.locator(".link")
    with serving(made(0)) as first:
        page.goto(first.address(full=True))
        link.filter(has_text="live").wait_for()
    alert = page.get_by_role("alert")
    alert.filter(has_text="The server has ended").wait_for()
    link.filter(has_text="lost").wait_for()
    with serving(made(first.port, first)) as again:
        link.filter(has_text="live").wait_for()
        alert.filter(has_text="The server has ended").wait_for(state="hidden")
        page.get_by_role("button", name="Step").click()
        page.get_by_label("Time of the run").get_by_text("0.001 s").wait_for()
    with serving(made(again.port)):
        alert.filter(has_text="its token is not valid").wait_for()
    page.close()
