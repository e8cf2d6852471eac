"""Stages of commands: times, progress on a terminal, and colours."""

from __future__ import annotations

import os
import re
import sys
import threading
from collections.abc import Iterator
from io import StringIO
from itertools import product
from pathlib import Path

import pytest
from rich.console import Console as RichConsole
from small_pipeline import Pipeline

from rtgen.cli import run
from rtgen.compiler.kit import stages
from rtgen.compiler.kit.translation import of_command
from rtgen.tools.compiling import shown_stages
from rtgen.tools.compiling.stage_progress import StageProgress
from rtgen.tools.compiling.stage_times import StageTimes

MS = 1_000_000
GENERATE = ["generate", "a.idl", "b.idl"]
STRUCT = "module robots { struct Lamp { unsigned long colour; }; };\n"


@pytest.fixture(autouse=True)
def english() -> Iterator[None]:
    with of_command(lambda: None, "en"):
        yield


class Clock:
    """A clock that advances by the given duration of each step."""

    def __init__(self) -> None:
        self.now = 0

    def __call__(self) -> int:
        return self.now

    def work(self, ms: float) -> None:
        self.now += int(ms * MS)


def names(table: str) -> list[str]:
    """Return the stages of a table, with their indentation."""
    return [
        re.split(r" {2,}(?=\d)", line)[0] for line in table.splitlines()[1:] if line
    ]


def test_the_table_has_times_files_and_notes() -> None:
    clock = Clock()
    times = StageTimes(clock)
    with stages.observed(times):
        with stages.stage("cache"):
            clock.work(2.5)
            stages.note("miss")
        for file in ("a.idl", "b.idl"):
            with stages.stage("read IDL"):
                stages.file(file)
                clock.work(100)
                with stages.stage("check"):
                    clock.work(20)
        with stages.stage("lowering tecs"):
            clock.work(0.04)
        with stages.stage("write"):
            stages.file("c.py")
            clock.work(1)
        clock.work(1000)
    assert times.table().splitlines() == [
        "stage         ms",
        "cache        2.5  miss",
        "read IDL   240.0  2 files",
        "  check     40.0",
        "write        1.0  1 file",
        "total     1243.5",
    ]


def test_a_stage_that_fails_has_its_time() -> None:
    clock = Clock()
    times = StageTimes(clock)

    def fail() -> None:
        with stages.stage("read IDL"), stages.stage("check"):
            clock.work(3)
            raise ValueError("wrong")

    with stages.observed(times), pytest.raises(ValueError, match="wrong"):
        fail()
    assert names(times.table()) == ["read IDL", "  check", "total"]


def test_nothing_is_observed_outside() -> None:
    times = StageTimes(Clock())
    with stages.observed(times):
        pass
    with stages.stage("read IDL"):
        stages.file("a.idl")
        stages.note("found")
    assert times.table() == ""
    assert stages.stage("a") is stages.stage("b")


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a struct, and a cache of its own."""
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr("rtgen.tools.compiling.stage_times._MIN_NS", 0)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    Path("lamp.idl").write_text(STRUCT)
    return work


def table_of(arguments: list[str], capfd: pytest.CaptureFixture[str]) -> str:
    capfd.readouterr()
    assert run([*arguments, "-v"]) in (0, 1)
    out, error = capfd.readouterr()
    assert "total" not in out
    _, heading, table = error.partition("stage ")
    assert heading
    return heading + table


def test_generate_shows_each_stage(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    table = table_of(["generate", "lamp.idl"], capfd)
    found = names(table)
    order = [
        "find definitions",
        "cache",
        "read IDL",
        "  preprocess",
        "  parse and resolve",
        "  make the model",
        "  check",
        "lowering numeric",
        "back end types",
        "store in cache",
        "compare with the tree",
        "write",
        "check behaviours",
        "total",
    ]
    assert [name for name in found if name in order] == order
    assert re.search(r"^cache +[\d.]+  miss$", table, re.M)
    assert re.search(r"^read IDL +[\d.]+  1 file$", table, re.M)
    made = sum(1 for f in Path("generated").rglob("*") if f.is_file())
    assert re.search(rf"^write +[\d.]+  {made} files$", table, re.M)
    again = table_of(["generate", "lamp.idl"], capfd)
    assert re.search(r"^cache +[\d.]+  hit$", again, re.M)
    assert "read IDL" not in again


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["check", "--no-cache", "lamp.idl"], {"read IDL", "compare with the tree"}),
        (["lint", "lamp.idl"], {"read IDL", "lint rules"}),
        (["inspect", "lamp.idl"], {"cache", "read IDL", "print"}),
        (["docs", "lamp.idl", "-o", "site"], {"read IDL", "pages", "write"}),
        (
            ["diff", "lamp.idl", "lamp.idl"],
            {"version lamp.idl", "  read IDL", "compare"},
        ),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_other_commands_show_theirs(
    project: Path,
    capfd: pytest.CaptureFixture[str],
    arguments: list[str],
    expected: set[str],
) -> None:
    assert expected <= set(names(table_of(arguments, capfd)))


def test_quiet_and_machine_readable_output_have_no_table(
    pipeline: Pipeline, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run([*GENERATE, "-v", "-q"]) == 0
    assert capfd.readouterr().err == ""
    assert run([*GENERATE, "-v", "--diagnostics", "json"]) == 0
    assert capfd.readouterr().err == "[]\n"


def test_errors_have_their_table(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("lamp.idl").write_text("struct Lamp { nothing at; };\n")
    assert run(["generate", "-v", "lamp.idl"]) == 2
    error = capfd.readouterr().err
    assert "error[" in error
    assert "read IDL" in names("stage" + error.partition("\nstage")[2])


class Terminal:
    """A pseudo-terminal in place of standard error, once attached; `text` ends it."""

    def __init__(self) -> None:
        self._main, other = os.openpty()
        self._stream = os.fdopen(other, "w", encoding="utf-8")
        self._read: list[bytes] = []
        self._thread = threading.Thread(target=self._drain)
        self._thread.start()

    def attach(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(sys, "stderr", self._stream)

    def _drain(self) -> None:
        while True:
            try:
                data = os.read(self._main, 65536)
            except OSError:
                return
            if not data:
                return
            self._read.append(data)

    def text(self) -> str:
        if not self._stream.closed:
            self._stream.close()
            self._thread.join()
            os.close(self._main)
        return b"".join(self._read).decode()


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[Terminal]:
    monkeypatch.setattr(shown_stages, "LONG_S", 0)
    for name in ("CI", "NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", "80")
    made = Terminal()
    yield made
    made.text()


HIDE, SHOW, ERASE = "\x1b[?25l", "\x1b[?25h", "\x1b[2K"


def test_long_work_is_shown_on_a_terminal(
    project: Path, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal.attach(monkeypatch)
    assert run(["generate", "lamp.idl"]) == 0
    text = terminal.text()
    assert "read IDL" in text
    assert text.count(HIDE) == text.count(SHOW) > 0
    summary = text.index("generated: ")
    assert ERASE in text[:summary].rpartition("read IDL")[2]
    assert HIDE not in text[summary:]


def test_the_line_has_the_stage_and_the_file() -> None:
    progress = StageProgress(3600)
    progress.begin("version main")
    progress.begin("read IDL")
    progress.file("a\x1b[2J.idl")
    progress.begin("check")
    assert progress.text() == "version main, read IDL, check  a?[2J.idl"
    progress.end()
    progress.end()
    assert progress.text() == "version main"
    progress.end()
    progress.close()


def test_the_line_is_in_the_language() -> None:
    progress = StageProgress(3600)
    with of_command(lambda: None, "ja"):
        progress.begin("version main")
        progress.begin("read IDL")
        assert progress.text() == "版 main、IDL の読み込み"
    progress.close()


def test_short_work_shows_nothing(
    project: Path, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal.attach(monkeypatch)
    monkeypatch.setattr(shown_stages, "LONG_S", 3600)
    assert run(["generate", "lamp.idl"]) == 0
    assert terminal.text().startswith("generated: ")


def test_work_that_becomes_long_is_shown(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal.attach(monkeypatch)
    progress = StageProgress(0.001)
    progress.begin("read IDL")
    progress._timer.join()
    progress.end()
    progress.close()
    assert "read IDL" in terminal.text()
    assert not progress._timer.is_alive()


@pytest.mark.parametrize(
    ("name", "value", "more"),
    [
        ("CI", "true", []),
        ("TERM", "dumb", []),
        ("TTY_INTERACTIVE", "0", []),
        ("FORCE_COLOR", "", []),
        ("FORCE_COLOR", "1", ["--quiet"]),
        ("FORCE_COLOR", "1", ["--diagnostics", "json"]),
    ],
)
def test_nobody_looks(
    project: Path,
    terminal: Terminal,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    value: str,
    more: list[str],
) -> None:
    terminal.attach(monkeypatch)
    monkeypatch.setenv(name, value)
    assert run(["generate", "lamp.idl", *more]) == 0
    assert "\x1b" not in terminal.text()


@pytest.mark.parametrize("forced", ["", "1"])
def test_pipes_have_no_progress(
    project: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    forced: str,
) -> None:
    monkeypatch.setattr(shown_stages, "LONG_S", 0)
    monkeypatch.setenv("FORCE_COLOR", forced)
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.delenv("CI", raising=False)
    assert run(["generate", "lamp.idl"]) == 0
    assert "\x1b" not in capfd.readouterr().err


AT_ONCE = (
    ("xterm", None, None, True),
    ("xterm", None, None, False),
    ("xterm", None, "0", True),
    ("xterm", "0", "0", False),
    ("xterm", "0", None, False),
    ("xterm", "", "", True),
    ("dumb", None, None, True),
    ("dumb", "0", "", False),
)
"""Those that `make test` tries: each value at least once."""


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("term", "force_color", "no_color", "tty"),
    [
        pytest.param(*each, marks=() if each in AT_ONCE else pytest.mark.nightly)
        for each in product(
            ("xterm", "dumb"), (None, "", "0"), (None, "", "0"), (True, False)
        )
    ],
)
def test_colours_are_those_of_rich(
    project: Path,
    terminal: Terminal,
    monkeypatch: pytest.MonkeyPatch,
    term: str,
    force_color: str | None,
    no_color: str | None,
    tty: bool,
) -> None:
    """Colours of findings, and of rich's output to the same stream."""
    monkeypatch.setenv("TERM", term)
    for name, value in (("NO_COLOR", no_color), ("FORCE_COLOR", force_color)):
        if value is not None:
            monkeypatch.setenv(name, value)
    monkeypatch.setattr(shown_stages, "LONG_S", 3600)
    pipe = StringIO()
    if tty:
        terminal.attach(monkeypatch)
    else:
        monkeypatch.setattr(sys, "stderr", pipe)
    rich = RichConsole(stderr=True)
    coloured = rich.color_system is not None and not rich.no_color
    Path("lamp.idl").write_text("struct Lamp { nothing at; };\n")
    assert run(["generate", "lamp.idl"]) == 2
    text = terminal.text() if tty else pipe.getvalue()
    assert "error[" in text
    assert ("\x1b[1;31m" in text) is coloured
