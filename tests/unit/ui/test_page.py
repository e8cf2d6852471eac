"""The page in a real browser: actions on it change the system behind it."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from patience import PATIENCE
from ui_bench import until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
ODOMETRY = "Odometry0"
WHEELS = "RefHardRh30.OutWheelAngle"


def state(session: Session, instance: str = ODOMETRY) -> str:
    return session.component(instance).current.name


def activate_all(page: Any, session: Session) -> None:
    page.get_by_role("button", name="Activate all", exact=True).click()
    until(page, lambda: state(session) == "STATE_ACTIVE")
    page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE").wait_for()


def test_states_by_mouse(page: Any, session: Session) -> None:
    box = page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE")
    box.locator(".head").click(button="right")
    page.get_by_role("menuitem", name="Deactivate").click()
    until(page, lambda: state(session) == "STATE_INACTIVE")
    page.get_by_label(f"{ODOMETRY}, Odometry, INACTIVE").wait_for()
    activate_all(page, session)


def test_states_by_keyboard(page: Any, session: Session) -> None:
    box = page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE")

    def has_menu() -> bool:
        # A box that is being placed does not keep the focus.
        box.focus()
        page.keyboard.press("Shift+F10")
        return bool(page.locator(".menu").is_visible())

    until(page, has_menu)
    page.locator(".menu button:focus").wait_for()
    page.keyboard.press("Escape")
    page.locator(".menu").wait_for(state="detached")
    page.keyboard.press("Shift+F10")
    page.locator(".menu button:focus").wait_for()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    until(page, lambda: state(session) == "STATE_INACTIVE")
    activate_all(page, session)


def test_a_box_is_moved_by_keyboard(page: Any, session: Session) -> None:
    x, y = session.places[ODOMETRY]
    page.get_by_role("button", name="Arranged").click()
    page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE").focus()
    page.keyboard.press("Enter")
    page.locator(".box.selected").wait_for()
    page.keyboard.press("Shift+ArrowRight")
    until(page, lambda: session.places[ODOMETRY][0] > x)
    assert session.places[ODOMETRY][1] == y
    page.get_by_role("button", name="Undo", disabled=False).press("Enter")
    until(page, lambda: session.places[ODOMETRY] == (x, y))
    page.get_by_role("button", name="Arranged").click()


MIDDLE = """each => {
    const path = each.querySelector("path");
    const at = path.getPointAtLength(path.getTotalLength() / 2);
    const { x, y } = at.matrixTransform(path.getScreenCTM());
    return [x, y];
}"""


def test_a_connection_is_cut_and_drawn(page: Any, session: Session) -> None:
    def connected() -> bool:
        return any(
            f"{each.source.instance}.{each.source.port}" == WHEELS
            for each in session.whole().connections
        )

    assert connected()
    edge = page.locator(f'.react-flow__edge[aria-label*="{WHEELS}"]')
    source = page.get_by_label(f"out port {WHEELS}")
    edge.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Delete")
    until(page, lambda: not connected())
    source.drag_to(page.get_by_label(f"in port {ODOMETRY}.CurrentWheelAngle"))
    until(page, connected)
    edge.wait_for()
    page.mouse.click(*edge.evaluate(MIDDLE), button="right")
    page.get_by_role("menuitem", name="Cut").click()
    until(page, lambda: not connected())
    page.get_by_role("button", name="Undo", disabled=False).click()
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
    page.get_by_role("button", name="Dismiss notice").click()


def test_an_answer_after_the_end_of_a_drag_marks_nothing(
    page: Any, session: Session
) -> None:
    answer = threading.Event()
    session.runner.submit(lambda: answer.wait(PATIENCE) and None)
    page.get_by_label(f"out port {WHEELS}").hover()
    page.mouse.down()
    page.mouse.move(400, 500)
    page.mouse.up()
    answer.set()
    page.get_by_role("button", name="Deactivate all", exact=True).click()
    page.get_by_label(f"{ODOMETRY}, Odometry, INACTIVE").wait_for()
    activate_all(page, session)
    assert page.locator(".port.refused, .port.fits, .port.other").count() == 0


def test_a_component_is_removed_and_comes_back(page: Any, session: Session) -> None:
    def connections() -> int:
        return len(session.whole().connections)

    before = connections()
    box = page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE")
    box.locator(".head").click(button="right")
    page.get_by_role("menuitem", name="Remove").click()
    until(page, lambda: ODOMETRY not in session.system.instances)
    assert connections() < before
    page.locator("body").press("Control+z")
    until(page, lambda: connections() == before)
    page.locator("body").press("Control+Shift+z")
    until(page, lambda: ODOMETRY not in session.system.instances)
    page.locator("body").press("Control+z")
    until(page, lambda: connections() == before)
    activate_all(page, session)


def test_views_are_changed_by_arrow_keys(page: Any) -> None:
    page.get_by_role("tab", name="Values").click()
    for key, name in (
        *(("ArrowRight", "Connections"), ("ArrowLeft", "Values")),
        *(("ArrowLeft", "Timeline"), ("ArrowRight", "Values")),
        *(("End", "Timeline"), ("Home", "Values")),
    ):
        page.keyboard.press(key)
        page.get_by_role("tab", name=name, selected=True).wait_for()
        page.get_by_role("tabpanel", name=name).wait_for()


def test_values_and_configuration(page: Any, session: Session) -> None:
    page.get_by_role("combobox", name="Component").select_option("PathFollower0")
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
    page.get_by_role("button", name="Play").wait_for()
    before = session.now
    page.get_by_role("button", name="Step").focus()
    page.keyboard.press("Enter")
    until(page, lambda: session.now > before)
    page.get_by_role("button", name="Play").click()
    until(page, lambda: session.time().playing)
