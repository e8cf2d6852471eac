"""Components that fail and that are late, in real time, by mouse and by keyboard."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from ui_bench import (
    GOAL,
    QUIET,
    by_both_hands,
    choose,
    open_menu,
    opened,
    select,
    until,
)

from rtgen import runtime
from rtgen.compiler.model import System
from rtgen.runtime.rtc.profiles import ComponentProfile
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
STRONGEST = """each => {
    const stripe = getComputedStyle(each, "::before");
    const parts = stripe.backgroundColor.match(/[0-9]+/g).map(Number);
    return ["red", "green", "blue"][parts.indexOf(Math.max(...parts))];
}"""
COLOUR = """each => {
    const parts = getComputedStyle(each).color.match(/[0-9]+/g).map(Number);
    return ["red", "green", "blue"][parts.indexOf(Math.max(...parts))];
}"""
"""The strongest part of the colour of a text."""
HUES = {"ACTIVE": "green", "INACTIVE": "blue", "ERROR": "red"}
"""The colours of states in RT System Editor."""


class Fragile(runtime.Component):
    """Fails or is late when it is asked to."""

    profile = ComponentProfile("Fragile", rate=50.0)
    fails = False
    late = False

    def on_execute(self, ec_id: int) -> runtime.ReturnCode_t:
        if self.late:
            time.sleep(2.5 / self.profile.rate)
        if self.fails:
            raise ValueError("too hot: 7.0")
        return runtime.RTC_OK


class Project(CommandProject):
    """A system of two components."""

    def assemble(
        self, profile: System, clock: runtime.Clock, failed: Callable[..., None]
    ) -> runtime.System:
        system = runtime.System(clock)
        for name in ("Fragile0", "Fragile1"):
            system.add(Fragile(name))
            system.activate(name)
        return system


@pytest.fixture(scope="module")
def session(look: object) -> Session:
    return Session(Project(QUIET, [str(GOAL)]), str(GOAL), runtime.RealClock)


@pytest.fixture(scope="module")
def page(
    browser: Any, server: Server, session: Session, look: tuple[int, str]
) -> Iterator[Any]:
    session.runner.submit(session.runner.play)
    with opened(browser, server.address(full=True), look) as page:
        page.get_by_label("Fragile0, Fragile, ACTIVE").wait_for()
        yield page


def state_is(page: Any, session: Session, state: str) -> Any:
    """Wait for the state of the first component, behind the page and on it; return its box."""
    until(page, lambda: session.component("Fragile0").current.name == f"STATE_{state}")
    box = page.get_by_label(f"Fragile0, Fragile, {state}")
    box.wait_for()
    assert box.locator(".head").evaluate(STRONGEST) == HUES[state]
    return box


@by_both_hands
def test_one_that_fails_is_reset(
    page: Any, session: Session, press: Callable[[Any], None]
) -> None:
    component: Any = session.system.component("Fragile0")
    select(page, "Fragile0")
    page.get_by_role("tab", name="Timeline").click()
    component.fails = True
    box = state_is(page, session, "ERROR")
    lines = page.locator(".panel").get_by_role("listitem")
    # The place of the raise is told once, in red.
    place = r"tests/ui/application/test_page_failures\.py:\d+"
    reason = re.compile(rf"on_execute \({place}\): ValueError: too hot: 7\.0$")
    said = lines.filter(has_text="too hot")
    said.filter(
        has_text=re.compile(rf"Fragile0 ERROR: {reason.pattern}")
    ).first.wait_for()
    assert all(" ERROR: " in each for each in said.all_inner_texts())
    assert said.first.evaluate(COLOUR) == "red"
    page.get_by_role("tab", name="Values").click()
    told = page.locator(".panel .reason").filter(has_text=reason)
    told.wait_for()
    assert told.evaluate(COLOUR) == "red"
    component.fails = False
    open_menu(box, press)
    choose(page, "Reset", press)
    box = state_is(page, session, "INACTIVE")
    page.locator(".panel .reason").wait_for(state="detached")
    open_menu(box, press)
    choose(page, "Activate", press)
    box = state_is(page, session, "ACTIVE")
    open_menu(box, press)
    choose(page, "Deactivate", press)
    state_is(page, session, "INACTIVE")
    press(page.get_by_role("button", name="Activate Fragile0", exact=True))
    state_is(page, session, "ACTIVE")
    assert session.component("Fragile1").current.name == "STATE_ACTIVE"


def test_overruns_are_counted(page: Any, session: Session) -> None:
    component: Any = session.system.component("Fragile0")
    select(page, "Fragile0")

    def overruns() -> int:
        return session.system.statistics("Fragile0").overruns

    before = overruns()
    component.late = True
    until(page, lambda: overruns() > before + 3)
    component.late = False
    box = page.get_by_label("Fragile0, Fragile, ACTIVE")
    panel = page.get_by_role("complementary", name="Component")
    box.get_by_text("50 Hz").wait_for()
    until(
        page,
        lambda: (
            f"50 Hz {overruns()} overruns" in box.inner_text()
            and f", {overruns()}\xa0overruns, 0\xa0lost" in panel.inner_text()
        ),
    )
    page.get_by_role("tab", name="Timeline").click()
    lines = page.locator(".panel").get_by_role("listitem")
    lines.filter(has_text=re.compile(r"Fragile0 .*\d more")).first.wait_for()
