"""rtgen as a Python library: models and findings as values, files in memory."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import rtgen
from rtgen.backends import Artifact, Emission, Options
from rtgen.diagnostics import InputError, Severity
from rtgen.lint import lint
from rtgen.model import Model, Struct

POSE = "module Geo { struct Pose { double x; double y; }; };"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_text_gives_a_model() -> None:
    [struct] = rtgen.compile(POSE).declarations
    assert isinstance(struct, Struct)
    assert struct.scoped == "Geo::Pose"
    assert [m.name for m in struct.members] == ["x", "y"]
    assert struct.file == "text.idl"


def test_mistakes_are_values() -> None:
    result = rtgen.read("struct Pose { doubl x; };")
    [finding] = result.diagnostics
    assert (finding.code, finding.severity) == ("IDL0200", Severity.ERROR)
    assert finding.span is not None
    assert (finding.span.file, finding.span.line, finding.span.column) == (
        *("text.idl", 1, 15),
    )
    assert result.sources == {"text.idl": "struct Pose { doubl x; };"}
    with pytest.raises(InputError) as caught:
        rtgen.compile("struct Pose { doubl x; };")
    assert caught.value.diagnostics == result.diagnostics


def test_a_text_includes_standard_files_and_those_of_folders(folder: Path) -> None:
    (folder / "inc").mkdir()
    (folder / "inc" / "part.idl").write_text("struct Part { long a; };")
    text = '#include "part.idl"\n#include "BasicDataType.idl"\n'
    text += "struct S { Part p; RTC::Time t; N n; };"
    model = rtgen.compile(text, include=[folder / "inc"], define={"N": "long"})
    assert model.declarations[-1].scoped == "S"


def test_paths_of_any_language(folder: Path) -> None:
    (folder / "a.idl").write_text(POSE)
    (folder / "b.cdl").write_text("signature sOne { void f( void ); };")
    (folder / "rtgen.toml").write_text('[sources]\npaths = ["no.idl"]\n')
    with pytest.raises(InputError):  # the path of rtgen.toml does not exist
        rtgen.compile(folder / "a.idl")
    (folder / "rtgen.toml").unlink()
    assert rtgen.compile(folder / "a.idl").declarations[0].scoped == "Geo::Pose"
    both = rtgen.compile([folder / "a.idl", str(folder / "b.cdl")])
    assert len(both.declarations) == 1
    assert len(both.tecs) == 1
    assert rtgen.compile(folder) == both
    assert rtgen.compile([]) == Model()
    [finding] = rtgen.read(folder / "missing.idl").diagnostics
    assert finding.severity is Severity.ERROR
    with pytest.raises(InputError):
        rtgen.read(folder / "b.txt")


def test_back_ends_are_called_by_name(folder: Path) -> None:
    model = rtgen.compile(POSE)
    made = {a.path: a.text for a in rtgen.emit(model, "types").artifacts}
    assert "\nclass Pose" in made["robots/_idl/text.py"]
    options = Options("fleet", "", "1.0")
    everything = rtgen.emit(model, options=options)
    assert {*everything.artifacts} >= {
        *rtgen.emit(model, "types", options=options).artifacts
    }
    assert not [*folder.iterdir()]
    with pytest.raises(
        ValueError, match="no back end is called 'typos'; there are: types"
    ):
        rtgen.emit(model, "typos")


class Names:
    """A back end of a script."""

    name = "names"

    def emit(self, model: Model, options: Options) -> Emission:
        return Emission([Artifact("n.txt", model.declarations[0].scoped, ())])


def test_a_back_end_of_ones_own_is_called_as_an_object() -> None:
    [artifact] = rtgen.emit(rtgen.compile(POSE), Names()).artifacts
    assert artifact.text == "Geo::Pose"


def test_lint_is_a_function_of_what_was_read() -> None:
    result = rtgen.read("typedef long Unused;")
    assert [d.code for d in lint(result.model, result.sources)] == ["LINT0002"]


def test_importing_rtgen_imports_no_compiler() -> None:
    code = "import rtgen, sys; print('rtgen.compiler' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == "False\n"
    with pytest.raises(AttributeError, match="no attribute 'compiled'"):
        rtgen.compiled  # type: ignore[attr-defined]  # noqa: B018
