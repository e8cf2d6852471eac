"""Commands for devices in a project: CDL file, bus file and definition are those of `[sources]`."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from rtgen.cli import run
from rtgen.tools.conformance.testing import Subject

ROOT = Path(__file__).parents[3]
SPECS = ROOT / "specs" / "canopen"
MOVE = "signature sMove { ER go([in] int32_t v); ER stop(void); };\n"
LAMP = "signature sLamp { ER light([in] uint8_t percent); };\n"
RECORD = "(1.000000) can0 182#0102\n"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project; the working folder is one in it."""
    (tmp_path / "robot" / "specs").mkdir(parents=True)
    (tmp_path / "robot" / "rtgen.toml").write_text('[sources]\npaths = ["specs"]\n')
    (tmp_path / "robot" / "src").mkdir()
    monkeypatch.chdir(tmp_path / "robot" / "src")
    return tmp_path / "robot"


def boards(project: Path, **texts: str) -> None:
    for name, text in texts.items():
        (project / "specs" / f"{name}.cdl").write_text(text)


def buses(project: Path, *names: str) -> None:
    for name in names:
        shutil.copy(SPECS / f"{name}.toml", project / "specs")
    for path in SPECS.glob("*.eds"):
        shutil.copy(path, project / "specs")


# Boards


def test_the_functions_of_all_files(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    boards(
        project, move=MOVE, lamp=LAMP, both='import("move.cdl");\nimport("lamp.cdl");\n'
    )
    assert run(["rpc", "list"]) == 0
    listed = capfd.readouterr().out
    names = [line for line in listed.splitlines() if line[0] != " "]
    assert sorted(names) == ["sLamp", "sMove"]
    for words in (["../specs/move.cdl"], ["--cdl", "../specs/move.cdl"]):
        assert run(["rpc", "list", *words]) == 0
        shown = capfd.readouterr().out
        assert "sMove" in shown
        assert "sLamp" not in shown
    assert run(["rpc", "list", "../specs/move.cdl", "--cdl", "../specs/move.cdl"]) == 2


@pytest.mark.parametrize(
    "words",
    [
        ["encode", "sMove.go", "--request", '{"v": 1}'],
        ["decode", "sMove.go", "--request", "672a0001000000015a3c"],
        ["encode", "sLamp.light", "--request", '{"percent": 1}'],
    ],
)
def test_a_signature_is_found(
    words: list[str], project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    boards(project, move=MOVE, lamp=LAMP)
    file = "lamp" if "sLamp" in words[1] else "move"
    run(["rpc", *words, "--cdl", f"../specs/{file}.cdl"])
    expected = capfd.readouterr()
    assert run(["rpc", *words]) == 0
    assert capfd.readouterr() == expected


def test_a_signature_of_two_files(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    boards(project, left=MOVE, right=MOVE.replace("int32_t", "int8_t"))
    words = ["rpc", "encode", "sMove.go", "--request", '{"v": 1}']
    assert run(words) == 2
    printed = capfd.readouterr().err
    assert "left.cdl and" in printed
    assert "right.cdl: --cdl names one" in printed
    assert run([*words, "--cdl", "../specs/left.cdl"]) == 0


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        (None, "sMove.go", "which CDL file? Give --cdl FILE"),
        (MOVE, "sMoved.go", "did you mean 'sMove'?"),
        (MOVE, "sMove.goo", "did you mean 'go'?"),
        (MOVE, "go", "SIGNATURE.FUNCTION"),
        ("signature {", "sMove.go", "move.cdl:1:"),
    ],
)
def test_a_signature_that_is_not_found(
    text: str | None,
    name: str,
    message: str,
    project: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    if text is not None:
        boards(project, move=text)
    assert run(["rpc", "encode", name, "--request", "{}"]) == 2
    assert message in capfd.readouterr().err


@contextmanager
def serving(*options: str) -> Iterator[str]:
    """Yield the address of a mock board."""
    command = [sys.executable, "-m", "rtgen", "rpc", "serve", "--port", "0", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        word, address = process.stdout.readline().split()
        assert word == "listening"
        try:
            yield address
        finally:
            process.terminate()


def test_a_board_is_served_called_and_tested(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    boards(project, move=MOVE, lamp=LAMP)
    with serving("--signature", "sLamp") as address:
        assert run(["rpc", "call", address, "sLamp.light", '{"percent": 5}']) == 0
        assert json.loads(capfd.readouterr().out) == {"return": 0, "outs": {}}
        assert run(["rpc", "check", address, "sLamp"]) in (0, 1)
        capfd.readouterr()
        words = ["conformance", "--connect", f"tcp:{address}", "--signature", "sLamp"]
        run([*words, "--json"])
        report = json.loads(capfd.readouterr().out)
        assert report["definition"] == "../specs/lamp.cdl"
        assert run(words[:3]) == 2
        assert "the project has several signatures" in capfd.readouterr().err


# Buses


def test_the_bus_of_the_project(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    buses(project, "fourx")
    Path("run.log").write_text(RECORD)
    assert run(["can", "replay", "run.log", "--decode"]) == 0
    named = capfd.readouterr().out
    assert "front_right" in named
    assert (
        run(["can", "replay", "run.log", "--decode", "--bus", "../specs/fourx.toml"])
        == 0
    )
    assert capfd.readouterr().out == named
    eds = "7=../specs/epos_drive.eds"
    assert run(["can", "replay", "run.log", "--decode", "--eds", eds]) == 0
    assert "front_right" not in capfd.readouterr().out
    assert run(["can", "timing"]) == 0
    assert "Network fourx" in capfd.readouterr().out


def test_one_of_several_buses(project: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """It is that of the system in `[run]`; otherwise nodes have no names, as without a project."""
    buses(project, "fourx", "pdo_linking")
    Path("run.log").write_text(RECORD)
    words = ["can", "replay", "run.log", "--decode"]
    assert run(words) == 0
    printed = capfd.readouterr()
    assert "front_right" not in printed.out
    assert (
        "--bus names one of ../specs/fourx.toml, ../specs/pdo_linking.toml"
        in printed.err
    )
    assert run(["can", "timing"]) == 2
    assert "one of ../specs/fourx.toml" in capfd.readouterr().err
    shutil.copy(SPECS / "pdo_linking.xml", project)
    with (project / "rtgen.toml").open("a") as stream:
        stream.write('[run]\nsystem = "pdo_linking.xml"\n')
    assert run(["can", "timing"]) in (0, 1)
    assert "Network pdo_linking" in capfd.readouterr().out
    assert run(words) == 0
    assert "--bus" not in capfd.readouterr().err


def test_no_bus(project: Path, capfd: pytest.CaptureFixture[str]) -> None:
    Path("run.log").write_text(RECORD)
    assert run(["can", "replay", "run.log", "--decode"]) == 0
    assert capfd.readouterr().err == ""
    assert run(["can", "timing"]) == 2
    assert "no bus file is in [sources]" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--node", "2", "--connect", "virtual:x"], ("ftmd.eds", 2)),
        (["--node", "3", "--interface", "virtual"], ("ftmd.eds", 3)),
        (["../specs/f_palette.eds", "--node", "9"], ("f_palette.eds", 9)),
    ],
)
def test_a_node_is_tested_by_its_description(
    words: list[str],
    expected: tuple[str, int],
    project: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []

    def tested(file: Path, subject: Any) -> None:
        seen.append((file.name, subject.node_id, subject.access.bitrate))
        raise KeyboardInterrupt

    monkeypatch.setattr("rtgen.tools.conformance.canopen.testing.tested", tested)
    buses(project, "fourx")
    assert run(["conformance", *words, "--timeout", "0.1"]) == 130
    [(*found, bit_rate)] = seen
    assert tuple(found) == expected
    assert bit_rate == (None if words[0].startswith("..") else 1_000_000)


@pytest.mark.parametrize(
    ("names", "words", "message"),
    [
        ((), [], "a node in a bus file of the project"),
        (("fourx",), [], "one of 1 (front_left), 2 (front_right)"),
        (("fourx",), ["--node", "9"], "a node in a bus file of the project"),
        (("fourx", "pdo_linking"), ["--node", "1"], "one of 1 (front_left), 1 ("),
    ],
)
def test_a_node_is_asked_for(
    names: tuple[str, ...],
    words: list[str],
    message: str,
    project: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    buses(project, *names)
    assert run(["conformance", "--connect", "virtual:x", *words]) == 2
    assert message in capfd.readouterr().err


def test_all_values_of_a_subject_are_options() -> None:
    """A new field of `Subject` needs an option, or a place where it is set."""
    from rtgen.cli.conformance import conformance

    options = {parameter.name for parameter in conformance.params}
    aggregated = {"access", "wire", "permissions"}
    assert {*Subject.__dataclass_fields__} - aggregated <= options
