"""`rtgen: ignore[CODE]` in comments, and `[lint] per-file-ignores`."""

from pathlib import Path

import pytest

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.model import Struct


def lint(text: str, capsys: pytest.CaptureFixture[str], name: str = "a.idl") -> str:
    Path(name).write_text(text)
    capsys.readouterr()
    run(["lint", name, "--ignore", "LINT0006"])
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("struct A { long n;; }; // rtgen: ignore[IDL0110]\n", []),
        ("struct A { long n;; }; /* rtgen: ignore[ IDL0110 ] reason */\n", []),
        ("// rtgen: ignore[idl0110]\nstruct A { long n;; };\n", []),
        ("// rtgen: ignore[IDL0110]\n\nstruct A { long n;; };\n", []),
        (
            "// rtgen: ignore[IDL0110]\n// rtgen: ignore[LINT0002]\ntypedef long A;;\n",
            [],
        ),
        ("// rtgen: ignore[IDL0110, LINT0002]\ntypedef long A;;\n", []),
        ("// rtgen: ignore[IDL0110]\nstruct A {\n long n;; };\n", ["IDL0110", "LINT0015"]),
        ("# rtgen: ignore[IDL0110]\nstruct A { long n;; };\n", ["IDL0110"]),
        ("struct A { Unknown n;; }; // rtgen: ignore[IDL0200, IDL0110]\n", ["IDL0200"]),
        ("struct A { long n; }; // rtgen: ignore[LINT0005]\n", []),
        ("struct A { long n; }; // rtgen: ignore[PY0002]\n", []),
        ("struct A { long n; }; // rtgen: ignore[NONE]\n", ["LINT0015"]),
    ],
)  # fmt: skip
def test_comments(
    text: str,
    codes: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    shown = lint(text, capsys)
    found = ["IDL0110", "IDL0200", "LINT0002", "LINT0005", "LINT0015"]
    assert [code for code in found if f"[{code}]" in shown] == codes


def test_they_document_nothing() -> None:
    text = (
        "/// A doc.\n// rtgen: ignore[IDL0110] why\nstruct A {\n"
        "    long n; // rtgen: ignore[IDL0110]\n    long m;\n};\n"
    )
    [struct] = api.compile(text).declarations
    assert isinstance(struct, Struct)
    assert (struct.doc, [m.doc for m in struct.members]) == ("A doc.", ["", ""])


def test_other_languages(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "signature sA { void f(); }; // rtgen: ignore[CDL0404]\n"
    assert "CDL0404" not in lint(text, capsys, "a.cdl")
    text = "[DeviceInfo]\n; rtgen: ignore[EDS0110]\nVendorName: Acme\n"
    assert "EDS0110" not in lint(text, capsys, "a.eds")
    assert "EDS0110" in lint(text.replace("; ", "# "), capsys, "a.eds")


def test_patterns_of_files(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("specs").mkdir()
    Path("specs/old.idl").write_text("struct A { long n;; };\n")
    Path("specs/new.idl").write_text("struct B { long n;; };\n")
    settings = (
        '[sources]\npaths = ["specs"]\n\n[lint.per-file-ignores]\n'
        '"specs/old*.idl" = ["IDL0110", "LINT0001"]\n'
    )
    Path("rtgen.toml").write_text(settings)
    assert run(["lint"]) == 1
    shown = capsys.readouterr().err
    assert "specs/new.idl:1:19: warning[IDL0110]" in shown
    assert "specs/old.idl:1:19: warning[IDL0110]" not in shown
    assert "warning[LINT0015]: no finding of LINT0001 is suppressed here" in shown
    Path("rtgen.toml").write_text(settings.replace("LINT0001", "LINT9999"))
    assert run(["lint"]) == 2
    assert "no rule has the code 'LINT9999'" in capsys.readouterr().err
    Path("rtgen.toml").write_text('[lint]\nper-file-ignores = { "*" = "IDL0110" }\n')
    assert run(["lint"]) == 2
    assert "must be a table of patterns" in capsys.readouterr().err


def test_fixes_in_documents(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct A { long n;; };\n")
    run(["lint", "a.idl", "--diagnostics", "json"])
    shown = " ".join(capsys.readouterr().err.split())
    assert '"fix": { "title": "remove the \';\'"' in shown
    run(["lint", "a.idl", "--diagnostics", "sarif"])
    shown = " ".join(capsys.readouterr().err.split())
    assert '"insertedContent": { "text": "" }' in shown
