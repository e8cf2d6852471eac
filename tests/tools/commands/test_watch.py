"""`rtgen generate --watch` detects changes of real files."""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from rtgen.cli import run

pytestmark = pytest.mark.waits

PATIENCE = 120.0
"""Time-out of a test [s], not a measured time."""


class Watcher:
    """`rtgen generate --watch` in a folder, and its output."""

    def __init__(self, folder: Path) -> None:
        environment = {**os.environ, "RTGEN_CACHE_DIR": str(folder / "cache")}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "rtgen", "generate", "--watch"],
            cwd=folder,
            env=environment,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._lines: queue.Queue[str] = queue.Queue()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        with self.process.stderr as lines:
            for line in lines:
                self._lines.put(line)

    def said(self) -> str:
        """Return its output up to the next time that it begins to watch."""
        output = ""
        while not output.endswith("watching; Ctrl-C ends it\n"):
            output += self._lines.get(timeout=PATIENCE)
        return output

    def end(self) -> int:
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(PATIENCE)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()
        self._reader.join()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "idl").mkdir()
    (tmp_path / "inc").mkdir()
    (tmp_path / "rtgen.toml").write_text(
        "[sources]\npaths = ['idl']\ninclude = ['inc']\n", encoding="utf-8"
    )
    (tmp_path / "idl" / "a.idl").write_text(
        '#include "b.idl"\nstruct A { B inner; };\n'
    )
    (tmp_path / "inc" / "b.idl").write_text("struct B { long x; };\n")
    return tmp_path


def put(file: Path, text: str) -> None:
    """Replace the content of a file atomically, so that no run sees a part of it."""
    new = file.parent.parent / "new"
    new.write_text(text, encoding="utf-8")
    new.replace(file)


@pytest.fixture
def watcher(folder: Path) -> Iterator[Watcher]:
    if sys.platform == "win32":
        pytest.skip("a process cannot be interrupted there as Ctrl-C does")
    pytest.importorskip("watchfiles", reason="watchfiles is not installed")
    found = Watcher(folder)
    yield found
    found.kill()


def test_each_change_of_an_input_is_a_run(folder: Path, watcher: Watcher) -> None:
    package = folder / "generated" / "robots"
    assert re.match(r"generated: \d+ written, 0 removed", watcher.said())
    put(folder / "inc" / "b.idl", "struct B { long x; long y; };\n")
    assert re.match(r"generated: [1-9]\d* written, 0 removed", watcher.said())
    assert "y: int" in (package / "_idl" / "b.py").read_text(encoding="utf-8")
    put(folder / "idl" / "new.idl", "struct C { long x; };\n")
    assert "written" in watcher.said()
    assert (package / "_idl" / "new.py").is_file()
    put(folder / "idl" / "new.idl", "struct C { lon x; };\n")
    assert "error[IDL0200]" in watcher.said()
    (folder / "idl" / "new.idl").unlink()
    assert re.search(r"[1-9]\d* removed", watcher.said())
    settings = (folder / "rtgen.toml").read_text(encoding="utf-8")
    put(folder / "rtgen.toml", "[sources")
    assert "error[PRJ0001]" in watcher.said()
    put(folder / "rtgen.toml", f"{settings}[output]\npackage = 'other'\n")
    assert "written" in watcher.said()
    assert (folder / "generated" / "other" / "_idl" / "a.py").is_file()
    assert watcher.end() == 0


def test_an_include_that_comes_later(folder: Path, watcher: Watcher) -> None:
    watcher.said()
    (folder / "inc" / "b.idl").unlink()
    assert "error[IDL0010]" in watcher.said()
    put(folder / "idl" / "b.idl", "struct B { octet z; };\n")
    assert "written" in watcher.said()
    assert watcher.end() == 0


def test_without_the_library(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.setitem(sys.modules, "watchfiles", None)
    assert run(["generate", "--watch"]) == 3
    assert (
        "pip install ./runtime '.[watch]' in a clone of rtgen" in capfd.readouterr().err
    )
    assert not (folder / "generated").exists()
