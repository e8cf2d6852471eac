"""IDL written from the model means the same to rtgen and to omniidl."""

from __future__ import annotations

import subprocess
from pathlib import Path

import msgspec
import programs
import pytest

from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.model import Component, Declaration, Home, Model

ROOT = Path(__file__).parents[3]
FOLDERS = (
    "specs/idl",
    "tests/golden/idl",
    "tests/compiler/types",
    "tests/interop",
    "tests/fuzz",
)
FILES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in FOLDERS
    for path in (ROOT / folder).glob("*.idl")
)
INCLUDE = [Path("specs/idl"), Path("tests/golden/idl")]

TRICKY = """
module Point {
    struct Value { long x; };
};
module Names {
    struct Place { ::Point::Value point; ::Point::Value value; };
    struct Inline { struct Part { enum Kind { SMALL, LARGE } size; } first; Part other; };
    union Choice switch (char) { case 'a': case '\\x01': string<4> text;
        default: octet rest[2][3]; };
    const string QUOTED = "say \\"hi\\" \\\\ \\t";
    const wstring WIDE = L"\\u3042'";
    const char QUOTE = '\\'';
    const double HUGE_NUMBER = 1e300;
    const boolean YES = TRUE;
    const octet LAST = 255;
    interface Desk {
        typedef sequence<sequence<octet, 3> > Rows;
        exception Failed { string reason; };
        attribute long level;
        Rows get(in ::Point::Value point, inout Names::Desk::Rows rows, out string<8> name)
            raises (Failed);
        oneway void _in(in Names::Place value);
    };
};
"""


def without_places(value: object) -> object:
    """Return the value as a tree without positions."""
    if isinstance(value, msgspec.Struct):
        return (
            type(value).__name__,
            *(
                (name, without_places(getattr(value, name)))
                for name in value.__struct_fields__
                if name not in ("span", "file")
            ),
        )
    return tuple(map(without_places, value)) if isinstance(value, tuple) else value


def kept(model: Model) -> list[Declaration]:
    return [d for d in model.declarations if not isinstance(d, Component | Home)]


def read(path: Path) -> Model:
    result = load([path], root=ROOT, include=INCLUDE)
    assert not has_errors(result.diagnostics), result.diagnostics
    return result.model


@pytest.mark.sampled(8)
@pytest.mark.parametrize("path", [*FILES, "tricky"])
def test_read_again(path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    if path == "tricky":
        source = tmp_path / "tricky.idl"
        source.write_text(TRICKY, encoding="utf-8")
        path = str(source)
    model = read(Path(path))
    written = tmp_path / "written.idl"
    written.write_text(idl_text(model, model.declarations), encoding="utf-8")
    again = read(written)
    assert [d.name for d in again.declarations] == [d.name for d in kept(model)]
    for ours, theirs in zip(kept(model), again.declarations, strict=True):
        assert without_places(theirs) == without_places(ours)


IDL4 = (
    "service_forms.idl",
    "language.idl",
    "xcdr.idl",
    "octets.idl",
    "constructs.idl",
    "dynamic.idl",
    "typescript.idl",
)
"""Files with constructs unknown to omniidl, not counting annotations."""


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    "path", [*(f for f in FILES if not f.endswith(IDL4)), "tricky"]
)
def test_omniidl_reads_it(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    if path == "tricky":
        source = tmp_path / "tricky.idl"
        source.write_text(TRICKY, encoding="utf-8")
        path = str(source)
    model = read(Path(path))
    written = tmp_path / "written.idl"
    text = idl_text(model, model.declarations, annotations=False)
    written.write_text(text, encoding="utf-8")
    run = subprocess.run(
        [programs.omniidl(), "-b", "dump", str(written)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert run.returncode == 0, run.stdout + run.stderr
