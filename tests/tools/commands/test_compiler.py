"""The pipeline of front ends and back ends, and the effects of plug-ins."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import pytest
from small_pipeline import Pipeline

from rtgen.compiler import compilation
from rtgen.compiler.backends import Artifact, Emission, Options, stage
from rtgen.compiler.diagnostics import Diagnostic, Severity, ToolError
from rtgen.compiler.kit import plugins
from rtgen.compiler.model import Model
from rtgen.compiler.project import Project, load, with_arguments


@dataclass
class Plugin:
    """A back end with one artifact and one finding."""

    severity: Severity
    name: str = "plugin"

    def emit(self, model: Model, options: Options) -> Emission:
        finding = Diagnostic("XXX0001", self.severity, "from the plug-in")
        return Emission(
            [Artifact("plugin.txt", options.package, ("a.idl",))], [finding]
        )


def project() -> Project:
    return with_arguments(load(), paths=["a.idl", "b.idl"])


def test_artifacts_come_from_all_back_ends_in_order(pipeline: Pipeline) -> None:
    pipeline.backends.append(Plugin(Severity.WARNING))
    run = compilation.compile_project(project())
    paths = [a.path for a in run.artifacts]
    assert paths == ["robots/a.idl.txt", "robots/b.idl.txt", "plugin.txt"]
    assert list(run.inputs) == ["a.idl", "b.idl"]
    assert [d.code for d in run.diagnostics] == ["XXX0001"]
    assert all(Path(path).is_absolute() for path in run.dependencies)


def test_an_error_of_a_back_end_leaves_no_artifacts(pipeline: Pipeline) -> None:
    pipeline.backends.append(Plugin(Severity.ERROR))
    run = compilation.compile_project(project())
    assert run.failed
    assert run.artifacts == ()


def test_back_ends_are_not_asked_after_errors(pipeline: Pipeline) -> None:
    Path("a.idl").write_text("error")
    pipeline.backends.append(Plugin(Severity.ERROR))
    assert [d.code for d in compilation.compile_project(project()).diagnostics] == [
        "IDL0999"
    ]


def test_plug_ins_follow_the_built_in_ones(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "rtgen_some_plugin.py").write_text(
        "class BACKEND:\n    name = 'the back end'\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    entry = metadata.EntryPoint(
        "x", "rtgen_some_plugin:BACKEND", plugins.Group.BACKENDS
    )
    monkeypatch.setattr(plugins, "announced", lambda *_: (entry,))
    names = [backend.name for backend in stage.backends()]
    assert names[-1] == "the back end"
    assert len(names) == len(stage.BUILT_IN) + 1


def test_a_broken_plug_in_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = metadata.EntryPoint(
        "broken", "rtgen_no_such_module:X", plugins.Group.BACKENDS
    )
    monkeypatch.setattr(plugins, "announced", lambda *_: (entry,))
    monkeypatch.setattr(stage, "BUILT_IN", ())
    with pytest.raises(ToolError, match="broken"):
        list(stage.backends())


STANDARD = """\
#include "BasicDataType.idl"

struct Reading { RTC::Time tm; double value; };
"""


def test_types_of_openrtm_can_be_included_without_having_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("reading.idl").write_text(STANDARD)
    model = compilation.read(with_arguments(load(), paths=["reading.idl"]))
    assert not model.diagnostics
    assert [file.key for file in model.model.files] == [
        "rtgen/idl/BasicDataType.idl",
        "reading.idl",
    ]
    shipped = [d.path for d in model.dependencies if d.path.name == "BasicDataType.idl"]
    assert shipped[-1].is_file()


def test_a_file_of_ones_own_goes_before_that_of_openrtm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("reading.idl").write_text(STANDARD)
    Path("own").mkdir()
    Path("own/BasicDataType.idl").write_text(
        "module RTC { struct Time { long long ns; }; };"
    )
    for options in (
        {"paths": ["reading.idl"], "include": ["own"]},
        {"paths": ["reading.idl", "own/BasicDataType.idl"]},
    ):
        found = compilation.read(with_arguments(load(), **options))
        assert not found.diagnostics
        assert sorted(file.key for file in found.model.files) == [
            "own/BasicDataType.idl",
            "reading.idl",
        ]
