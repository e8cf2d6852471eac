"""Wiring by the keyboard alone."""

from __future__ import annotations

from typing import Any

import pytest
from ui_bench import until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
ENDS = ("RefHardRh30.OutWheelAngle", "Odometry0.CurrentWheelAngle")


def press(page: Any, target: Any, key: str = "Enter") -> None:
    target.focus()
    page.keyboard.press(key)


def test_ports_are_wired_by_keyboard(page: Any, session: Session) -> None:
    def connected() -> bool:
        found = [(each.source, each.target) for each in session.whole().connections]
        return ENDS in [
            (f"{a.instance}.{a.port}", f"{b.instance}.{b.port}") for a, b in found
        ]

    assert connected()
    press(page, page.get_by_label("Odometry0, Odometry, ACTIVE"), "Shift+F10")
    page.locator(".menu button:focus").wait_for()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    port = page.get_by_label("Chosen port")
    port.focus()
    page.keyboard.type("CurrentWheelAngle")
    changes = page.get_by_role("log", name="Changes of the wiring")
    source, target = ENDS
    press(page, page.get_by_role("button", name=f"Cut {target} from {source}"))
    until(page, lambda: not connected())
    changes.get_by_text(f"{source} to {target}: cut").wait_for()
    press(page, page.get_by_text("ports do not fit"))
    refused = page.get_by_role("list", name=f"Ports that do not fit {target}")
    line = refused.get_by_role("listitem").filter(
        has_text="RefHardRh30.InTargetVelocity"
    )
    assert "InPort" in line.inner_text()
    press(page, page.get_by_role("button", name=f"Connect {target} with {source}"))
    until(page, connected)
    changes.get_by_text(f"{source} to {target}: connected").wait_for()
