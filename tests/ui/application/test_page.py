"""The page in a real browser: actions on it change the system behind it."""

from __future__ import annotations

import re
import threading
from typing import Any

import pytest
from page_flaws import flaws
from patience import PATIENCE
from ui_bench import by_keyboard, drag, pick, select, until

from rtgen import runtime
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


@pytest.mark.nightly
def test_states_by_mouse(page: Any, session: Session) -> None:
    box = page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE")
    box.locator(".head").click(button="right")
    page.get_by_role("menuitem", name="Deactivate").click()
    until(page, lambda: state(session) == "STATE_INACTIVE")
    page.get_by_label(f"{ODOMETRY}, Odometry, INACTIVE").wait_for()
    activate_all(page, session)


@pytest.mark.nightly
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


@pytest.mark.nightly
def test_all_components_at_once(page: Any, session: Session) -> None:
    """Buttons for all components, by mouse and by keyboard; one component fails."""
    component: Any = session.system.component(ODOMETRY)

    def failing(ec_id: int) -> runtime.ReturnCode_t:
        return runtime.RTC_ERROR

    def states() -> set[str]:
        return {state(session, instance) for instance in session.system.instances}

    def press(name: str, *, mouse: bool) -> None:
        button = page.get_by_role("button", name=name, exact=True)
        if mouse:
            button.click()
        else:
            button.press("Enter")

    for mouse in (True, False):
        component.on_execute = failing
        until(page, lambda: state(session) == "STATE_ERROR")
        page.get_by_label(f"{ODOMETRY}, Odometry, ERROR").wait_for()
        del component.on_execute
        press("Reset all", mouse=mouse)
        until(page, lambda: states() == {"STATE_ACTIVE", "STATE_INACTIVE"})
        press("Deactivate all", mouse=mouse)
        until(page, lambda: states() == {"STATE_INACTIVE"})
        press("Activate all", mouse=mouse)
        until(page, lambda: states() == {"STATE_ACTIVE"})


def test_execution_contexts_are_shown(page: Any, session: Session) -> None:
    select(page, ODOMETRY)
    panel = page.get_by_role("complementary")
    panel.get_by_text(
        re.compile(r"100\sHz periodic, \d+\sticks, 0\soverruns")
    ).wait_for()


def test_a_component_is_added_by_mouse_and_keyboard(
    page: Any, session: Session
) -> None:
    add = page.get_by_role("button", name="Add Odometry", exact=True)
    if not add.is_visible():
        page.get_by_text("Components", exact=True).click()
    add.click()
    until(page, lambda: "Odometry1" in session.system.instances)
    page.get_by_label("Odometry1, Odometry, INACTIVE").wait_for()
    add.press("Enter")
    until(page, lambda: "Odometry2" in session.system.instances)
    undo = page.get_by_role("button", name="Undo", disabled=False)
    undo.click()
    until(page, lambda: "Odometry2" not in session.system.instances)
    undo.press("Enter")
    until(page, lambda: "Odometry1" not in session.system.instances)


def test_a_box_is_moved_by_mouse(page: Any, session: Session) -> None:
    x, y = session.places[ODOMETRY]
    page.get_by_role("button", name="Arranged").click()
    page.get_by_role("button", name="Fit View").click()
    head = page.get_by_label(f"{ODOMETRY}, Odometry, ACTIVE").locator(".head")
    drag(page, head, (40, 40), lambda: session.places[ODOMETRY] != (x, y))
    to_x, to_y = session.places[ODOMETRY]
    assert to_x > x
    assert to_y > y
    page.get_by_role("button", name="Undo", disabled=False).click()
    until(page, lambda: session.places[ODOMETRY] == (x, y))
    page.get_by_role("button", name="Arranged").click()


@pytest.mark.nightly
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
    card = page.get_by_role("dialog", name="have different types")
    card.wait_for()
    assert len(session.whole().connections) == before
    assert card.get_by_role("columnheader").all_inner_texts() == [
        WHEELS,
        "RefHardRh30.InTargetVelocity",
    ]
    rows = [each.split("\t") for each in card.get_by_role("row").all_inner_texts()[1:]]
    assert all(left.strip() != right.strip() for left, right in rows)
    assert "RTC::TimedDoubleSeq" in rows[0][0]
    assert "TimedVelocity2D" in rows[0][1]
    port, shown = target.bounding_box(), card.bounding_box()
    assert (
        min(abs(port["y"] - shown["y"]), abs(port["y"] - shown["y"] - shown["height"]))
        < 40
    )
    assert not page.get_by_role("alert").count()
    assert flaws(page, ".unfit") == []
    page.keyboard.press("Escape")
    card.wait_for(state="detached")


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
    until(page, lambda: connections() < before)
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
    select(page, "PathFollower0")
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


@pytest.mark.nightly
def test_time_by_keyboard(page: Any, session: Session) -> None:
    page.get_by_role("button", name="Pause").press("Enter")
    until(page, lambda: not session.time().playing)
    page.get_by_role("button", name="Play").wait_for()
    before = session.now
    page.get_by_role("button", name="Step").press("Enter")
    until(page, lambda: session.now > before)
    speed = page.get_by_label("Speed")
    pick(speed, "2\N{MULTIPLICATION SIGN}", by_keyboard)
    until(page, lambda: session.time().speed == 2.0)
    until(page, lambda: speed.input_value() == "2")
    pick(speed, "1\N{MULTIPLICATION SIGN}", by_keyboard)
    until(page, lambda: session.time().speed == 1.0)
    page.get_by_role("button", name="Play").press("Enter")
    until(page, lambda: session.time().playing)
    page.get_by_role("button", name="Pause").wait_for()


@pytest.mark.nightly
def test_time_by_mouse(page: Any, session: Session) -> None:
    page.get_by_role("button", name="Pause").click()
    until(page, lambda: not session.time().playing)
    before = session.now
    page.get_by_role("button", name="Step").click()
    until(page, lambda: session.now > before)
    goal = round(session.now + 0.5, 1)
    page.get_by_label("Go to time in seconds").fill(str(goal))
    page.get_by_role("button", name="Go", exact=True).click()
    time = page.get_by_label("Time of the run")
    # Without a time on the page its slider has no range.
    until(page, lambda: float(time.inner_text().removesuffix(" s")) >= goal)
    slider = page.get_by_role("slider", name="Look at time")
    slider.click()
    page.get_by_role("status").get_by_text("looking back").wait_for()
    assert 0.0 < float(time.inner_text().removesuffix(" s")) < session.now
    page.get_by_role("button", name="Live").click()
    page.get_by_role("status").get_by_text(re.compile("^live")).wait_for()
    page.get_by_role("button", name="Play").click()
    until(page, lambda: session.time().playing)
