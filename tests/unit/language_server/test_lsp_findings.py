"""Findings of unsaved texts: those of `rtgen lint` for the same texts on the disk."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from editor import SETTINGS, Editor
from projects import PROJECT

from rtgen.cli import run
from rtgen.diagnostics import Diagnostic, Severity
from rtgen.diagnostics.report import as_json

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
        editor.open("types_idl")
        found = as_shown(editor.findings("types_idl"))
    assert found == linted(capsys)


def test_a_fault_shows_in_the_files_that_include_it(editor: Editor) -> None:
    editor.open("drawing_idl")
    editor.open("types_idl", PROJECT["types_idl"].replace("> Points;", "> Places;"))
    found = editor.findings("types_idl")
    assert errors(found["drawing.idl"]) == ["IDL0200"]
    editor.open("types_idl", PROJECT["types_idl"])
    assert errors(editor.findings("types_idl")["drawing.idl"]) == []


def test_a_closed_document_counts_as_saved(editor: Editor) -> None:
    editor.open("types_idl", "struct {")
    assert errors(editor.findings("types_idl")["types.idl"])
    editor.workspace.documents.close(editor.view("types_idl").document.uri)
    editor.open("drawing_idl")
    assert errors(editor.findings("drawing_idl").get("types.idl", [])) == []


def test_a_file_beside_the_project(editor: Editor) -> None:
    path = editor.folder / "aside_x.idl"
    path.write_text("struct Aside { long first; Missing second; };\n")
    uri = path.as_uri()
    editor.workspace.documents.open(uri, 1, path.read_text())
    key = editor.workspace.key_of(str(path))
    found = editor.workspace.analyse(key)
    assert errors(found[str(path)]) == ["IDL0200"]


def test_faulty_settings_leave_what_was_known(editor: Editor) -> None:
    editor.open("types_idl")
    view = editor.open("rtgen_toml", "[sources\n")
    assert view.analysis is not None
    found = editor.findings("rtgen_toml")
    assert [d.severity for d in found["rtgen.toml"]] == [Severity.ERROR]
    assert editor.view("types_idl").file is not None
    editor.open("rtgen_toml", SETTINGS)
    assert editor.findings("rtgen_toml")["rtgen.toml"] == []


def test_findings_of_a_system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    editor = Editor(tmp_path, **PROJECT)
    editor.open(
        "system_xml", PROJECT["system_xml"].replace("painter1.where", "painter1.here")
    )
    found = editor.findings("system_xml")["system.xml"]
    assert errors(found) == ["RTC0581"], found
