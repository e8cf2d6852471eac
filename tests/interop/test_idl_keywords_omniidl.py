"""Names that are keywords of Python: what omniidl's modules can have is what rtgen lets pass."""

from __future__ import annotations

import keyword
import subprocess
import sys
from pathlib import Path

import programs
import pytest

from rtgen.backends.openrtm.classic import Classic
from rtgen.frontends.idl import load

POSITIONS = {
    "attribute": "interface I {{ attribute long {0}; }};",
    "raises": "exception {0} {{}}; interface I {{ void f() raises ({0}); }};",
    "base": "interface {0} {{}}; interface I : {0} {{}};",
    "value": "valuetype {0} {{ public long x; }};"
    " valuetype I : {0} {{ public long y; }};",
    "supports": "interface {0} {{}}; valuetype I supports {0} {{ public long y; }};",
    "operation": "interface I {{ long {0}(in long a, out long b); }};",
    "parameter": "interface I {{ void f(in long {0}); long g(inout long {0}); }};",
    "exception": "exception {0} {{}}; interface I {{}};",
    "module": "module {0} {{ exception E {{}}; interface B {{}}; }};"
    " interface I : {0}::B {{ void f() raises ({0}::E); }};",
    "types": "module a {{ struct {0} {{ long x; }}; struct S {{ long {0}; }}; }};"
    " module b {{ enum {0} {{ other }}; }}; module c {{ enum E {{ {0}, other }}; }};"
    " interface I {{ a::{0} f(in b::{0} g, in c::E h); }};",
}
_NAMES = [k for k in keyword.kwlist if k not in ("True", "False")]
"""TRUE and FALSE are keywords of IDL, in any case."""


def works(folder: Path) -> bool:
    command = [sys.executable, "-c", "import a_idl"]
    return subprocess.run(command, cwd=folder, capture_output=True).returncode == 0


@pytest.mark.parametrize("position", POSITIONS)
def test_keywords(position: str, tmp_path: Path) -> None:
    pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    for name in (_NAMES[0], *_NAMES[2::6]):
        folder = tmp_path / name
        folder.mkdir()
        file = folder / "a.idl"
        written = f"_{name}" if name.casefold() in ("in", "import") else name
        file.write_text(f"module M {{ {POSITIONS[position].format(written)} }};\n")
        command = [programs.omniidl(), "-bpython", f"-C{folder}", str(file)]
        subprocess.run(command, check=True, capture_output=True)
        reason = Classic(load([file], root=folder).model).reason(("M", "I"))
        assert works(folder) is not ("keyword of Python" in reason), name
