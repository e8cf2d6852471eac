"""Fixtures of a system behind a server, and its page in a real browser."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from patience import PATIENCE
from ui_bench import GOAL, QUIET

from rtgen.cli.ui import CommandProject
from rtgen.runtime import SimulatedClock
from rtgen.ui.server import PAGE
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

ROOT = Path(__file__).parents[3]
CARRIED = ROOT / "ui" / "node_modules" / ".chromium"
"""The files unpacked by `make page`: a Chromium for Linux on x86-64, its libraries and fonts."""
LIBRARIES = {
    "LD_LIBRARY_PATH": str(CARRIED / "lib"),
    "FONTCONFIG_PATH": str(CARRIED),
}
START_MS = 30_000
"""Time-out of the start of a browser, and of showing a page [ms]."""


@pytest.fixture(scope="session")
def chromium() -> dict[str, Any]:
    """Return the launch options of the first browser that shows a page on this machine.

    In order: the named Chromium, the one unpacked by `make page`, the machine's.
    """
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright")
    if not (PAGE / "index.html").exists():
        pytest.skip("the page is not built: `make page`")
    candidates: list[tuple[str, dict[str, str]]]
    if named := os.environ.get("RTGEN_CHROMIUM"):
        candidates = [(named, {})]
    else:
        candidates = [
            (found, libraries)
            for folder, libraries in ((CARRIED, LIBRARIES), (None, {}))
            if (found := shutil.which("chromium", path=folder))
        ]
    reasons = []
    with playwright.sync_playwright() as driver:
        for program, libraries in candidates:
            options = {
                "executable_path": program,
                "args": ["--no-sandbox"],
                "env": {**os.environ, **libraries},
                "timeout": START_MS,
            }
            try:
                with driver.chromium.launch(**options) as found:
                    found.new_page().goto("data:text/html,page", timeout=START_MS)
            except (playwright.Error, OSError) as error:
                reasons.append(f"{program}: {_cause(str(error))}")
            else:
                return options
    pytest.skip(
        "; ".join(reasons)
        or "no chromium: `make page`, install one, or name it in RTGEN_CHROMIUM"
    )


@pytest.fixture(scope="module")
def browser(chromium: dict[str, Any]) -> Iterator[Any]:
    """Yield a browser; while it is open, the thread has a running event loop."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        found = driver.chromium.launch(**chromium)
        yield found
        found.close()


def _cause(message: str) -> str:
    """Return the last output of the browser, else the first line of playwright's message."""
    head, _, _ = message.partition("\nCall log:")
    lines = re.findall(r"\[err\] (.+)", head) or head.splitlines()[:1]
    return re.sub(r"[^ -~]", "?", lines[-1])


@pytest.fixture
def shown() -> tuple[Path, dict[str, Path] | None]:
    """Return the system that the page shows, and the files of its buses; modules override it."""
    return GOAL, None


@pytest.fixture
def session(shown: tuple[Path, dict[str, Path] | None]) -> Session:
    file, buses = shown
    project = CommandProject(QUIET, [str(file)], buses)
    return Session(project, str(file), SimulatedClock)


@pytest.fixture
def server(session: Session) -> Iterator[Server]:
    server = Server(session, "127.0.0.1", 0)
    ready = threading.Event()
    thread = threading.Thread(target=lambda: asyncio.run(server.run(ready.set)))
    thread.start()
    assert ready.wait(PATIENCE)
    yield server
    server.stop()
    thread.join(PATIENCE)
    assert not thread.is_alive()


@pytest.fixture(params=[(1440, "light"), (820, "dark")], ids=["wide", "narrow"])
def page(request: pytest.FixtureRequest, browser: Any, server: Server) -> Iterator[Any]:
    width, scheme = request.param
    size = {"width": width, "height": 900}
    page = browser.new_page(viewport=size, color_scheme=scheme, locale="en")
    page.set_default_timeout(PATIENCE * 1000)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text))
    page.goto(server.address(full=True))
    page.get_by_role("button", name="Play").click()
    page.get_by_role("button", name="Pause").wait_for()
    yield page
    page.close()
    assert complaints == []
