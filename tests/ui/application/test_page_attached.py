"""The page of `rtgen ui --attach` in a real browser: a run, its end, and the next one."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from attached_program import attached, running
from page_flaws import violations
from test_attached import Project
from test_attached_runs import Running
from ui_bench import GOAL, QUIET, ROOT, WIDE, opened, serving

from rtgen import runtime
from rtgen.cli import run as rtgen
from rtgen.ui.attaching import RunLink
from rtgen.ui.peers_watcher import PeersWatcher
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [
    pytest.mark.slow,
    pytest.mark.nightly,
    pytest.mark.usefixtures("sockets"),
]


def test_a_run_is_controlled_to_its_end_and_beyond(browser: Any) -> None:
    with ExitStack() as stack:
        first = Running()
        stack.callback(first.end)
        project = Project(QUIET, [])
        link = RunLink(first.path)

        def attach(publish: Any, report: Any) -> PeersWatcher:
            return PeersWatcher(link, "here", project.data_type, publish, report)

        session = Session(project, "", runtime.RealClock, attach=attach)
        with (
            serving(Server(session, "127.0.0.1", 0)) as server,
            opened(browser, server.address(full=True), WIDE) as page,
        ):
            box = page.locator(".react-flow__node", has_text="Source0")
            box.wait_for()
            box.click()
            page.get_by_role("button", name="Activate Source0", exact=True).click()
            box.get_by_text("ACTIVE 100 Hz").wait_for()
            assert violations(page) == []
            for name in ("Activate all", "Deactivate all", "Reset all"):
                everyone = page.get_by_role("button", name=name, exact=True)
                assert everyone.is_disabled()
            everyone.hover()
            tip = page.get_by_role("tooltip").filter(has_text="one by one")
            tip.wait_for()
            page.keyboard.press("Escape")
            tip.wait_for(state="detached")
            page.keyboard.press("Control+k")
            choice = page.get_by_role("option", name="Deactivate all", disabled=True)
            choice.get_by_text("one by one").wait_for()
            page.keyboard.press("Escape")
            first.end("it was interrupted")
            page.get_by_role("alert").get_by_text("it was interrupted").wait_for()
            assert violations(page) == []
            second = Running()
            stack.callback(second.end)
            page.get_by_role("alert").wait_for(state="detached")
            box.get_by_text("INACTIVE 100 Hz").wait_for()
            box.focus()
            page.keyboard.press("Shift+F10")
            page.get_by_role("menuitem", name="Activate", exact=True).press("Enter")
            box.get_by_text("ACTIVE 100 Hz", exact=False).wait_for()


def test_its_bus_is_shown_and_commanded(browser: Any) -> None:
    system = ROOT / "specs/canopen/fourx.xml"
    buses = {"": ROOT / "specs/canopen/fourx.toml"}
    with (
        running(str(system), "--clock", "sim", "--rate", "1", "-q") as program,
        attached(program.path, buses=buses) as session,
        serving(Server(session, "127.0.0.1", 0)) as server,
        opened(browser, server.address(full=True), WIDE) as page,
    ):
        page.locator(".react-flow__node").first.wait_for()
        overview = page.get_by_role("region", name="Buses")
        overview.get_by_text("5 nodes").wait_for()
        page.keyboard.press("Control+k")
        page.get_by_placeholder("Command, component").fill("View Bus")
        page.keyboard.press("Enter")
        bus = page.locator("[data-view=Buses]")
        bus.get_by_text("heartbeat").first.wait_for()
        bus.get_by_text("operational").first.wait_for()
        assert violations(page) == []


def test_latencies_and_a_recording_beside_it(
    browser: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "slow.mcap"
    assert rtgen(["run", str(GOAL), "--until", "1", "--record", str(file), "-q"]) == 0
    monkeypatch.chdir(tmp_path)
    with (
        running(str(GOAL), "--clock", "sim", "--rate", "0.5", "-q") as program,
        attached(program.path) as session,
        serving(Server(session, "127.0.0.1", 0)) as server,
        opened(browser, server.address(full=True), WIDE) as page,
    ):
        page.locator(".react-flow__node").first.wait_for()
        latency = page.get_by_role("region", name="Latency")
        latency.get_by_text("median").first.wait_for()
        latency.get_by_role("button").first.click()
        page.get_by_role("row", name="latency").first.wait_for()
        assert violations(page) == []
        compare = page.get_by_role("button", name="Compare with a recording")
        compare.press("Enter")
        page.get_by_role("menuitem", name="slow.mcap").press("Enter")
        page.get_by_role("button", name="Beside: slow.mcap").wait_for()
        page.keyboard.press("Escape")  # the tip of the button with the focus
        page.get_by_role("tooltip").wait_for(state="detached")
        assert violations(page) == []
        compare.click()
        page.get_by_role("menuitem", name="Compare with nothing").click()
        page.get_by_role("button", name="Keep to compare").wait_for()
