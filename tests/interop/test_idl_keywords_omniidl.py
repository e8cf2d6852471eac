"""Names that are keywords of Python: what omniidl's modules can have is what rtgen lets pass."""

from __future__ import annotations

import keyword
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import programs
import pytest

from rtgen.compiler.frontends.idl import load
from rtgen.openrtm.backend.classic import Classic

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


IMPORTING = """
import importlib, sys
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
    except Exception:  # of any kind: the module is not Python
        continue
    print(name)
"""


def importable(folder: Path, modules: Iterable[str]) -> set[str]:
    """Return those modules of a folder that are Python."""
    command = [sys.executable, "-c", IMPORTING, *modules]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return set(done.stdout.decode().split())


@pytest.mark.nightly
@pytest.mark.parametrize("position", POSITIONS)
def test_keywords(position: str, tmp_path: Path) -> None:
    pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    names = (_NAMES[0], *_NAMES[2::6])
    files = [tmp_path / f"a{number}.idl" for number in range(len(names))]
    for file, name in zip(files, names, strict=True):
        written = f"_{name}" if name.casefold() in ("in", "import") else name
        text = POSITIONS[position].format(written)
        file.write_text(f"module M{file.stem} {{ {text} }};\n")
    command = [programs.omniidl(), "-bpython", f"-C{tmp_path}", *map(str, files)]
    subprocess.run(command, check=True, capture_output=True)
    works = importable(tmp_path, (f"{file.stem}_idl" for file in files))
    for file, name in zip(files, names, strict=True):
        reason = Classic(load([file], root=tmp_path).model).reason(
            (f"M{file.stem}", "I")
        )
        is_keyword = "keyword of Python" in reason
        assert (f"{file.stem}_idl" in works) is not is_keyword, name
