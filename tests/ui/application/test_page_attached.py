"""The page of `rtgen ui --attach` in a real browser: a run, its end, and the next one."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import pytest
from page_flaws import violations
from test_attached import Project
from test_attached_runs import Running
from ui_bench import QUIET, WIDE, opened, serving

from rtgen import runtime
from rtgen.runtime.distribution import local_runs
from rtgen.ui.attaching import RunLink
from rtgen.ui.peers_watcher import PeersWatcher
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.nightly]


def test_a_run_is_controlled_to_its_end_and_beyond(
    browser: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    with tempfile.TemporaryDirectory(prefix="rtgen") as folder:
        monkeypatch.setenv(local_runs.FOLDER, str(Path(folder)))
        first = Running()
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
            first.end("it was interrupted")
            page.get_by_role("alert").get_by_text("it was interrupted").wait_for()
            assert violations(page) == []
            second = Running()
            page.get_by_role("alert").wait_for(state="detached")
            box.get_by_text("INACTIVE 100 Hz").wait_for()
            box.focus()
            page.keyboard.press("Shift+F10")
            page.get_by_role("menuitem", name="Activate", exact=True).press("Enter")
            box.get_by_text("ACTIVE 100 Hz", exact=False).wait_for()
        second.end()
