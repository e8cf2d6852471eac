"""CDL files as sources of a project: beside IDL, with their settings, in cache and manifest."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from rtgen.compiler.compilation import read
from rtgen.compiler.project import Project, cache, load, with_arguments
from rtgen.tools.compiling.cached import build, inspect


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("TECSPATH", raising=False)
    Path("a.idl").write_text("struct A { long x; };\n")
    Path("b.cdl").write_text('import_C( "t.h" ); signature s { ER f( [in] T a ); };\n')
    Path("t.h").write_text("typedef int T; typedef int ER;\n")


def _project() -> Project:
    return with_arguments(load(), paths=["a.idl", "b.cdl"])


def test_both_languages_are_read_into_one_model() -> None:
    result = read(_project())
    assert result.diagnostics == ()
    assert [d.name for d in result.model.declarations] == [("A",)]
    assert [unit.file for unit in result.model.tecs] == ["b.cdl"]
    assert {file.key for file in result.model.files} == {"a.idl", "b.cdl", "t.h"}
    assert {d.path.name for d in result.dependencies} >= {"a.idl", "b.cdl", "t.h"}


def test_a_header_is_an_input() -> None:
    run = build(_project(), cache.default())
    assert set(run.inputs) == {"a.idl", "b.cdl", "t.h"}
    first = inspect(_project(), (), cache.default(), as_json=True).artifacts
    Path("t.h").write_text("typedef int T; typedef int ER; enum e { A };\n")
    second = inspect(_project(), (), cache.default(), as_json=True).artifacts
    assert first != second


@pytest.mark.parametrize("key", ["encoding", "kcode"])
def test_prelude_and_encoding_come_from_the_project_file_and_the_command_line(
    key: str,
) -> None:
    Path("b.cdl").write_bytes(
        "// 能力\nsignature s { ER f( void ); };\n".encode("cp932")
    )
    assert [d.code for d in read(_project()).diagnostics] == ["CDL0009"]
    Path("rtgen.toml").write_text(f'[sources]\nprelude = "none"\n{key} = "euc"\n')
    codes = {d.code for d in read(_project()).diagnostics}
    assert codes == {"CDL0005", "CDL0300"}
    changed = with_arguments(load(), paths=["b.cdl"], prelude="kernel", encoding="sjis")
    assert [d.code for d in read(changed).diagnostics] == ["CDL0009"]
    keys = {
        cache.default().key(replace(changed, encoding=k), ()) for k in ("sjis", "euc")
    }
    assert len(keys) == 2


def test_imports_are_looked_for_in_tecspath(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("b.cdl").write_text("import( <x.cdl> ); const int32_t N = X;\n")
    Path("tecs/posix").mkdir(parents=True)
    Path("tecs/posix/x.cdl").write_text("const int32_t X = 1;\n")
    assert [d.code for d in read(_project()).diagnostics] == ["CDL0006", "CDL0804"]
    monkeypatch.setenv("TECSPATH", "tecs")
    assert read(_project()).diagnostics == ()
