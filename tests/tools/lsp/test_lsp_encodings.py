"""Documents in other encodings and with other line ends: findings, names and places."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from editor import Editor
from lsprotocol.types import Position

from rtgen.cli import run
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.diagnostics.report import as_json
from rtgen.tools.lsp.features.definition import definition

TEXT = """\
// 位置の表
module Lab {
  struct Pose {
    double x;   // X座標の十
    double y;   /* 角度 */ double a;
  };
  struct Path { Pose 始; sequence<Pose> all; };
};
""".replace("始", "first")
ENCODINGS = ["utf-8", "utf-8-sig", "cp932", "euc_jp", "utf-16"]


def shown(findings: dict[str, list[Diagnostic]]) -> list[str]:
    return sorted(json.dumps(as_json(f)) for each in findings.values() for f in each)


@pytest.fixture
def editor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Editor:
    monkeypatch.chdir(tmp_path)
    return Editor(tmp_path)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_findings_are_those_of_lint(
    editor: Editor, encoding: str, end: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The octets of the file count, whatever an editor makes of them."""
    path = editor.path("lab_idl")
    path.write_bytes(TEXT.replace("\n", end).encode(encoding))
    editor.open("lab_idl", TEXT.replace("\n", end))
    found = shown(editor.findings("lab_idl"))
    run(["lint", "--diagnostics", "json"])
    linted = sorted(map(json.dumps, json.loads(capsys.readouterr().err)))
    ignored = ("TXT0001", "TXT0004")
    assert [f for f in found if not any(code in f for code in ignored)] == [
        f for f in linted if not any(code in f for code in ignored)
    ]
    assert any("TXT0002" in f for f in found) == (encoding == "cp932")


@pytest.mark.sampled(8)
@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_places_are_those_of_the_document(
    editor: Editor, encoding: str, end: str, mark: str
) -> None:
    text = TEXT.replace("\n", end)
    editor.path("lab_idl").write_bytes(text.encode(encoding))
    view = editor.open("lab_idl", mark + text)
    [place] = definition(view, editor.at(view, "sequence<Po^se>"))
    assert editor.shown(place) == "lab.idl:3 Pose"
    view = editor.edit("lab_idl", f"^^// 位置の表{end}", f"// 速度の予定{end}")
    [place] = definition(view, editor.at(view, "sequence<Po^se>"))
    assert editor.shown(place) == "lab.idl:4 Pose"
    view = editor.analysed("lab_idl")
    [place] = definition(view, editor.at(view, "sequence<Po^se>"))
    assert editor.shown(place) == "lab.idl:4 Pose"
    assert place.range.start == Position(3, 9)


@pytest.mark.parametrize("encoding", ["cp932", "euc_jp"])
def test_files_that_are_not_open(editor: Editor, encoding: str) -> None:
    editor.path("lab_idl").write_bytes(TEXT.encode(encoding))
    editor.path("use_idl").write_text(
        '#include "lab.idl"\nstruct Use { Lab::Pose pose; };\n'
    )
    view = editor.open("use_idl")
    [place] = definition(view, editor.at(view, "Lab::Po^se"))
    assert editor.shown(place) == "lab.idl:3 Pose"


def test_an_unsaved_text_is_what_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`[sources] encoding` is that of files, not of the editor's texts."""
    monkeypatch.chdir(tmp_path)
    settings = '[sources]\npaths = ["specs"]\nencoding = "sjis"\n'
    editor = Editor(tmp_path, settings)
    editor.path("a_idl").write_bytes("// 表.\nstruct A { long x; };\n".encode("cp932"))
    editor.open("a_idl", "/** 角 */\nstruct A { long x; };\n")
    assert shown(editor.findings("a_idl")) == []
    [struct] = editor.view("a_idl").analysis.model.declarations  # type: ignore[union-attr]
    assert struct.doc == "角"
