"""Components of other processes on the page, by mouse and by keyboard."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from subprocess import Popen
from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from patience import PATIENCE
from ui_bench import QUIET, opened, started_over_corba, until

from rtgen.runtime import RealClock
from rtgen.runtime.corba.name_server import NameServer
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]

PANNING = 300
"""A view that pans during a drag has moved meanwhile [ms]."""


@pytest.fixture(scope="module")
def names() -> Iterator[str]:
    with NameServer() as server:
        yield server.address


@pytest.fixture(scope="module")
def process(names: str, look: object) -> Iterator[Popen[bytes]]:
    found = started_over_corba(names)
    yield found
    found.kill()
    found.wait(PATIENCE)


@pytest.fixture(scope="module")
def session(names: str, process: Popen[bytes]) -> Session:
    """Return a session without a system of the page's own."""
    return Session(CommandProject(QUIET, []), "", RealClock, [names])


@pytest.fixture(scope="module")
def page(browser: Any, server: Server, look: tuple[int, str]) -> Iterator[Any]:
    with opened(browser, server.address(full=True), look) as page:
        page.locator(".react-flow__node").nth(5).wait_for()
        page.locator(".wiring[aria-busy=false]").wait_for()
        yield page


def tree(page: Any) -> Any:
    return page.get_by_role("region", name="Naming services")


def select(page: Any, name: str, tab: str) -> None:
    """Select a component by its name, and a tab of its panel."""
    tree(page).locator(f'button[aria-label^="{name}, "]').press("Enter")
    page.get_by_role("tab", name=tab).press("Enter")


def test_they_are_steered_and_configured(
    page: Any, session: Session, names: str
) -> None:
    name = f"{names}/PathFollower0"

    def state() -> ui.State:
        return session.remote.components[name].current

    def limit() -> str:
        [active] = session.remote.components[name].configuration_sets
        return next(each.text for each in active.values if each.name == "max_v")

    select(page, name, "Configuration")
    page.get_by_label(f"{name}, PathFollower, ACTIVE").last.wait_for()
    page.get_by_role("button", name=f"Deactivate {name}", exact=True).click()
    until(page, lambda: state() is ui.State.STATE_INACTIVE)
    tree(page).get_by_role("button", name=f"{name}, PathFollower, INACTIVE").wait_for()
    page.get_by_role("button", name=f"Activate {name}", exact=True).press("Enter")
    until(page, lambda: state() is ui.State.STATE_ACTIVE)
    before = limit()
    field = page.get_by_label(f"{name}.max_v", exact=True)
    field.fill("0.25")
    field.press("Enter")
    until(page, lambda: limit() == "0.25")
    page.get_by_role("button", name="Undo", disabled=False).click()
    until(page, lambda: limit() == before)


def test_they_are_not_controlled_all_at_once(page: Any) -> None:
    for name in ("Activate all", "Deactivate all", "Reset all"):
        everyone = page.get_by_role("button", name=name, exact=True)
        assert everyone.is_disabled()
    everyone.hover()
    tip = page.get_by_role("tooltip").filter(has_text="one by one")
    tip.wait_for()
    page.keyboard.press("Escape")
    tip.wait_for(state="detached")


def test_lines_between_their_boxes_are_drawn(
    page: Any, session: Session, names: str
) -> None:
    source = f"{names}/PathFollower0.velocity"
    target = f"{names}/RefHardRh30.InTargetVelocity"

    def connected() -> bool:
        ends = [(e.source, e.target) for e in session.remote.connections.values()]
        return (source, target) in [
            (f"{a.instance}.{a.port}", f"{b.instance}.{b.port}") for a, b in ends
        ]

    select(page, f"{names}/PathFollower0", "Connections")
    page.get_by_label("Chosen port").select_option("velocity")
    page.get_by_role("button", name=f"Cut {source} from {target}").press("Enter")
    until(page, lambda: not connected())
    page.get_by_role("button", name=f"Connect {source} with {target}").click()
    until(page, connected)
    edge = page.locator(f'.react-flow__edge[aria-label*="from {source} to"]')
    edge.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Delete")
    until(page, lambda: not connected())
    edge.wait_for(state="detached")  # the page refuses what it knows as connected
    page.get_by_label(f"out port {source}").hover()
    page.mouse.down()
    page.get_by_label(f"in port {target}").hover(force=True)
    page.locator(".port.refused").first.wait_for()  # it knows the ends that fit
    page.mouse.up()
    until(page, connected)
    refused = page.get_by_label(f"in port {names}/Navigation0.min_path")
    view = page.locator(".react-flow__viewport")
    place = view.get_attribute("style")
    main = page.locator("main")
    main.evaluate("each => each.scrollTo(0, each.scrollHeight)")
    page.get_by_label(f"out port {source}").hover()
    page.mouse.down()
    main.evaluate("each => each.scrollTo(0, 0)")  # only a narrow page scrolls
    refused.hover(force=True)
    page.locator(".port.refused").first.wait_for()
    page.wait_for_timeout(PANNING)
    assert view.get_attribute("style") == place
    refused.hover(force=True)
    page.mouse.up()
    page.get_by_role("dialog", name="different types").wait_for()
    page.keyboard.press("Escape")


def test_their_values_are_shown_and_their_services_called(
    page: Any, names: str
) -> None:
    select(page, f"{names}/Odometry0", "Values")
    values = page.get_by_role("region", name=f"{names}/Odometry0.OdometryPosition")
    values.get_by_role("img", name="Values over time").wait_for()
    values.get_by_role("rowheader", name="data.heading").wait_for()
    page.get_by_role("tab", name="Map").click()
    pose = page.get_by_role("status", name=f"{names}/Odometry0.OdometryPosition")
    pose.get_by_text("°").wait_for()
    select(page, f"{names}/RefHardRh30", "Services")
    call = f"Call Stop of {names}/RefHardRh30.InventGUIRefHard"
    page.get_by_role("button", name=call).click()
    page.get_by_role("status", name="Result of Stop").get_by_text("done").wait_for()


def test_one_is_driven_and_all_are_saved(
    page: Any,
    session: Session,
    names: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    page.get_by_role("tab", name="Drive").click()
    ports = page.get_by_label("Driven port")
    port = f"{names}/RefHardRh30.InTargetVelocity"
    assert f"{names}/PathFollower0.velocity" not in ports.inner_text()
    ports.select_option(port)
    page.get_by_role("application", name=f"Joystick of {port}").focus()
    page.keyboard.down("ArrowUp")
    hard = session.remote.components[f"{names}/RefHardRh30"]
    page.get_by_role("status", name="Command").get_by_text("0.30 m/s").wait_for()
    page.keyboard.up("ArrowUp")
    page.get_by_role("status", name="Command").get_by_text("0.00 m/s").wait_for()
    assert not page.get_by_role("alert").is_visible()
    assert hard.type == "RefHardRh3"
    file = page.get_by_label("File of the system")
    file.fill("others.xml")
    file.press("Enter")
    until(page, (tmp_path / "others.xml").exists)
    restore = page.get_by_role("button", name="Restore from file")
    until(page, lambda: session.file == "others.xml")
    page.reload()
    restore.click()
    page.locator(".wiring[aria-busy=false] .react-flow__node").nth(5).wait_for()


def test_one_that_does_not_answer_says_so(
    page: Any, names: str, process: Popen[bytes]
) -> None:
    process.kill()
    name = f"{names}/PathFollower0, PathFollower, does not answer"
    tree(page).get_by_role("button", name=name).wait_for()
    page.get_by_text("does not answer").first.wait_for()
