"""Files in IDL by their suffixes."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.facts.idl_files import IDL_SUFFIXES

SUFFIXES = sorted({*IDL_SUFFIXES, *(each.upper() for each in IDL_SUFFIXES)})
TEXT = "struct Sample {\n    long value; // rtgen: ignore[LINT0002]\n};\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_each_command_reads_them(
    suffix: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = f"a{suffix}"
    Path(name).write_text(TEXT)
    for path in (name, "."):
        assert run(["inspect", path]) == 0
        assert "struct Sample" in capsys.readouterr().out
    assert run(["fmt", "--check", name]) == 0
    assert run(["lint", name]) == 1
    assert f"{name}:2:34: warning[LINT0015]" in capsys.readouterr().err
    assert run(["generate", "-q", name]) == 0
    assert run(["check", name]) == 0
    assert "class Sample" in next(Path("generated").rglob("_idl/a.py")).read_text()
    shutil.rmtree("generated")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("named", [True, False])
def test_profiles_find_them(
    suffix: str, named: bool, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    definition = "component Part { consumes mine::Sample taken; };"
    Path("types.idl").write_text(f"module mine {{ {TEXT} }};")
    Path("a.idl").write_text(f'#include "types.idl"\n{definition}\n')
    assert run(["convert", "a.idl", "--to", "rtc-xml"]) == 0
    profile = capsys.readouterr().out
    Path("types.idl").rename(f"other{suffix}")
    Path("a.idl").unlink()
    file = f"other{suffix}" if named else ""
    Path("Part.xml").write_text(profile.replace("types.idl", file))
    assert run(["check", "Part.xml"]) == 1
    assert "RTC0537" not in capsys.readouterr().err
