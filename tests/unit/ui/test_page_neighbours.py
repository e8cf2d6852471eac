"""Components of other processes on the page, by mouse and by keyboard."""

from __future__ import annotations

from collections.abc import Iterator
from subprocess import Popen
from typing import Any

import pytest

pytest.importorskip("omniORB", reason="omniORBpy is not installed")

from patience import PATIENCE
from ui_bench import GOAL, QUIET, started_over_corba, until

from rtgen.cli.ui import CommandProject
from rtgen.runtime import SimulatedClock
from rtgen.runtime.corba.name_server import NameServer
from rtgen.ui.protocol import ui
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]


@pytest.fixture(scope="module")
def names() -> Iterator[str]:
    with NameServer() as server:
        yield server.address


@pytest.fixture(scope="module")
def process(names: str, look: object) -> Iterator[Popen[bytes]]:
    found = started_over_corba(names)
    yield found
    found.kill()
    found.wait(PATIENCE)


@pytest.fixture(scope="module")
def session(names: str, process: Popen[bytes]) -> Session:
    """The page has a system of its own, too."""
    project = CommandProject(QUIET, [str(GOAL)])
    return Session(project, str(GOAL), SimulatedClock, [names])


def test_they_are_shown_steered_and_wired(
    page: Any, session: Session, names: str, process: Popen[bytes]
) -> None:
    name = f"{names}/PathFollower0"
    source, target = f"{name}.velocity", f"{names}/RefHardRh30.InTargetVelocity"

    def connected() -> bool:
        ends = [(e.source, e.target) for e in session.outside.connections.values()]
        return (source, target) in [
            (f"{a.instance}.{a.port}", f"{b.instance}.{b.port}") for a, b in ends
        ]

    def state() -> ui.State:
        return session.outside.components[name].current

    tree = page.get_by_role("region", name="Naming services")
    tree.get_by_role("button", name=f"{name}, PathFollower, ACTIVE").press("Enter")
    page.get_by_label(f"{name}, PathFollower, ACTIVE").last.wait_for()
    page.get_by_role("button", name=f"Deactivate {name}", exact=True).click()
    until(page, lambda: state() is ui.State.STATE_INACTIVE)
    tree.get_by_role("button", name=f"{name}, PathFollower, INACTIVE").wait_for()
    page.get_by_role("button", name=f"Activate {name}", exact=True).press("Enter")
    until(page, lambda: state() is ui.State.STATE_ACTIVE)
    page.get_by_role("tab", name="Configuration").press("Enter")
    field = page.get_by_label(f"{name}.max_v", exact=True)
    field.fill("0.25")
    field.press("Enter")
    until(
        page,
        lambda: (
            ui.Value("max_v", "0.25")
            in session.outside.components[name].configuration_sets[0].values
        ),
    )
    page.get_by_role("tab", name="Connections").press("Enter")
    page.get_by_label("Chosen port").select_option("velocity")
    until(page, connected)
    page.get_by_role("button", name=f"Cut {source} from {target}").press("Enter")
    until(page, lambda: not connected())
    page.get_by_role("button", name=f"Connect {source} with {target}").click()
    until(page, connected)
    process.kill()
    tree.get_by_role("button", name=f"{name}, PathFollower, does not answer").wait_for()
    page.get_by_text("it does not answer").first.wait_for()
