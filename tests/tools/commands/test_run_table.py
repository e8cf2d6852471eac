"""`[run]` of rtgen.toml: what commands take from it, and where the command line wins."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.project.file import SCHEMA
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.recording.events import Log
from rtgen.tools.running import engines, supervision
from rtgen.tools.running.plan import Plan


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with the systems `bench` and `other`, and without the table of a new one."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["new", "project", "bench", "-q"]) == 0
        patch.chdir("bench")
        assert run(["new", "system", "other", "Scaler", "-q"]) == 0
        assert run(["run", "-q"]) == 0
        settings = Path("rtgen.toml")
        head, mark, table = settings.read_text().partition("\n[run]\n")
        assert mark
        assert table == 'system = "systems/bench.xml"\nuntil = "10"\n'
        settings.write_text(head)
    return folder / "bench"


@pytest.fixture
def project(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, as the working folder."""
    folder = tmp_path / "bench"
    shutil.copytree(made, folder)
    monkeypatch.chdir(folder)
    return folder


def told(*lines: str) -> None:
    with Path("rtgen.toml").open("a") as stream:
        stream.write("".join(f"{line}\n" for line in ("", "[run]", *lines)))


BENCH = 'system = "systems/bench.xml"'
REAL = 'clock = "real"'
DDS = 'transport = "dds"'


def simulated(capfd: pytest.CaptureFixture[str]) -> float:
    """Return the seconds that a run has printed."""
    out = capfd.readouterr().out
    return float(out.partition("simulated [s]")[2].split()[0])


@pytest.mark.parametrize("folder", [".", "src", "definitions"])
def test_a_run_without_arguments(
    folder: str,
    project: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    told(BENCH, "until = 0.5", 'record = "a.mcap"')
    monkeypatch.chdir(folder)
    assert run(["run"]) == 0
    assert simulated(capfd) == 0.5
    assert max(e["t"] for e in Log(project / "a.mcap").events()) <= SECOND // 2


def test_a_folder_is_a_system(project: Path, capfd: pytest.CaptureFixture[str]) -> None:
    Path("rig").mkdir()
    Path("systems/other.xml").rename("rig/system.xml")
    told('system = "rig"', 'until = "Scaler0=ACTIVE"')
    assert run(["run"]) == 0
    assert "Scaler1" not in capfd.readouterr().out


@pytest.mark.parametrize(
    ("words", "seconds", "file"),
    [
        (["--until", "0.25"], 0.25, "a.mcap"),
        (["--record", "b.mcap"], 0.5, "b.mcap"),
        (["systems/other.xml"], 0.5, "a.mcap"),
        (["--clock", "sim", "--transport", "direct"], 0.5, "a.mcap"),
    ],
)
def test_the_command_line_wins(
    words: list[str],
    seconds: float,
    file: str,
    project: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    told(BENCH, "until = 0.5", 'record = "a.mcap"')
    assert run(["run", *words]) == 0
    assert simulated(capfd) == seconds
    assert [path.name for path in project.glob("*.mcap")] == [file]


def test_simulated_time_needs_no_engine(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told(BENCH, "until = 0.5", REAL, DDS, 'partition = "p"')
    assert run(["run", "--clock", "sim"]) == 0
    assert simulated(capfd) == 0.5


def test_a_condition_of_another_system_is_reported_at_its_place(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told(BENCH, 'until = "Scaler1=ERROR"')
    line = len(Path("rtgen.toml").read_text().splitlines())
    assert run(["run", "systems/other.xml"]) == 2
    printed = capfd.readouterr().err
    assert f"rtgen.toml:{line}:1: error[SYS0005]" in printed
    assert "'Scaler1'" in printed


@pytest.mark.parametrize("command", ["run", "ui", "graph"])
def test_a_system_is_asked_for(
    command: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run([command]) == 2
    printed = capfd.readouterr().err
    assert "Missing argument 'SYSTEM" in printed
    assert "[run] system" in printed


def test_the_table_is_checked_whole() -> None:
    """`rtgen run` has a parameter for each key."""
    from rtgen.cli.run import run as command

    names = {parameter.opts[-1].lstrip("-") for parameter in command.params}
    table = SCHEMA["run"]
    assert isinstance(table, dict)
    assert names >= table.keys()


@pytest.mark.parametrize("command", ["generate", "check", "run", "graph", "ctl list"])
@pytest.mark.parametrize(
    ("lines", "code", "column"),
    [
        (['sytem = "a"'], "PRJ0002", 1),
        (['system = "none.xml"'], "PRJ0005", 1),
        (['system = "src"'], "PRJ0005", 1),
        (["clock = 1"], "PRJ0003", 1),
        (["until = true"], "PRJ0003", 1),
        (['until = "soon"'], "SYS0006", 1),
        (["until = -1"], "SYS0006", 1),
        (["until = nan"], "SYS0006", 1),
        (['transport = "udp"'], "PRJ0003", 1),
        ([DDS], "PRJ0019", 1),
        ([REAL, DDS, 'partition = "a b"'], "PRJ0003", 1),
        ([REAL, 'partition = "a"'], "PRJ0019", 1),
        (['record = ""'], "PRJ0003", 1),
    ],
)
def test_a_wrong_value_is_reported_at_its_place(
    lines: list[str],
    code: str,
    column: int,
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("src").mkdir()
    Path("rtgen.toml").write_text("[run]\n" + "\n".join(lines) + "\n")
    assert run([*command.split(), "--diagnostics", "github"]) == 2
    printed = capfd.readouterr().err
    place = f"file=rtgen.toml,line={1 + len(lines)},col={column}"
    assert place in printed
    assert code in printed


def test_a_dotted_key_has_a_place(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rtgen.toml").write_text('sources.paths = []\nrun.clock = "no"\n')
    assert run(["run"]) == 2
    assert "rtgen.toml:2:5: error[PRJ0003]" in capfd.readouterr().err


# Other commands


def test_a_recording_is_replayed_into_the_system(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told(BENCH, "until = 0.5", 'record = "a.mcap"')
    assert run(["run", "-q"]) == 0
    assert run(["replay", "a.mcap", "--only", "Scaler1"]) == 0
    shown = capfd.readouterr().out
    assert "Scaler1" in shown
    assert "Scaler0" not in shown
    assert run(["replay", "a.mcap", "--into", "systems/other.xml"]) == 0
    assert "Scaler1" not in capfd.readouterr().out


def test_the_system_is_drawn(project: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["graph", "systems/bench.xml"]) == 0
    picture = capfd.readouterr().out
    told(BENCH)
    assert run(["graph"]) == 0
    assert capfd.readouterr().out == picture


@pytest.mark.parametrize(
    ("words", "systems", "is_simulated"),
    [
        ([], ("systems/bench.xml",), False),
        (["--clock", "sim"], ("systems/bench.xml",), True),
        (["systems/other.xml"], ("systems/other.xml",), False),
        (["a.mcap"], ("a.mcap",), False),
        (["--nameserver", "127.0.0.1:1"], (), False),
    ],
)
def test_the_system_is_shown(
    words: list[str],
    systems: tuple[str, ...],
    is_simulated: bool,
    project: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    monkeypatch.setattr(
        "rtgen.ui.launch.served", lambda options, *_: seen.append(options)
    )
    told(BENCH, REAL, 'record = "a.mcap"')
    assert run(["ui", *words]) == 0
    [options] = seen
    assert (options.systems, options.simulated) == (systems, is_simulated)
    assert options.recording.file is None


@dataclass
class Joined:
    """The engines that commands have opened, by transport and partition."""

    seen: list[tuple[str, str]] = field(default_factory=list)

    def open(self, options: engines.EngineOptions, system: str, *_: object) -> None:
        self.seen.append((options.transport, options.partition or system))
        raise ToolError("no engine in this test")


@pytest.mark.parametrize(
    ("table", "words", "expected"),
    [
        ((BENCH, REAL, DDS), [], ("dds", "bench")),
        ((BENCH, REAL, DDS, 'partition = "p"'), [], ("dds", "p")),
        (
            (BENCH, REAL, DDS, 'partition = "p"'),
            ["--transport", "zenoh"],
            ("zenoh", "p"),
        ),
        (
            (BENCH, REAL, DDS, 'partition = "p"'),
            ["--system", "systems/other.xml"],
            ("dds", "other"),
        ),
        (
            (BENCH, REAL, DDS, 'partition = "p"'),
            ["--system", "./systems/../systems/bench.xml"],
            ("dds", "p"),
        ),
        ((BENCH, REAL, DDS), ["--partition", "q"], ("dds", "q")),
        ((REAL, DDS, 'partition = "p"'), [], ("dds", "p")),
        ((BENCH,), ["--transport", "dds"], ("dds", "bench")),
    ],
)
def test_control_joins_the_processes_of_the_run(
    table: Sequence[str],
    words: list[str],
    expected: tuple[str, str],
    project: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    joined = Joined()
    monkeypatch.setattr(
        engines.EngineOptions, "open", lambda *given: joined.open(*given)
    )
    told(*table)
    for command in ("list", "show Scaler0", "get Scaler0", "watch"):
        assert run(["ctl", *command.split(), *words]) == 3
    assert joined.seen == [expected] * 4


@pytest.mark.parametrize("table", [(), (BENCH,), ('transport = "corba"',)])
def test_control_asks_for_a_transport(
    table: Sequence[str], project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told(*table)
    assert run(["ctl", "list"]) == 2
    assert "Missing option '--transport'" in capfd.readouterr().err


# Several processes


class Workers:
    """Stands for the supervisor, which starts the processes."""

    commands: Sequence[Sequence[str]] = ()

    def __init__(self, workers: Sequence[supervision.Worker], *_: object) -> None:
        type(self).commands = [worker.command for worker in workers]

    def run(self) -> int:
        return 0


def test_supervised_processes_are_told_all(
    project: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """They do not take it from the table: each would end by itself, and write the recording."""
    monkeypatch.setattr(supervision, "Supervisor", Workers)
    told(BENCH, REAL, DDS, 'partition = "p"', 'record = "a.mcap"', "until = 5")
    assert run(["run", "--supervise", "on-failure"]) == 0
    assert "[run] record is left out" in capfd.readouterr().err
    assert len(Workers.commands) == 2
    for command in Workers.commands:
        assert "--told" in command
        words = " ".join(command)
        assert "--transport dds" in words
        assert "--partition p" in words
        assert "--record" not in words
        assert "--until 5" in words


@pytest.mark.parametrize(
    "words",
    [
        ["--language", "ja", "run", "--supervise", "never"],
        ["run", "--supervise", "never", "--language=ja"],
    ],
)
def test_supervised_processes_speak_the_language(
    project: Path, monkeypatch: pytest.MonkeyPatch, words: list[str]
) -> None:
    monkeypatch.setattr(supervision, "Supervisor", Workers)
    told(BENCH, REAL, DDS)
    assert run(words) == 0
    for command in Workers.commands:
        assert "--language ja" in " ".join(command)


@pytest.mark.parametrize("words", [[], ["--told"]])
def test_a_part_of_the_system_is_not_recorded(
    words: list[str],
    project: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Plan] = []
    monkeypatch.setattr(
        "rtgen.cli.run.executed", lambda plan, _: seen.append(plan) or 0
    )
    told(
        BENCH,
        REAL,
        DDS,
        'partition = "p"',
        'record = "a.mcap"',
        'until = "Scaler0=ERROR"',
    )
    whole = ["systems/bench.xml", "--clock", "real", "--transport", "zenoh"]
    assert run(["run", *(whole if words else []), "--only", "Scaler1", *words]) == 0
    [plan] = seen
    assert plan.options.recording.file is None
    carrying = plan.options.carrying
    if words:
        assert (carrying.transport, carrying.partition) == ("zenoh", None)
        assert plan.options.until is None
    else:
        assert (carrying.transport, carrying.partition) == ("dds", "p")
        assert plan.condition.instance is None  # another process waits for that state
