"""Wiring by the keyboard alone."""

from __future__ import annotations

from typing import Any

import pytest
from page_flaws import violations
from ui_bench import by_keyboard, choose, open_menu, until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
ENDS = ("RefHardRh30.OutWheelAngle", "Odometry0.CurrentWheelAngle")


def press(page: Any, target: Any, key: str = "Enter") -> None:
    target.press(key)


def are_connected(session: Session) -> bool:
    found = [(each.source, each.target) for each in session.whole().connections]
    return ENDS in [
        (f"{a.instance}.{a.port}", f"{b.instance}.{b.port}") for a, b in found
    ]


def test_ports_are_wired_by_keyboard(page: Any, session: Session) -> None:
    assert are_connected(session)
    press(page, page.get_by_label("Odometry0, Odometry, ACTIVE"), "Shift+F10")
    page.locator(".menu button:focus").wait_for()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    port = page.get_by_label("Chosen port")
    port.focus()
    page.keyboard.press("c")  # opens the list at CurrentWheelAngle
    page.keyboard.press("Enter")
    changes = page.get_by_role("log", name="Changes of the wiring")
    source, target = ENDS
    press(page, page.get_by_role("button", name=f"Cut {target} from {source}"))
    until(page, lambda: not are_connected(session))
    changes.get_by_text(f"{source} to {target}: cut").wait_for()
    press(page, page.get_by_text("ports do not fit"))
    refused = page.get_by_role("list", name=f"Ports that do not fit {target}")
    line = refused.get_by_role("listitem").filter(
        has_text="RefHardRh30.InTargetVelocity"
    )
    assert "InPort" in line.inner_text()
    compare = refused.get_by_role("button", name="Compare the types").first
    press(page, compare)
    card = page.get_by_role("dialog", name="have different types")
    card.get_by_role("columnheader", name=target).wait_for()
    assert violations(page) == []
    page.keyboard.press("Escape")
    card.wait_for(state="detached")
    refused.locator("button:focus").wait_for()
    press(page, page.get_by_role("button", name=f"Connect {target} with {source}"))
    until(page, lambda: are_connected(session))
    changes.get_by_text(f"{source} to {target}: connected").wait_for()


def test_a_line_is_cut_by_its_menu(page: Any, session: Session) -> None:
    source, target = ENDS
    line = page.get_by_label(f"from {source} to {target}")
    open_menu(line, by_keyboard)
    choose(page, "Cut", by_keyboard)
    until(page, lambda: not are_connected(session))
    line.wait_for(state="detached")
    page.keyboard.press("Control+z")
    until(page, lambda: are_connected(session))
    line.wait_for()
    page.keyboard.press("Control+Shift+z")
    until(page, lambda: not are_connected(session))
    page.keyboard.press("Control+z")
    until(page, lambda: are_connected(session))


def test_a_component_is_selected_and_removed(page: Any, session: Session) -> None:
    chosen = page.get_by_role("combobox", name="Component")
    page.get_by_label("PathFollower0, PathFollower, ACTIVE").locator(".head").click()
    until(page, lambda: chosen.input_value() == "PathFollower0")
    box = page.get_by_label("Odometry0, Odometry, ACTIVE")
    press(page, box)
    until(page, lambda: chosen.input_value() == "Odometry0")
    page.keyboard.press("Delete")
    until(page, lambda: "Odometry0" not in session.system.instances)
    box.wait_for(state="detached")
    undo = page.get_by_role("button", name="Undo", disabled=False)
    press(page, undo)
    until(page, lambda: are_connected(session))
    box.or_(page.get_by_label("Odometry0, Odometry, INACTIVE")).wait_for()
    press(page, page.get_by_role("button", name="Redo", disabled=False))
    until(page, lambda: "Odometry0" not in session.system.instances)
    press(page, undo)
    until(page, lambda: are_connected(session))
    press(page, page.get_by_role("button", name="Activate all", exact=True))
    page.get_by_label("Odometry0, Odometry, ACTIVE").wait_for()
