"""Comments in Shift_JIS that hide the next line from omniidl and gcc, until `lint --fix`."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from programs import find, omniidl

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.model import Struct
from rtgen.compiler.model.tecs import TecsStruct, TecsTypedef

pytestmark = pytest.mark.peer

LAST = "表能ソ予十構申貼暴"
"""Characters whose second octet is 5Ch."""


def lines(word: str) -> str:
    return "".join(
        f"  {word} m{i};   // X座標の{character}\n" for i, character in enumerate(LAST)
    )


MEMBERS = [f"m{i}" for i in range(len(LAST))]


def test_idl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = f"struct P {{\n{lines('double')}}};\n"
    Path("p.idl").write_bytes(text.encode("cp932"))

    def seen() -> list[str]:
        done = subprocess.run(
            [omniidl(), "-bdump", "p.idl"], capture_output=True, text=True, check=False
        )
        words = done.stdout.replace(";", " ").split()
        return [word for word in words if word in MEMBERS]

    def read() -> list[str]:
        [struct] = api.compile(Path("p.idl")).declarations
        assert isinstance(struct, Struct)
        return [member.name for member in struct.members]

    assert read() == MEMBERS
    assert seen() != MEMBERS
    run(["lint", "--fix", "p.idl"])
    assert read() == seen() == MEMBERS


def test_c_headers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gcc = find("gcc")
    if gcc is None:
        pytest.skip("gcc is missing")
    monkeypatch.chdir(tmp_path)
    text = f"typedef struct {{\n{lines('int')}}} P;\n"
    Path("p.h").write_bytes(text.encode("cp932"))
    Path("p.cdl").write_text('import_C("p.h");\nsignature s { void f(void); };\n')
    Path("p.c").write_text(
        f'#include "p.h"\nchar all[sizeof(P) == {len(LAST)} * sizeof(int) ? 1 : -1];\n'
    )

    def is_same() -> bool:
        command = [gcc, "-fsyntax-only", "p.c"]
        return subprocess.run(command, capture_output=True, check=False).returncode == 0

    def read() -> list[str]:
        [unit] = api.compile(Path("p.cdl")).tecs
        [typedef] = [d for d in unit.declarations if isinstance(d, TecsTypedef)]
        [struct] = [d for d in unit.declarations if isinstance(d, TecsStruct)]
        assert typedef.name[-1] == "P"
        return [member.name for member in struct.members]

    assert read() == MEMBERS
    assert not is_same()
    run(["lint", "--fix", "p.cdl"])
    assert read() == MEMBERS
    assert is_same()
