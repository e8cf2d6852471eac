"""The inspector in a browser: properties of a connection are edited, ports are described."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from page_flaws import violations
from ui_bench import WIDE, by_both_hands, by_mouse, until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
LENGTH = "dataport.inport.buffer.length"
WHEELS = "RefHardRh30.OutWheelAngle"


@pytest.fixture(scope="module")
def look() -> tuple[int, str]:
    """Return one look, since these tests do not depend on it."""
    return WIDE


def properties(session: Session) -> dict[str, str] | None:
    """Return those of the connection; None while it is made again with others."""
    for each in session.whole().connections:
        if f"{each.source.instance}.{each.source.port}" == WHEELS:
            return {value.name: value.text for value in each.properties}
    return None


MIDDLE = """each => {
    const path = each.querySelector("path");
    const at = path.getPointAtLength(path.getTotalLength() / 2);
    const { x, y } = at.matrixTransform(path.getScreenCTM());
    return [x, y];
}"""


@by_both_hands
def test_properties_of_a_connection_are_shown_as_a_change_and_set(
    page: Any, session: Session, press: Callable[[Any], None]
) -> None:
    before = properties(session)
    assert before is not None
    edge = page.locator(f'.react-flow__edge[aria-label*="{WHEELS}"]')
    wire = page.get_by_role("region", name="Connection", exact=True)
    if press is by_mouse:
        page.mouse.click(*edge.evaluate(MIDDLE))
    else:
        edge.focus()
        page.keyboard.press("Enter")
    wire.get_by_role("combobox", name="subscription type").wait_for()
    press(wire.get_by_text("Buffer of the InPort"))
    length = wire.get_by_label("inport length")
    length.fill("0")
    press(wire.get_by_role("button", name="Show what changes"))
    reason = wire.get_by_role("alert").filter(has_text="an integer, at least 1")
    reason.wait_for()
    assert length.get_attribute("aria-describedby") == reason.get_attribute("id")
    assert properties(session) == before
    length.fill("3")
    press(wire.get_by_role("button", name="Show what changes"))
    window = page.get_by_role("dialog", name="Properties of the connection")
    window.locator(".added").get_by_text('value="3"').wait_for()
    assert violations(page) == []
    assert properties(session) == before
    press(window.get_by_role("button", name="Apply"))
    until(page, lambda: properties(session) == before | {LENGTH: "3"})
    window.wait_for(state="detached")
    until(page, lambda: length.input_value() == "3")
    press(page.get_by_role("button", name="Undo", disabled=False))
    until(page, lambda: properties(session) == before)
    press(wire.get_by_role("button", name="Close the connection"))
    wire.wait_for(state="detached")


def test_a_port_is_described_by_its_name(page: Any) -> None:
    box = page.get_by_label("Odometry0, Odometry, ")
    box.get_by_text("OdometryPosition", exact=True).click()
    port = page.get_by_role("region", name="Port", exact=True)
    port.get_by_role("row", name="kind OutPort").wait_for()
    port.get_by_role("row", name="type IIS::TimedPose2D").wait_for()
    port.get_by_role("row", name="data.heading rad").wait_for()
    assert violations(page) == []
    port.get_by_role("button", name="OmniTo2WD0.current_position").click()
    wire = page.get_by_role("region", name="Connection", exact=True)
    wire.get_by_role("button", name="current_position").click()
    port.get_by_role("row", name="kind InPort").wait_for()
    port.get_by_role("button", name="Which ports fit").click()
    page.get_by_role("tab", name="Connections", selected=True).wait_for()
    ends = page.get_by_role("list", name="Connections of OmniTo2WD0.current_position")
    ends.get_by_text("Odometry0.OdometryPosition").wait_for()
    page.get_by_role("tab", name="Values").click()
