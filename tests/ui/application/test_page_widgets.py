"""Parameters are edited by the widgets that their definitions name, by mouse and by keyboard."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
from page_flaws import flaws, violations
from patience import PATIENCE
from ui_bench import GOAL, QUIET, by_keyboard, by_mouse, pick, select, until

from rtgen import runtime
from rtgen.compiler.model import System
from rtgen.runtime.rtc.profiles import ComponentProfile, ParameterProfile
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]


@dataclass
class Settings:
    """Parameters, one for each widget."""

    gain: float = 0.5
    count: int = 3
    pace: float = 1.5
    mode: str = "near"
    layers: list[str] = field(default_factory=lambda: ["walls"])
    order: list[str] = field(default_factory=lambda: ["a", "b"])
    on: bool = False
    side: str = "left"
    note: str = ""


def parameter(name: str, type_: str, default: str, widget: str, constraint: str) -> Any:
    return ParameterProfile(
        *(name, name, type_, default), constraint=constraint, widget=widget
    )


class Shown(runtime.Component):
    """Has parameters, but no behaviour."""

    profile = ComponentProfile(
        "Shown",
        rate=10.0,
        configuration=(
            parameter("gain", "double", "0.5", "slider.0.1", "0<=x<=1"),
            parameter("count", "long", "3", "spin", "1<=x<=9"),
            parameter("pace", "double", "1.5", "spin.0.5", "0<=x<=9"),
            parameter("mode", "string", "near", "radio", "(near,far)"),
            parameter(
                "layers", "sequence<string>", "walls", "checkbox", "(walls,ways)"
            ),
            parameter("order", "sequence<string>", "a,b", "ordered_list", "(a,b,c)"),
            parameter("on", "boolean", "false", "", ""),
            parameter("side", "string", "left", "", "(left,right,both)"),
            parameter("note", "string", "", "text", ""),
        ),
    )

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.config = self.add_configuration(Settings())


class Project(CommandProject):
    """A system of one component."""

    def assemble(
        self, profile: System, clock: runtime.Clock, failed: Callable[..., None]
    ) -> runtime.System:
        system = runtime.System(clock)
        system.add(Shown("Shown0"))
        return system


@pytest.fixture(scope="module")
def session(look: object) -> Session:
    return Session(Project(QUIET, [str(GOAL)]), str(GOAL), runtime.SimulatedClock)


@pytest.fixture
def settings(page: Any, session: Session) -> Callable[[], Any]:
    """Show the component's parameters; return a function that reads them."""
    select(page, "Shown0")
    page.get_by_role("tab", name="Configuration").click()
    component: Any = session.system.component("Shown0")
    return lambda: component.config


def test_by_mouse(page: Any, settings: Callable[[], Any]) -> None:
    page.get_by_role("radio", name="far").click()
    until(page, lambda: settings().mode == "far")
    page.get_by_role("checkbox", name="ways").click()
    until(page, lambda: settings().layers == ["walls", "ways"])
    page.get_by_role("checkbox", name="walls").click()
    until(page, lambda: settings().layers == ["ways"])
    page.get_by_role("checkbox", name="Shown0.on").click()
    until(page, lambda: settings().on)
    page.get_by_role("button", name="Move b up").click()
    until(page, lambda: settings().order == ["b", "a"])
    page.get_by_role("button", name="Remove b, number 1").click()
    until(page, lambda: settings().order == ["a"])
    pick(page.get_by_label("Add to Shown0.order"), "c", by_mouse)
    until(page, lambda: settings().order == ["a", "c"])
    pick(page.get_by_label("Shown0.side"), "right", by_mouse)
    until(page, lambda: settings().side == "right")


def test_by_keyboard(page: Any, session: Session, settings: Callable[[], Any]) -> None:
    slider = page.get_by_role("slider", name="Shown0.gain")
    assert slider.get_attribute("step") == "0.1"
    slider.press("ArrowRight")
    until(page, lambda: settings().gain == 0.6)
    slider.press("End")
    until(page, lambda: settings().gain == 1.0)
    pace = page.get_by_role("spinbutton", name="Shown0.pace")
    pace.press("ArrowUp")
    pace.press("Enter")
    until(page, lambda: settings().pace == 2.0)
    spin = page.get_by_role("spinbutton", name="Shown0.count")
    spin.press("ArrowUp")
    spin.press("Enter")
    until(page, lambda: settings().count == 4)
    spin.fill("40")
    spin.press("Enter")
    alert = page.get_by_role("alert")
    alert.wait_for()
    assert "its constraint is 1<=x<=9" in alert.inner_text()
    assert spin.get_attribute("aria-invalid") == "true"
    assert spin.get_attribute("aria-describedby") == alert.get_attribute("id")
    assert alert.bounding_box()["y"] >= spin.bounding_box()["y"]
    assert violations(page) == []
    assert flaws(page, ".parameters") == []
    page.get_by_role("textbox", name="Shown0.note").focus()
    assert (spin.input_value(), settings().count) == ("40", 4)
    spin.press("Escape")
    alert.wait_for(state="detached")
    assert spin.input_value() == "4"
    spin.fill("0")
    spin.press("Enter")
    alert.wait_for()
    spin.fill("4")
    spin.press("Enter")
    alert.wait_for(state="detached")
    assert spin.get_attribute("aria-invalid") is None
    assert "0<=x" not in page.get_by_role("row", name="gain").inner_text()
    ends = page.get_by_role("row", name="gain").locator("small").all_inner_texts()
    assert ends == ["0", "1"]
    page.get_by_role("radio", name="near").press("Space")
    until(page, lambda: settings().mode == "near")
    pick(page.get_by_label("Add to Shown0.order"), "b", by_keyboard)
    until(page, lambda: settings().order == ["a", "c", "b"])
    pick(page.get_by_label("Shown0.side"), "both", by_keyboard)
    until(page, lambda: settings().side == "both")
    note = page.get_by_role("textbox", name="Shown0.note")
    note.fill("here")
    note.press("Escape")
    assert note.input_value() == ""
    stored = threading.Event()
    session.runner.submit(lambda: stored.wait(PATIENCE) and None)
    note.fill("first")
    note.press("Enter")
    note.fill("second")
    stored.set()
    until(page, lambda: settings().note == "first")
    note.press("Enter")
    until(page, lambda: settings().note == "second")
    note.fill("")
    note.press("Enter")
    until(page, lambda: settings().note == "")


def test_sets_are_made_and_switched(
    page: Any, session: Session, settings: Callable[[], Any]
) -> None:
    sets = session.system.component("Shown0").configuration_sets
    name = page.get_by_label("Name of a new set")
    name.fill("slow")
    name.press("Enter")
    until(page, lambda: "slow" in sets.ids)
    note = page.get_by_role("textbox", name="Shown0.note")
    chooser = page.get_by_role("combobox", name="Set", exact=True)
    until(page, lambda: chooser.input_value() == "slow")
    note.fill("slowly")
    note.press("Enter")
    until(page, lambda: sets.texts("slow")["note"] == "slowly")
    assert settings().note == ""
    use = page.get_by_role("button", name="Use this set")
    use.click()
    until(page, lambda: settings().note == "slowly")
    chooser.select_option("default")
    until(page, use.is_enabled)  # the page knows the new active set
    use.press("Enter")
    until(page, lambda: settings().note == "")
