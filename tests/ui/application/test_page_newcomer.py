"""What somebody who knows nothing of a system finds by following what the page shows.

Each walk uses texts that are seen at that moment, and counts its steps: presses, and entries.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from heating_project import write
from page_flaws import flaws, violations
from ui_bench import QUIET, by_keyboard, by_mouse, opened, serving, until

from rtgen.cli import run
from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
SYSTEM = "systems/warm/system.xml"
WIRE = "Heater0.temperature to Controller0.temperature"
STEPS_TO_LOSS, STEPS_TO_DIFFERENCE = 3, 9
"""The most steps that a walk takes: about three seconds each, beside reading."""


class Walk:
    """Presses what is seen, by mouse or by keyboard, and counts."""

    def __init__(self, page: Any, press: Callable[[Any], None]) -> None:
        self.page = page
        self.steps = 0
        self._press = press

    def press(self, target: Any) -> None:
        """Press a button that is seen."""
        target.wait_for()
        assert target.evaluate(SEEN), target
        self._press(target)
        self.steps += 1

    def enter(self, field: Any, text: str) -> None:
        """Enter a text into a field that is seen."""
        field.wait_for()
        assert field.evaluate(SEEN), field
        field.fill(text)
        field.press("Enter")
        self.steps += 1


SEEN = """each => {
    const { left, right, top, bottom } = each.getBoundingClientRect();
    return left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
}"""


@pytest.fixture(params=[by_mouse, by_keyboard])
def press(request: pytest.FixtureRequest) -> Callable[[Any], None]:
    found: Callable[[Any], None] = request.param
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Yield a project whose controller runs once a second, with a buffer of two samples."""
    folder = tmp_path_factory.mktemp("unknown")
    write(folder)
    file = folder / SYSTEM
    text = file.read_text(encoding="utf-8")
    slow = '<rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="1.0"/>'
    short = '<rtsExt:Properties rtsExt:name="dataport.inport.buffer.length" rtsExt:value="2"/>'
    head, tail = text.split('<rts:ServicePorts rts:name="Controller0.setup"/>')
    sets, rest = tail.split("</rts:ConfigurationSets>", 1)
    text = (
        f'{head}<rts:ServicePorts rts:name="Controller0.setup"/>'
        f"{sets}</rts:ConfigurationSets>{slow}{rest}"
    )
    first, second = text.split("  </rts:DataPortConnectors>", 1)
    file.write_text(
        f"{first}{short}  </rts:DataPortConnectors>{second}", encoding="utf-8"
    )
    file.with_name("timeline.toml").unlink()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(sys, "path", [*sys.path])
        assert run(["generate", "-q"]) == 0
        yield folder
    for name in [*sys.modules]:
        if name.partition(".")[0] in ("heating", "warmth"):
            del sys.modules[name]


@pytest.fixture
def walk(browser: Any, folder: Path, press: Callable[[Any], None]) -> Iterator[Walk]:
    session = Session(CommandProject(QUIET, [SYSTEM]), SYSTEM, SimulatedClock)
    with (
        serving(Server(session, "127.0.0.1", 0)) as server,
        opened(browser, server.address(full=True)) as page,
    ):
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield Walk(page, press)


def test_the_wire_that_loses_samples_is_found_with_its_reason(walk: Walk) -> None:
    page = walk.page
    play = page.get_by_role("button", name="Play")
    if play.is_visible():
        walk.press(play)
    lost = page.get_by_role("region", name="Lost samples")
    lost.get_by_role("heading", name="1 connection loses samples").wait_for()
    lost.get_by_role("button", name=WIRE).wait_for()
    lost.get_by_text(
        "10 samples arrive between two ticks, and the buffer holds 2"
    ).wait_for()
    lost.get_by_text("A buffer length of 10 holds all of them").wait_for()
    assert flaws(page) == violations(page) == []
    walk.press(lost.get_by_role("button", name=WIRE))
    wire = page.get_by_role("region", name="Connection", exact=True)
    wire.get_by_text("A buffer length of 10 holds all of them").wait_for()
    length = wire.get_by_label("inport length")
    length.wait_for()
    assert length.input_value() == "2"
    assert walk.steps <= STEPS_TO_LOSS
    assert flaws(page) == violations(page) == []


def test_the_difference_of_two_runs_is_plotted(walk: Walk) -> None:
    page = walk.page
    walk.enter(page.get_by_label("Go to time in seconds"), "5")
    page.get_by_label("Time of the run").get_by_text("5.000 s").wait_for()
    walk.press(page.get_by_role("button", name="Keep to compare"))
    guide = page.get_by_role("status", name="Two runs")
    guide.get_by_text("This run is kept").wait_for()
    walk.press(page.get_by_role("tab", name="Configuration"))
    page.get_by_text("Configuration: choose a component").wait_for()
    walk.press(page.locator(".react-flow__node", has_text="Heater0"))
    walk.enter(page.get_by_label("Heater0.warming"), "0.5")
    walk.press(guide.get_by_role("button", name="Run again to 5.0 s"))
    page.get_by_label("Time of the run").get_by_text("5.000 s").wait_for()
    walk.press(guide.get_by_role("button", name="Plot the difference"))
    table = page.get_by_role("table", name="Curves of Plot 1")
    row = table.get_by_role("row", name=re.compile("value, difference"))
    row.wait_for()
    now = row.get_by_role("cell").first

    def differs() -> bool:
        return re.fullmatch(r"\d+(\.\d+)?", now.inner_text()) is not None

    until(page, lambda: differs() and float(now.inner_text()) > 1)
    page.get_by_role("img", name="Plot 1").first.wait_for()
    assert walk.steps <= STEPS_TO_DIFFERENCE
    assert flaws(page) == violations(page) == []
