"""`rtgen run` in a process of its own, and pages that are attached to it."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from attached_page import Watching
from patience import PATIENCE, until
from ui_bench import QUIET

from rtgen import runtime
from rtgen.runtime.distribution import local_runs
from rtgen.tools.running.recording_options import RecordingOptions
from rtgen.ui.attaching import RunLink
from rtgen.ui.peers_watcher import PeersWatcher
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session


class Program:
    """A process of `rtgen run`; `path` is its socket."""

    def __init__(self, *arguments: str) -> None:
        before = {path for path, _ in local_runs.runs()}
        command = [sys.executable, "-m", "rtgen", "run", *arguments]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

        def found() -> Path | None:
            assert self.process.poll() is None, self.said
            new = [path for path, _ in local_runs.runs() if path not in before]
            return new[0] if new else None

        self.path = until(found)

    @property
    def said(self) -> str:
        """What the process has printed, at its end."""
        return self.process.communicate(timeout=PATIENCE)[0]

    def interrupt(self) -> str:
        """End the run in order; return what it has printed."""
        self.process.send_signal(signal.SIGINT)
        return self.said

    def kill(self) -> None:
        """End the process at once."""
        self.process.kill()
        self.process.communicate(timeout=PATIENCE)


@contextmanager
def running(*arguments: str) -> Iterator[Program]:
    """Yield a run, which is ended at the end."""
    program = Program(*arguments)
    try:
        yield program
    finally:
        if program.process.poll() is None:
            program.kill()


@contextmanager
def attached(
    path: Path, record: Path | None = None, buses: dict[str, Path] | None = None
) -> Iterator[Session]:
    """Yield a session that shows the run of a socket."""
    options = RecordingOptions(None if record is None else str(record))
    link = RunLink(path, recording=options)
    project = CommandProject(QUIET, [link.hello.file], buses)

    def attach(publish: Any, report: Any) -> PeersWatcher:
        return PeersWatcher(link, "there", project.data_type, publish, report, 0.2)

    session = Session(project, "", runtime.RealClock, attach=attach)
    try:
        yield session
    finally:
        session.close()


@contextmanager
def watching(
    path: Path, record: Path | None = None, buses: dict[str, Path] | None = None
) -> Iterator[Watching]:
    """Yield a page without a browser that shows the run of a socket."""
    with attached(path, record, buses) as session:
        page = Watching(session)
        page.until(lambda: page.components)
        yield page
