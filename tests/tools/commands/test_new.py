"""`rtgen new`: the new project is complete, and nothing is overwritten."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from type_checkers import check_by_mypy

from rtgen.cli import run
from rtgen.compiler.project import output
from rtgen.tools.scaffold import names, starters

TEMPLATES = Path(starters.__file__).parents[2] / "templates/new"
SPECS = Path(__file__).parents[3] / "specs"
PARTS = {
    "component": ["component", "LeftArm"],
    "device": ["device", "Drive"],
    "board": ["board", "Lamp"],
    "system": ["system", "bench", "LeftArm", "Scaler", "LeftArm"],
}


def files_of(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.fixture(autouse=True)
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    folder = tmp_path / "work"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def started(
    monkeypatch: pytest.MonkeyPatch, *more: str, name: str = "my-robot"
) -> Path:
    """Return a new project as the working folder."""
    assert run(["new", "project", name, *more]) == 0
    monkeypatch.chdir(name)
    return Path.cwd()


def check_it_is_whole(project: Path, generated: Path | None) -> None:
    """Check the project by mypy --strict and its own tests."""
    search = [project / "src", *([generated] if generated else [])]
    check_by_mypy([project / "src", project / "tests"], search)
    command = [sys.executable, "-W", "error", "-m", "pytest", "-q"]
    command += ["-p", "no:cacheprovider", "-c", "pyproject.toml"]
    # Plug-ins of this environment are not part of a new project.
    alone = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(
        command, cwd=project, env=alone, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_each_new_file_has_the_form_of_fmt(
    work: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Those of a base of a board have no recommendation of lint, either."""
    base = ["base", "--ros2"]
    drive = str(SPECS / "canopen" / "epos_drive.eds")
    board = Path(shutil.copytree(SPECS / "tecs", "given")) / "board.cdl"
    assert run(["fmt", str(board)]) == 0
    assert run(["new", *base, "Driven", drive]) == 0
    assert run(["new", *base, "Wired", str(board)]) == 0
    assert run(["new", "backend", "struct-list"]) == 0
    started(monkeypatch)
    for part in PARTS.values():
        assert run(["new", *part]) == 0
    capsys.readouterr()
    for name in ("Driven", "Wired", "struct-list", "my-robot"):
        monkeypatch.chdir(work / name)
        assert run(["fmt", "--check", "."]) == 0, capsys.readouterr().out
    monkeypatch.chdir(work / "Wired")
    assert run(["lint"]) == 0


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.parametrize("name", ["my-robot", "acme.rover"])
def test_a_project_with_every_part_is_whole(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    project = started(monkeypatch, name=name)
    for number, part in enumerate([[], *PARTS.values()]):
        assert number == 0 or run(["new", *part]) == 0
        assert run(["check"]) == 0
        assert run(["lint"]) == 0
    tests = {path.name for path in Path("tests").iterdir()}
    assert len(tests) == 2 + len(PARTS)
    check_it_is_whole(project, project / "generated")


@pytest.mark.nightly
@pytest.mark.slow
def test_the_reference_pipeline_is_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    project = started(monkeypatch, "--from", "rh3")
    assert run(["check"]) == 0
    assert run(["lint"]) == 0
    check_it_is_whole(project, project / "generated")


@pytest.mark.nightly
@pytest.mark.slow
def test_a_back_end_is_whole_and_works_once_installed(
    work: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(["new", "backend", "struct-list"]) == 0
    project = work / "struct-list"
    check_it_is_whole(project, None)
    info = project / "src" / "struct_list-0.1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Name: struct-list\nVersion: 0.1.0\n")
    (info / "entry_points.txt").write_text(
        "[rtgen.backends]\nstruct_list = struct_list.backend:BACKEND\n"
    )
    monkeypatch.syspath_prepend(project / "src")
    monkeypatch.chdir(project / "example")
    assert [run(["generate"]), run(["check"]), run(["lint"])] == [0, 0, 0]
    made = Path("generated/struct_list.txt").read_text(encoding="utf-8")
    assert made == "* parts::Gear: 1\n"


def test_a_system_connects_ports_by_their_types(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    started(monkeypatch)
    assert run(["new", *PARTS["component"]]) == 0
    assert run(["new", *PARTS["system"]]) == 0
    capfd.readouterr()
    assert run(["inspect", "systems/bench.xml"]) == 0
    shown = capfd.readouterr().out
    assert "LeftArm0.state" in shown
    for line in (
        "LeftArm0.state_Scaler0.command",
        "Scaler0.state_LeftArm1.command",
    ):
        assert line in Path("systems/bench.xml").read_text(encoding="utf-8")
    assert "LeftArm1.state_" not in Path("systems/bench.xml").read_text("utf-8")


def test_a_system_has_the_kinds_of_its_components(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    started(monkeypatch)
    for name, activity in (("Gate", "EVENTDRIVEN"), ("Clock", "PERIODIC")):
        text = f'@rtc(activity="{activity}", rate=10.0) component {name} {{}};\n'
        Path(f"definitions/{name}.idl").write_text(text, encoding="utf-8")
    assert run(["new", "system", "gated", "Gate", "Clock"]) == 0
    text = Path("systems/gated.xml").read_text(encoding="utf-8")
    assert re.findall(r'rts:kind="(\w+)"', text) == ["EVENT_DRIVEN", "PERIODIC"]


UNITS = """\
#include "BasicDataType.idl"
@rtc(category="Units", vendor="me")
component Gauge {
    @unit("mm") publishes RTC::TimedDouble scaled;
    @unit("m") publishes RTC::TimedDouble way;
    @unit("N*m") publishes RTC::TimedDouble torque;
};
@rtc(category="Units", vendor="me")
component Sink {
    @unit("m") consumes RTC::TimedDouble same;
    @unit("N*mm") consumes RTC::TimedDouble other_scale;
    @unit("K") consumes RTC::TimedDouble nothing;
};
"""


def test_a_system_connects_what_the_judge_allows(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    started(monkeypatch)
    Path("definitions/units.idl").write_text(UNITS)
    capfd.readouterr()
    assert run(["new", "system", "bench", "Gauge", "Sink"]) == 0
    said = capfd.readouterr().err
    text = Path("systems/bench.xml").read_text(encoding="utf-8")
    assert "Gauge0.way_Sink0.same" in text
    assert "Gauge0.torque_Sink0.other_scale" in text
    assert "Sink0.nothing" not in text.partition("<rts:DataPortConnectors")[2]
    assert "Gauge0.scaled would fit, too" in said
    assert "(RTC0595)" in said
    assert "(RTC0593)" in said
    assert run(["inspect", "systems/bench.xml", "definitions"]) == 0


def test_a_system_has_the_components_of_a_board(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    started(monkeypatch)
    assert run(["new", *PARTS["board"]]) == 0
    board = ["LampClient", "LampMarshaller"]
    for system, components in (
        ("board", [*board, "OpaqueRpcCommunication"]),
        ("others", []),
    ):
        assert run(["new", "system", system, *components]) == 0
    text = Path("systems/board.xml").read_text(encoding="utf-8")
    assert re.findall(r'rts:connectorId="([^"]*)"', text) == [
        f"{board[0]}0.lamp_{board[1]}0.lamp",
        f"{board[1]}0.communication_OpaqueRpcCommunication0.service",
    ]
    assert board[0] not in Path("systems/others.xml").read_text(encoding="utf-8")
    assert [run(["check"]), run(["run", "systems/board.xml", "--until", "1"])] == [0, 0]


USER = """\
#include "{proxy}"
#include "CanopenManager.idl"
component User {{
    consumes {module}::Tpdo1 tpdo1;
    publishes {module}::Rpdo1 rpdo1;
    uses CANopen::ObjectDictionary objects;
}};
"""


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "components",
    [
        ("WheelProxy", "User", "WheelDevice"),
        ("WheelDevice", "WheelProxy", "User"),
        ("WheelProxy", "WheelDevice", "User", "WheelProxy"),
    ],
)
def test_no_port_is_connected_to_a_device(
    components: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    project = started(monkeypatch)
    assert run(["new", "device", "wheel"]) == 0
    text = USER.format(proxy="Wheel.idl", module="Wheel")
    (project / "definitions" / "user.idl").write_text(text)
    capfd.readouterr()
    assert run(["new", "system", "bench", *components]) == 0
    err = capfd.readouterr().err
    system = Path("systems/bench.xml").read_text("utf-8")
    connections = re.findall(r'connectorId="([^"]*)"', system)
    assert "WheelProxy0.tpdo1_User0.tpdo1" in connections
    assert not any("Device" in name for name in connections)
    ambiguous = "User0.objects is connected to WheelProxy0.sdo, the nearest"
    assert (ambiguous in err) == (components.count("WheelProxy") > 1)


@pytest.mark.parametrize(
    ("arguments", "japanese", "english"),
    [
        (["project", "mine"], "| フォルダ |", "| folder |"),
        (["project", "mine", "--from", "rh3"], "# RH3 の走行\n", "# RH3 drives\n"),
        (["backend", "mine"], "バックエンド", "A back end of rtgen"),
    ],
    ids=["project", "reference", "backend"],
)
def test_a_readme_is_in_the_language(
    arguments: list[str], japanese: str, english: str
) -> None:
    for language, text in (("ja", japanese), ("en", english)):
        assert run(["--language", language, "new", *arguments]) == 0
        assert text in Path("mine/README.md").read_text("utf-8")
        shutil.rmtree("mine")


@pytest.mark.parametrize(
    "english",
    sorted(TEMPLATES.glob("*/README.md.j2")),
    ids=lambda each: each.parent.name,
)
def test_the_japanese_readme_has_the_commands_and_names_of_the_english_one(
    english: Path,
) -> None:
    japanese, expected = (
        re.sub(r"(?m) +#.*$", "", file.read_text("utf-8"))
        for file in (english.with_name("README.ja.md.j2"), english)
    )
    for form in (r"(?m)^\$ .*$", r"`[^`\n]+`", r"\{[{%].*?[%}]\}"):
        assert sorted(re.findall(form, japanese)) == sorted(re.findall(form, expected))


def test_the_same_name_gives_the_same_files(
    work: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = files_of(started(monkeypatch))
    other = work / "other"
    other.mkdir()
    monkeypatch.chdir(other)
    assert files_of(started(monkeypatch)) == first


@pytest.mark.parametrize("part", PARTS)
def test_nothing_is_overwritten(
    part: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    project = started(monkeypatch)
    assert run(["new", *PARTS["component"]]) == 0
    name = PARTS[part][1].lower()
    test = project / "tests" / f"test_{'left_arm' if part == 'component' else name}.py"
    test.write_text("# mine\n")
    before = files_of(project)
    assert run(["new", *PARTS[part]]) == 2
    assert "NEW0002" in capfd.readouterr().err
    assert files_of(project) == before


def test_a_folder_that_exists_is_left_alone(
    work: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (work / "my-robot").mkdir()
    (work / "my-robot" / "mine").write_text("x")
    assert run(["new", "project", "my-robot"]) == 2
    assert "NEW0002" in capfd.readouterr().err
    assert files_of(work) == {"my-robot/mine": b"x"}


@pytest.mark.sampled(1)
@pytest.mark.parametrize("part", ["component", "device", "board"])
def test_nothing_is_added_to_definitions_with_errors(
    part: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    project = started(monkeypatch)
    (project / "definitions" / "broken.idl").write_text("struct S { lon a; };\n")
    before = files_of(project)
    assert run(["new", *PARTS[part]]) == 2
    assert "IDL0200" in capfd.readouterr().err
    assert files_of(project) == before


@pytest.mark.parametrize("part", ["project", "component"])
def test_a_disk_that_fails_leaves_nothing(
    part: str,
    work: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    def fail(*arguments: object) -> None:
        raise OSError(28, "No space left on device", "generated")

    if part == "component":
        started(monkeypatch)
    before = files_of(work)
    monkeypatch.setattr(output, "_write_whole", lambda *a, **k: fail())
    assert run(["new", part, "other"]) == 3
    assert "No space left" in capfd.readouterr().err
    assert {k: v for k, v in files_of(work).items() if "generated" not in k} == {
        k: v for k, v in before.items() if "generated" not in k
    }


@pytest.mark.parametrize(
    "name",
    [
        "",
        "2fast",
        "a b",
        "../up",
        "a/b",
        "Grün",
        "a__b",
        "-x",
        "x-",
        "interface",
        "Class",
        "json",
        "rtgen",
        "canopen",
        "ValueError",
        "a" * 65,
        "x\n",
        "{{ 1 }}",
        ".rover",
        "acme.",
        "acme..rover",
        "json.rover",
        "acme.class",
        "msgspec",
        "click",
        "con",
        "Nul",
        "AUX",
        "com1",
        "acme.prn",
    ],
)
def test_names_that_something_cannot_have_are_refused(
    name: str, work: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["new", "project", "--", name]) == 2
    assert "NEW0001" in capfd.readouterr().err
    assert files_of(work) == {}


@pytest.mark.parametrize("name", ["system", "LifeCycleState", "timed_double"])
def test_a_component_that_its_test_would_hide_is_refused(
    name: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    project = started(monkeypatch)
    before = files_of(project)
    assert run(["new", "component", name]) == 2
    printed = capfd.readouterr().err
    assert f"NEW0001]: {name!r} is a class that the new test imports" in printed
    assert "hint: choose another name" in printed
    assert files_of(project) == before


@pytest.mark.parametrize(
    ("given", "type_", "module"),
    [
        ("Arm", "Arm", "arm"),
        ("left_arm", "LeftArm", "left_arm"),
        ("my-robot", "MyRobot", "my_robot"),
        ("RefHardRh3", "RefHardRh3", "ref_hard_rh3"),
    ],
)
def test_forms_of_a_name(given: str, type_: str, module: str) -> None:
    assert names.names(given) == names.Names(given, type_, module)


def test_the_first_component_has_a_name_like_any() -> None:
    assert names.names(starters.FIRST).type == starters.FIRST
