"""Systems in their main views, on a desk, a tablet and a phone, in both colours: no flaw.

`make looks` takes pictures of ten systems into build/looks, and tells their flaws.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from page_flaws import flaws
from ui_bench import GOAL, QUIET, ROOT, opened, serving, until

from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
SIZES = {"desk": (1440, 900), "tablet": (820, 1180), "phone": (390, 844)}
COPIES = 10
"""How often the six components of rh3_goal are in the large system."""
PICTURES = os.environ.get("RTGEN_LOOKS")
"""The folder of the pictures, if they are to be taken."""


@dataclass(frozen=True)
class Case:
    """A system at a time, a component with values, and views beside those of all systems."""

    file: str
    component: str
    time: float = 3
    views: tuple[str, ...] = ()


CASES = {
    each.file.rpartition("/")[2].removesuffix(".xml"): each
    for each in (
        Case("specs/navigation/rh3_goal.xml", "Odometry0", views=("Drive", "Plots")),
        Case("specs/navigation/rh3_path.xml", "Odometry0", 20),
        Case("specs/navigation/obstacles.xml", "ObstacleMonitor0", 10),
        Case("specs/canopen/rh3_beego.xml", "LeftWheel0", views=("Buses",)),
        Case("specs/canopen/fourx.xml", "RefHardFourX0", views=("Buses",)),
        Case("specs/canopen/pdo_linking.xml", "Motor0", views=("Buses",)),
        Case("specs/tecs/rh3_board.xml", "MotorBoardMarshaller0", views=("Boards",)),
        Case("specs/experiments/leader_exchange", "RefHard0", 10),
        Case("specs/experiments/interchange", "RefHard0", 15),
        Case("sixty.xml", "Odometry0_7", 1),
    )
}
BESIDE = (
    *("Values", "Connections", "Configuration", "Services", "Plots", "Map", "Drive"),
    *("Buses", "Boards", "Console", "Timeline"),
)
"""The views beside the wiring on a desk."""
JUDGED = ("fourx",)
"""The system that is judged each night; pictures are taken of all."""
OF_ALL = (
    *("Wiring", "Values", "Connections", "Configuration", "Services"),
    *("Map", "Timeline"),
)


def sixty() -> str:
    """Return a system of ten robots that drive to a goal."""
    text = GOAL.read_text(encoding="utf-8")
    head, *rest = re.split(r"(?=  <rts:Components )", text)
    components, tail = rest[:-1], rest[-1]
    end = tail.index("</rts:Components>") + len("</rts:Components>\n")
    components.append(tail[:end])
    names = re.findall(r'rts:instanceName="(\w+)"', "".join(components))
    connectors = re.findall(
        r"  <rts:DataPortConnectors .*?</rts:DataPortConnectors>\n", tail, re.S
    )
    name = re.compile(rf"\b({'|'.join(set(names))})\b")

    def copied(part: str, number: int) -> str:
        part = re.sub(r'(rts:connectorId=")', rf"\g<1>{number}_", part)
        return name.sub(rf"\1_{number}", part)

    copies = range(COPIES)
    return "".join(
        (
            head,
            *(copied(each, number) for number in copies for each in components),
            *(copied(each, number) for number in copies for each in connectors),
            "</rts:RtsProfile>\n",
        )
    )


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    large = tmp_path_factory.mktemp("large") / "sixty.xml"
    large.write_text(sixty(), encoding="utf-8")
    files = [str(large) if each == "sixty" else CASES[each].file for each in CASES]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        yield Session(CommandProject(QUIET, files), files[0], SimulatedClock)


@pytest.fixture(scope="module")
def server(session: Session) -> Iterator[Server]:
    with serving(Server(session, "127.0.0.1", 0)) as server:
        yield server


@pytest.fixture(scope="module")
def screens(browser: Any, server: Server) -> Iterator[dict[str, Any]]:
    """Yield a page of each size."""
    with ExitStack() as stack:
        pages = {}
        for name, size in SIZES.items():
            page = stack.enter_context(
                opened(browser, server.address(full=True), (size[0], "light"))
            )
            page.set_viewport_size({"width": size[0], "height": size[1]})
            pages[name] = page
        yield pages


def show(page: Any, view: str, component: str) -> None:
    """Show a view of a component by the address of the page."""
    parts = {"view": view, "component": component}
    if page.viewport_size["width"] > 1000:
        shown = "Values" if view == "Wiring" else view
        side = "+".join(each + "*" * (each == shown) for each in BESIDE)
        parts = {"panes": f"(Wiring,{side}~400px)", "component": component}
    text = "&".join(f"{name}={value}" for name, value in parts.items() if value)
    page.evaluate("text => { location.hash = text }", text)
    part = ".wiring" if view == "Wiring" else f"[data-view={view}]"
    page.locator(part).wait_for()
    page.locator(".wiring[aria-busy=true]").wait_for(state="detached")


@pytest.mark.parametrize("name", CASES if PICTURES else JUDGED)
def test_nothing_is_cut_covered_or_faint(
    screens: dict[str, Any], session: Session, name: str
) -> None:
    case = CASES[name]
    first = screens["desk"]
    first.get_by_role("combobox", name="System").select_option(label=name)
    until(first, lambda: Path(session.file).stem == Path(case.file).stem)
    first.get_by_label("Go to time in seconds").fill(str(case.time))
    first.get_by_role("button", name="Go", exact=True).click()
    until(first, lambda: session.now >= case.time)
    found = []
    views = [("Wiring", ""), *((each, case.component) for each in OF_ALL + case.views)]
    for size, page in screens.items():
        heading = page.get_by_role("heading", name=session.profile.name, exact=True)
        heading.wait_for()
        for view, component in views:
            show(page, view, component)
            for colours in ("light", "dark"):
                page.emulate_media(color_scheme=colours)
                shown = f"{name} {view}{'' if component else ' 0'} {size} {colours}"
                found += [f"{shown}: {each}" for each in flaws(page)]
                if PICTURES:
                    file = Path(PICTURES, f"{shown.replace(' ', '-')}.png")
                    page.screenshot(path=ROOT / file)
    assert found == [], "\n".join(found)
