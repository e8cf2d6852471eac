"""Findings of unsaved texts equal those of `rtgen lint` for the same texts on disk."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from editor import SETTINGS, Editor
from projects import PROJECT

from rtgen.cli import run
from rtgen.compiler.diagnostics import Diagnostic, Severity
from rtgen.compiler.diagnostics.report import as_json

FAULTS = {
    "types_idl": ("double y;", "double y; long x;"),
    "drawing_idl": ("Shapes::Points points", "Shapes::Pointz points"),
    "board_cdl": ("Motor.eMotor", "Motor.eNone"),
    "drive_eds": ("AccessType=rw\nDefaultValue=100", "AccessType=no\nDefaultValue=100"),
    "bus_toml": ('device = "wheel"', 'device = "wheal"'),
    "rtgen_toml": ("include =", "inclode ="),
}


@pytest.fixture
def editor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Editor:
    monkeypatch.chdir(tmp_path)
    files = {name: text for name, text in PROJECT.items() if name != "system_xml"}
    return Editor(tmp_path, **files)


def as_shown(findings: dict[str, list[Diagnostic]]) -> list[dict[str, object]]:
    return sorted(
        (as_json(f) for found in findings.values() for f in found), key=json.dumps
    )


def errors(findings: list[Diagnostic]) -> list[str]:
    return [d.code for d in findings if d.severity is Severity.ERROR]


def linted(capsys: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    capsys.readouterr()
    run(["lint", "--diagnostics", "json"])
    found = json.loads(capsys.readouterr().err)
    assert isinstance(found, list)
    return sorted(found, key=json.dumps)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", [*FAULTS, "none"])
def test_findings_are_those_of_lint(
    editor: Editor, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    if name != "none":
        path = editor.path(name)
        saved = path.read_text()
        faulty = saved.replace(*FAULTS[name])
        assert faulty != saved
        editor.open(name, faulty)
        found = as_shown(editor.findings(name))
        assert any(f["severity"] == Severity.ERROR for f in found)
        path.write_text(faulty)
    else:
        assert run(["generate", "-q"]) == 0  # rtgen lint does not miss skeletons
        editor.open("types_idl")
        found = as_shown(editor.findings("types_idl"))
    assert found == linted(capsys)


@pytest.mark.parametrize(("case", "expected"), [("strict", ["IDL0204"]), ("dds", [])])
def test_the_case_of_names_is_that_of_the_project(
    case: str, expected: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "struct Path { long n; };\nstruct Plan { Path path; };\n"
    settings = f'[sources]\npaths = ["."]\n[idl]\ncase = "{case}"\n'
    editor = Editor(tmp_path, rtgen_toml=settings, plan_idl=text)
    editor.open("plan_idl", text)
    found = editor.findings("plan_idl")
    assert [code for each in found.values() for code in errors(each)] == expected


def test_a_fault_shows_in_the_files_that_include_it(editor: Editor) -> None:
    editor.open("drawing_idl")
    editor.open("types_idl", PROJECT["types_idl"].replace("> Points;", "> Places;"))
    found = editor.findings("types_idl")
    assert errors(found["drawing.idl"]) == ["IDL0200"]
    editor.open("types_idl", PROJECT["types_idl"])
    assert errors(editor.findings("types_idl")["drawing.idl"]) == []


@pytest.mark.sampled(0)
def test_a_closed_document_counts_as_saved(editor: Editor) -> None:
    editor.open("types_idl", "struct {")
    assert errors(editor.findings("types_idl")["types.idl"])
    editor.workspace.documents.close(editor.view("types_idl").document.uri)
    editor.open("drawing_idl")
    assert errors(editor.findings("drawing_idl").get("types.idl", [])) == []


@pytest.mark.parametrize("end", [pytest.param("\n", marks=pytest.mark.nightly), "\r\n"])
def test_a_byte_order_mark_moves_no_finding(editor: Editor, end: str) -> None:
    text = (
        f"\ufeffstruct First {{ Missing a; }};{end}struct Second {{ Absent b; }};{end}"
    )
    view = editor.open("types_idl", text)
    found = editor.findings("types_idl")["types.idl"]
    spans = [d.span for d in found if d.code == "IDL0200"]
    places = [view.text.offsets(span) for span in spans if span is not None]
    assert [text[start:stop] for start, stop in places] == ["Missing", "Absent"]


def test_a_file_beside_the_project(editor: Editor) -> None:
    path = editor.folder / "aside_x.idl"
    path.write_text("struct Aside { long first; Missing second; };\n")
    uri = path.as_uri()
    editor.workspace.documents.open(uri, 1, path.read_text())
    key = editor.workspace.key_of(str(path))
    found = editor.workspace.analyse(key)
    assert errors(found[str(path)]) == ["IDL0200"]


def test_files_of_other_tools_are_left_alone(editor: Editor) -> None:
    for name, text in (
        ("pyproject.toml", "[project]\nname = 'x'\n"),
        ("ci.yml", "on: [push]\n"),
        ("notes.xml", "<notes/>\n"),
    ):
        path = editor.folder / name
        path.write_text(text)
        workspace = editor.workspace
        workspace.documents.open(path.as_uri(), 1, text)
        assert workspace.analyse(workspace.key_of(str(path))) == {str(path): []}
        assert workspace.view(path.as_uri()) is None
    workspace.documents.open(path.as_uri(), 2, PROJECT["system_xml"])
    assert workspace.view(path.as_uri()) is not None


def test_faulty_settings_leave_what_was_known(editor: Editor) -> None:
    editor.open("types_idl")
    view = editor.open("rtgen_toml", "[sources\n")
    assert view.analysis is not None
    found = editor.findings("rtgen_toml")
    assert [d.severity for d in found["rtgen.toml"]] == [Severity.ERROR]
    assert editor.view("types_idl").file is not None
    editor.open("rtgen_toml", SETTINGS)
    assert editor.findings("rtgen_toml")["rtgen.toml"] == []


def test_findings_of_back_ends(editor: Editor) -> None:
    def lines(found: list[Diagnostic]) -> list[int]:
        spans = [d.span for d in found if d.code == "NUM0001"]
        return [span.line for span in spans if span is not None]

    path = str(editor.path("types_idl"))
    faulty = '@numeric("list") octet quality'
    editor.open("types_idl", PROJECT["types_idl"].replace("octet quality", faulty))
    [line] = lines(editor.findings("types_idl")["types.idl"])
    # Until the back ends run again, the finding moves with the text.
    editor.edit("types_idl", "^^module Shapes", "// One more line.\n")
    key = editor.workspace.key_of(path)
    assert lines(editor.workspace.analyse(key)[path]) == [line + 1]
    assert editor.workspace.emit(key) is None
    editor.edit("types_idl", '^@numeric("list") ^octet', "")
    assert lines(editor.findings("types_idl")["types.idl"]) == []


def test_findings_of_behaviours(editor: Editor) -> None:
    folder = editor.folder / "src"
    folder.mkdir()
    (folder / "painter.py").write_text(
        "from robots.components.painter import PainterBase\n\n\n"
        "class Painter(PainterBase):\n"
        "    def on_execute(self) -> None:\n"
        "        return self.wherre.read()\n"
    )
    editor.open("types_idl")
    [found] = editor.findings("types_idl")["painter.py"]
    assert (found.hint or "").startswith("did you mean where?")


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("edited", "expected"),
    [
        ("types_idl", {"types.idl", "drawing.idl"}),
        ("drawing_idl", {"drawing.idl"}),
        ("board_cdl", {"board.cdl"}),
        ("drive_eds", {"drive.eds", "bus.toml"}),
        ("bus_toml", {"bus.toml", "drive.eds"}),
        ("rtgen_toml", set[str]()),
    ],
)
def test_an_edit_reads_what_depends_on_it(
    editor: Editor, edited: str, expected: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    editor.open("types_idl")
    text = editor.path(edited).read_text()
    comment = "//" if edited.endswith(("idl", "cdl")) else ";"
    comment = "#" if edited.endswith("toml") else comment
    read = set[str]()

    def file(name: str) -> None:
        read.add(Path(name).name)

    monkeypatch.setattr("rtgen.compiler.kit.stages.file", file)
    editor.workspace.documents.open(
        editor.path(edited).as_uri(), 1, f"{text}{comment} edited\n"
    )
    key = editor.workspace.key_of(str(editor.path("types_idl")))
    editor.workspace.analyse(key)
    assert {name for name in read if (editor.folder / "specs" / name).exists()} == (
        expected
    )


def test_findings_of_a_system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    editor = Editor(tmp_path, **PROJECT)
    editor.open(
        "system_xml", PROJECT["system_xml"].replace("painter1.where", "painter1.here")
    )
    found = editor.findings("system_xml")["system.xml"]
    assert errors(found) == ["RTC0581"], found
