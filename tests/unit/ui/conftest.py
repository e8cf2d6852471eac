"""A system behind a server, and its page in a real browser."""

from __future__ import annotations

import asyncio
import os
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
"""What `make page` unpacks: a Chromium for Linux on x86-64, its libraries and fonts."""
LIBRARIES = {
    "LD_LIBRARY_PATH": str(CARRIED / "lib"),
    "FONTCONFIG_PATH": str(CARRIED),
}


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """The first Chromium that shows a page on this machine."""
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright")
    if not (PAGE / "index.html").exists():
        pytest.skip("the page is not built: `make page`")
    faults = []
    with playwright.sync_playwright() as driver:
        for program, settings in _programs():
            try:
                found = driver.chromium.launch(
                    executable_path=program,
                    args=["--no-sandbox"],
                    env={**os.environ, **settings},
                    timeout=PATIENCE * 1000,
                )
                probe = found.new_page()
                probe.goto("data:text/html,shown", timeout=PATIENCE * 1000)
                probe.close()
            except playwright.Error as error:
                faults.append(f"; {program}: {error.message}")
                continue
            yield found
            found.close()
            return
    pytest.skip(
        "no chromium: `make page`, install one, or name it in RTGEN_CHROMIUM"
        + "".join(faults)
    )


def _programs() -> Iterator[tuple[str, dict[str, str]]]:
    """The Chromium that is named, else that of `make page`, else the machine's; its settings."""
    if named := os.environ.get("RTGEN_CHROMIUM"):
        yield named, {}
        return
    if (CARRIED / "chromium").exists():
        yield str(CARRIED / "chromium"), LIBRARIES
    if installed := shutil.which("chromium"):
        yield installed, {}


@pytest.fixture
def shown() -> tuple[Path, dict[str, Path] | None]:
    """The system that the page shows, and the files of its buses; modules have their own."""
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
