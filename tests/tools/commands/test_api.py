"""rtgen as a Python library: models and findings as values, files in memory."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rtgen import api
from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.diagnostics import InputError, Severity
from rtgen.compiler.lint import lint
from rtgen.compiler.model import Model, Struct

POSE = "module Geo { struct Pose { double x; double y; }; };"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_text_gives_a_model() -> None:
    [struct] = api.compile(POSE).declarations
    assert isinstance(struct, Struct)
    assert struct.scoped == "Geo::Pose"
    assert [m.name for m in struct.members] == ["x", "y"]
    assert struct.file == "text.idl"


def test_mistakes_are_values() -> None:
    result = api.read("struct Pose { doubl x; };")
    [finding] = result.diagnostics
    assert (finding.code, finding.severity) == ("IDL0200", Severity.ERROR)
    assert finding.span is not None
    assert (finding.span.file, finding.span.line, finding.span.column) == (
        *("text.idl", 1, 15),
    )
    assert result.sources == {"text.idl": "struct Pose { doubl x; };"}
    with pytest.raises(InputError) as caught:
        api.compile("struct Pose { doubl x; };")
    assert caught.value.diagnostics == result.diagnostics


def test_a_text_includes_standard_files_and_those_of_folders(folder: Path) -> None:
    (folder / "inc").mkdir()
    (folder / "inc" / "part.idl").write_text("struct Part { long a; };")
    text = '#include "part.idl"\n#include "BasicDataType.idl"\n'
    text += "struct S { Part p; RTC::Time t; N n; };"
    model = api.compile(text, include=[folder / "inc"], define={"N": "long"})
    assert model.declarations[-1].scoped == "S"


def test_paths_of_any_language(folder: Path) -> None:
    (folder / "a.idl").write_text(POSE)
    (folder / "b.cdl").write_text("signature sOne { void f( void ); };")
    (folder / "rtgen.toml").write_text('[sources]\npaths = ["no.idl"]\n')
    with pytest.raises(InputError):  # the path of rtgen.toml does not exist
        api.compile(folder / "a.idl")
    (folder / "rtgen.toml").unlink()
    assert api.compile(folder / "a.idl").declarations[0].scoped == "Geo::Pose"
    both = api.compile([folder / "a.idl", str(folder / "b.cdl")])
    assert len(both.declarations) == 1
    assert len(both.tecs) == 1
    assert api.compile(folder) == both
    assert api.compile([]) == Model()
    [finding] = api.read(folder / "missing.idl").diagnostics
    assert finding.severity is Severity.ERROR
    with pytest.raises(InputError):
        api.read(folder / "b.txt")


def test_back_ends_are_called_by_name(folder: Path) -> None:
    model = api.compile(POSE)
    made = {a.path: a.text for a in api.emit(model, "types").artifacts}
    assert "\nclass Pose" in made["robots/_idl/text.py"]
    options = Options("fleet", "", "1.0")
    everything = api.emit(model, options=options)
    assert {*everything.artifacts} >= {
        *api.emit(model, "types", options=options).artifacts
    }
    assert not [*folder.iterdir()]
    with pytest.raises(
        ValueError, match="no back end is called 'typos'; there are: types"
    ):
        api.emit(model, "typos")


class Names:
    """A back end of a script."""

    name = "names"

    def emit(self, model: Model, options: Options) -> Emission:
        return Emission([Artifact("n.txt", model.declarations[0].scoped, ())])


def test_a_back_end_of_ones_own_is_called_as_an_object() -> None:
    [artifact] = api.emit(api.compile(POSE), Names()).artifacts
    assert artifact.text == "Geo::Pose"


def test_lint_is_a_function_of_what_was_read() -> None:
    result = api.read("typedef long Unused;")
    assert [d.code for d in lint(result.model, result.sources)] == ["LINT0002"]


def test_importing_the_runtime_imports_no_compiler() -> None:
    code = "import rtgen.runtime, sys; print('rtgen.compiler' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == "False\n"
