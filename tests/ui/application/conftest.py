"""Fixtures of a system behind a server, and its page in a real browser."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from heating_project import write
from ui_bench import GOAL, NARROW, QUIET, WIDE, opened, serving

from rtgen.cli import run as rtgen
from rtgen.compiler import compilation
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.project import Project
from rtgen.runtime import SimulatedClock
from rtgen.runtime.distribution import local_runs
from rtgen.ui.project_systems import CommandProject
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


@pytest.fixture(
    scope="module",
    params=[WIDE, pytest.param(NARROW, marks=pytest.mark.nightly)],
    ids=["wide", "narrow"],
)
def look(request: pytest.FixtureRequest) -> tuple[int, str]:
    """Return the width and the colours of a page; each has a server of its own."""
    found: tuple[int, str] = request.param
    return found


@pytest.fixture(scope="module")
def shown() -> tuple[Path, dict[str, Path] | None]:
    """Return the system that the page shows, and the files of its buses; modules override it."""
    return GOAL, None


@pytest.fixture(scope="module")
def session(shown: tuple[Path, dict[str, Path] | None], look: object) -> Session:
    file, buses = shown
    project = CommandProject(QUIET, [str(file)], buses)
    return Session(project, str(file), SimulatedClock)


@pytest.fixture(scope="module")
def server(session: Session) -> Iterator[Server]:
    with serving(Server(session, "127.0.0.1", 0)) as server:
        yield server


@pytest.fixture(scope="module")
def page(browser: Any, server: Server, look: tuple[int, str]) -> Iterator[Any]:
    """Yield a page on which time passes. Tests restore the system at their end."""
    with opened(browser, server.address(full=True), look) as page:
        page.get_by_role("button", name="Play").click()
        page.get_by_role("button", name="Pause").wait_for()
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        yield page


@pytest.fixture
def warm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield the folder of a generated project with a heater, the working folder."""
    folder = tmp_path / "project"
    write(folder)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(sys, "path", [*sys.path])
    assert rtgen(["generate", "-q"]) == 0
    yield folder
    for name in [*sys.modules]:
        if name.partition(".")[0] in ("heating", "warmth"):
            del sys.modules[name]


@pytest.fixture
def sockets(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield the folder of the sockets of runs, whose path must be short."""
    with tempfile.TemporaryDirectory(prefix="rtgen") as name:
        monkeypatch.setenv(local_runs.FOLDER, name)
        yield Path(name)


_MEMO = Memo()


@pytest.fixture(scope="module", autouse=True)
def _shared_reading() -> Iterator[None]:
    """Let sessions that read unchanged definitions share the results, as an editor's do."""
    read = compilation.read

    def reading(project: Project, **options: Any) -> FrontendResult:
        if options.get("observer") is None and options.get("memo") is None:
            _MEMO.begin()
            options["memo"] = _MEMO
        return read(project, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compilation, "read", reading)
        yield
