"""Definitions in files of any name: each target generates files that their languages accept."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rtgen.cli import run

IDL = """#include "BasicDataType.idl"
#include "INCLUDED.idl"
module Named {
    struct Sample { RTC::Time tm; long x; Inner::Value y; };
    interface Lever { void turn(in Sample given); };
};
@rtc(category="Test", vendor="me")
component Reader {
    publishes Named::Sample sample;
    provides Named::Lever turned;
};
"""
CDL = """signature sLamp { int32_t dim( [in] int32_t percent ); };
celltype tLamp { entry sLamp eLamp; };
[active] celltype tSwitch { call sLamp cLamp; };
cell tLamp Lamp { };
cell tSwitch Switch { [through( RTCPlugin, "" )] cLamp = Lamp.eLamp; };
"""
EDS = Path(__file__).parents[3] / "specs" / "canopen" / "f_palette.eds"
NAMES = ("モータ", "\N{FULLWIDTH LATIN SMALL LETTER O}s²", "a'b\"$(x)")


@pytest.mark.sampled(2)
@pytest.mark.parametrize("target", ["embedded", "openrtm", "small", "typescript"])
@pytest.mark.parametrize("name", NAMES)
def test_names_of_definition_files(
    name: str, target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    included = f"{name}2".replace('"', "")
    Path("idl").mkdir()
    Path("idl", f"{name}.idl").write_text(IDL.replace("INCLUDED", included))
    Path("idl", f"{included}.idl").write_text(
        "module Inner { struct Value { long z; }; };"
    )
    if name.isidentifier():
        Path("idl", f"{name}3.cdl").write_text(CDL)
        shutil.copy(EDS, Path("idl", f"{name}4.eds"))
    Path("rtgen.toml").write_text(
        f'[sources]\npaths = ["idl"]\n[output]\ntarget = "{target}"\n'
    )
    assert run(["generate", "-q", "--no-cache"]) == 0
    assert run(["check", "-q"]) == 0
    made = [path for path in Path("generated").rglob("*") if path.is_file()]
    assert len(made) > 5
    for path in made:
        if path.suffix == ".py":
            ast.parse(path.read_text())
        elif path.suffix == ".xml":
            ElementTree.parse(path)
        elif path.suffix == ".sh":
            subprocess.run(["sh", "-n", path], check=True)
        elif path.suffix == ".idl":
            macros = re.findall(r"^#(?:ifndef|define) (.*)$", path.read_text(), re.M)
            assert all(re.fullmatch(r"[A-Za-z_]\w*", m, re.ASCII) for m in macros)


@pytest.mark.parametrize("command", ["generate", "check", "lint", "inspect", "docs"])
@pytest.mark.parametrize("suffix", [b".idl", b".cdl", b".eds"])
def test_names_that_are_no_text_are_refused(
    suffix: bytes,
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("idl").mkdir()
    Path(os.fsdecode(b"idl/\x83\x82\x81" + suffix)).write_text("struct S { long a; };")
    Path("rtgen.toml").write_text('[sources]\npaths = ["idl"]\n')
    assert run([command]) == 2
    error, *_ = capfd.readouterr().err.splitlines()
    assert re.fullmatch(r"error\[PRJ0015\]: 'idl/.*' is not UTF-8", error)


@pytest.mark.parametrize(
    "path", ["n" * 300 + ".idl", "a/" * 3000 + "b.idl", os.fsdecode(b"\xff.idl")]
)
@pytest.mark.parametrize(
    "arguments",
    [["check"], ["generate", "-o"], ["inspect", "-I"], ["generate"], ["docs", "-o"]],
)
def test_impossible_paths_of_the_command_line(
    path: str,
    arguments: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct S { long a; };")
    last = ["a.idl"] if arguments[-1].startswith("-") else []
    assert run([*arguments, path, *last]) in (0, 2, 3)
    printed = capfd.readouterr().err
    assert "internal error" not in printed
    assert len(printed.splitlines()) <= 3


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("dir", '"a\\u0000b"'),
        ("dir", f'"{"n" * 300}"'),
        ("skeletons", '"a\\u0000b"'),
        ("skeletons", f'"src/{"n" * 300}"'),
    ],
)
def test_impossible_folders_of_a_project(
    key: str,
    value: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct S { long a; };")
    Path("rtgen.toml").write_text(
        f'[sources]\npaths = ["a.idl"]\n[output]\n{key} = {value}\n'
    )
    assert run(["generate"]) == 2
    assert "rtgen.toml:4:1: error[PRJ0003]" in capfd.readouterr().err
