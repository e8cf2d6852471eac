"""Two pages of a server, one of them read-only, and a server that ends and starts again."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ui_bench import GOAL, QUIET, opened, serving, until

from rtgen.ui.arrangements import Arrangements
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
ODOMETRY = "Odometry0"


MOVED = 40.0
"""The distance by which a box is moved in the arrangement that the first page has stored [px]."""


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of arrangements of the server."""
    return tmp_path_factory.mktemp("arrangements")


@pytest.fixture(scope="module")
def server(session: Session, stored: Path) -> Iterator[Server]:
    arrangements = Arrangements(stored)
    with serving(Server(session, "127.0.0.1", 0, arrangements=arrangements)) as server:
        yield server


@pytest.fixture(scope="module")
def looking(browser: Any, server: Server, page: Any, stored: Path) -> Iterator[Any]:
    """Yield a page whose token is read-only, opened when the arrangement is stored."""
    until(page, lambda: bool([*stored.glob("*.json")]))
    [file] = stored.glob("*.json")
    arrangement = json.loads(file.read_bytes())
    for box in arrangement["boxes"]:
        box[2] += MOVED * (box[0] == ODOMETRY)
    file.write_text(json.dumps(arrangement))
    with opened(browser, server.address(full=False)) as other:
        other.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield other


PLACES = """() => Object.fromEntries([...document.querySelectorAll(".react-flow__node-component")]
    .map(each => [each.dataset.id, new DOMMatrix(getComputedStyle(each).transform)])
    .map(([name, { e, f }]) => [name, [e, f]]))"""


def test_the_next_page_has_the_arrangement_of_the_first(
    page: Any, looking: Any, stored: Path
) -> None:
    """It shows what is stored, and not what it would arrange: one box has been moved there."""
    first, second = page.evaluate(PLACES), looking.evaluate(PLACES)
    assert len(first) == len(second) > 1
    x, y = first[ODOMETRY]
    assert second == {**first, ODOMETRY: [x, y + MOVED]}
    # Without exactly the boxes of the system, it is not used: this page stores its own again.
    [file] = stored.iterdir()
    arrangement = json.loads(file.read_bytes())
    fewer = {**arrangement, "boxes": arrangement["boxes"][1:]}
    file.write_text(json.dumps(fewer))
    page.reload()
    until(page, lambda: json.loads(file.read_bytes()) != fewer)
    page.locator(".wiring[aria-busy=false] .react-flow__edge").first.wait_for()
    assert page.evaluate(PLACES) == first


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
