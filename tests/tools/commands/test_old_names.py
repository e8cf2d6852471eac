"""Commands that are parts of others now: their old names work as before, and are not shown."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.runtime.timing.clocks import SECOND

ROOT = Path(__file__).parents[3]
MODULE = ROOT / "tests" / "golden" / "cases" / "adopt_module" / "input" / "Gate.txt"


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A module of OpenRTM-aist-Python, in the working folder."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(MODULE, "Gate.py")
    return Path("Gate.py")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of half a second."""
    folder = tmp_path_factory.mktemp("recording")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["new", "project", "bench", "-q"]) == 0
        patch.chdir("bench")
        words = ["run", "systems/bench.xml", "--until", "0.5", "-q"]
        assert run([*words, "--record", "goal.mcap"]) == 0
    return folder / "bench" / "goal.mcap"


@pytest.mark.parametrize("more", [[], ["--to", "idl"]])
def test_a_module_is_converted_as_it_is_adopted(
    more: list[str], module: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    code = run(["adopt", "Gate.py"])
    adopted = capfd.readouterr()
    assert code == 0
    assert "component Gate" in adopted.out
    assert run(["convert", "Gate.py", *more]) == code
    assert capfd.readouterr() == adopted


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("form", "start", "name"),
    [
        ("idl", "", "Gate.idl"),
        ("rtc-xml", "<?xml", "Gate.xml"),
        ("rtc-yaml", "rtcProfile:", "Gate.yaml"),
    ],
)
def test_a_module_is_converted_to_each_form(
    form: str,
    start: str,
    name: str,
    module: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert run(["convert", "Gate.py", "--to", form]) == 0
    printed = capfd.readouterr().out
    assert printed.startswith(start)
    assert run(["convert", "Gate.py", "--to", form, "-o", "new/folder"]) == 0
    assert capfd.readouterr().err.endswith(f"new/folder/{name} written\n")
    written = Path("new/folder", name)
    assert written.read_text("utf-8") == printed
    assert run(["convert", "Gate.py", "--to", form, "-o", "new/folder"]) == 3
    assert "exists already" in capfd.readouterr().err


def test_a_component_is_no_system(
    module: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["convert", "Gate.py", "--to", "rts-xml"]) == 2
    assert "PRJ0010" in capfd.readouterr().err


def test_a_recording_is_played(
    recording: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = str(recording)
    assert run(["replay", file]) == 0
    printed = capfd.readouterr()
    assert max(json.loads(line)["t"] for line in printed.out.splitlines()) > 4e8
    for words in (["log", "cat", file], ["log", "play", file, "--rate", "1000"]):
        assert run(words) == 0
        assert capfd.readouterr() == printed
    assert run(["log", "cat", file, "Scaler1", "--event", "state"]) == 0
    chosen = capfd.readouterr().out
    assert chosen.count("\n") > 1
    words = ["log", "play", file, "Scaler1", "--event", "state", "--rate", "1000"]
    assert run(words) == 0
    assert capfd.readouterr().out == chosen
    assert run([*words, "--until", "0.2"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert lines == [
        line for line in chosen.splitlines() if json.loads(line)["t"] <= 2e8
    ]


def test_a_recording_is_drawn_without_a_name(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    sample = {"event": "sample", "instance": "A0", "port": "out", "value": 1.5}
    lines = (json.dumps({"t": second * SECOND, **sample}) for second in range(3))
    Path("goal.jsonl").write_text("".join(f"{line}\n" for line in lines))
    assert run(["log", "plot", "goal.jsonl", "A0.in"]) == 2
    assert not Path("build").exists()
    capfd.readouterr()
    assert run(["log", "plot", "goal.jsonl", "A0.out"]) == 0
    assert capfd.readouterr().err == "results: build/goal/values.svg\n"
    assert Path("build/goal/values.svg").read_text().startswith("<?xml")


def test_frames_are_drawn_without_a_name(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    Path("run.log").write_text("(1.000000) can0 182#0102\n")
    eds = ROOT / "specs" / "canopen" / "fourx.toml"
    words = ["can", "plot", "ControlWord", "--from", "run.log", "--bus", str(eds)]
    run(words)
    assert "results: build/run/values.svg\n" in capfd.readouterr().err
    assert Path("build/run/values.svg").is_file()
