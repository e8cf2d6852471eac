"""Ports of other units are pale, and joined only by a person who says why."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from ui_bench import QUIET, by_both_hands, select, until

from rtgen.cli import run
from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]

KITCHEN = """#include "BasicDataType.idl"
@rtc(category="Kitchen", vendor="me")
component Oven {
    @unit("degC") publishes RTC::TimedDouble temperature;
    @unit("W") consumes RTC::TimedDouble power;
};
@rtc(category="Kitchen", vendor="me")
component Thermostat {
    @unit("degC") consumes RTC::TimedDouble temperature;
    @unit("W") publishes RTC::TimedDouble power;
};
"""
SYSTEM = """<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<rts:RtsProfile rts:id="RTSystem:me:kitchen:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:me:Kitchen:Oven:1.0.0" rts:instanceName="Oven0"/>
  <rts:Components rts:id="RTC:me:Kitchen:Thermostat:1.0.0" rts:instanceName="Thermostat0"/>
</rts:RtsProfile>
"""
SETTINGS = '[sources]\npaths = ["kitchen.idl"]\n[output]\npackage = "judged_kitchen"\n'
OVEN, WRONG = "Oven0.temperature", "Oven0.power"
ALLOWED = "rtgen.allow.RTC0593"


@pytest.fixture(scope="module")
def session(
    look: tuple[int, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Session]:
    folder = tmp_path_factory.mktemp("kitchen")
    for name, text in (
        ("rtgen.toml", SETTINGS),
        ("kitchen.idl", KITCHEN),
        ("kitchen.xml", SYSTEM),
    ):
        Path(folder, name).write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["generate", "-q"]) == 0
        yield Session(
            CommandProject(QUIET, ["kitchen.xml"]), "kitchen.xml", SimulatedClock
        )


@by_both_hands
def test_a_port_of_another_unit_is_joined_with_a_reason(
    page: Any, session: Session, press: Callable[[Any], None]
) -> None:
    def properties() -> list[dict[str, str]]:
        return [
            {each.name: each.text for each in link.properties}
            for link in session.whole().connections
        ]

    select(page, "Oven0")
    page.get_by_role("tab", name="Connections").click()
    page.get_by_label("Chosen port").select_option("")
    page.get_by_label("Chosen port").select_option("temperature")
    fitting = page.get_by_role("list", name=f"Ports that fit {OVEN}")
    fitting.get_by_text("Thermostat0.temperature").wait_for()
    assert WRONG not in fitting.inner_text()
    press(page.get_by_text("ports do not fit"))
    refused = page.get_by_role("list", name=f"Ports that do not fit {OVEN}")
    lines = refused.get_by_role("listitem")
    line = lines.filter(has_text=WRONG)
    assert "RTC0593" in line.inner_text()
    assert "takes W" in line.inner_text()
    other = lines.filter(has_text="Thermostat0.power")
    assert "RTC0582" in other.inner_text()
    assert not other.get_by_role("button").count()
    question = page.get_by_role("alertdialog")
    purpose = line.get_by_role("button", name="on purpose")
    press(purpose)
    press(question.get_by_role("button", name="Cancel"))
    question.wait_for(state="detached")
    assert properties() == []
    press(purpose)
    reason = question.get_by_label("Reason")
    reason.fill(" ")
    press(question.get_by_role("button", name="Connect"))
    assert properties() == []
    reason.fill("a test of the page")
    press(question.get_by_role("button", name="Connect"))
    until(page, lambda: properties() == [{ALLOWED: "a test of the page"}])
    question.wait_for(state="detached")
    press(page.get_by_role("button", name=f"Cut {OVEN} from {WRONG}"))
    until(page, lambda: properties() == [])


def test_a_line_to_a_port_of_another_unit_asks_for_the_reason(
    page: Any, session: Session
) -> None:
    source = page.get_by_label(f"out port {OVEN}")
    target = page.get_by_label(f"in port {WRONG}")
    source.hover()
    page.mouse.down()
    at = target.bounding_box()
    page.mouse.move(at["x"] + at["width"] / 2, at["y"] + at["height"] / 2, steps=5)
    page.locator(".port.refused").filter(has=target).wait_for()
    page.mouse.up()
    question = page.get_by_role("alertdialog")
    question.get_by_text("RTC0593").wait_for()
    question.get_by_role("button", name="Cancel").click()
    question.wait_for(state="detached")
    assert not session.whole().connections
