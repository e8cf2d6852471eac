"""Only regular files are read: a pipe would block, a device has no end."""

import os
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends.idl import load

pytestmark = pytest.mark.skipif(
    not hasattr(os, "mkfifo"), reason="the system has no named pipes"
)


@pytest.fixture(autouse=True)
def pipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe.idl")


def errors_of(text: str | None = None) -> str:
    """Return the printed findings of a text, or of the pipe itself."""
    if text is not None:
        Path("input.idl").write_text(text)
    path = Path("pipe.idl" if text is None else "input.idl")
    result = load([path], root=Path.cwd())
    return report(result.diagnostics, result.sources)


def test_as_input() -> None:
    assert "IDL0001]: pipe.idl is not a regular file" in errors_of()


def test_included() -> None:
    assert "IDL0010]: the file pipe.idl was not found" in errors_of(
        '#include "pipe.idl"\n'
    )


@pytest.mark.parametrize("file", ["pipe.idl", "/dev/zero"])
def test_named_by_a_line_marker(file: str) -> None:
    found = errors_of(f'#line 1 "{file}"\nstruct S {{ Nothing a; }};\n')
    assert "IDL0200]: Nothing is unknown" in found


def test_beside_a_file_with_an_unknown_name() -> None:
    assert "IDL0200]: Nothing is unknown" in errors_of("struct S { Nothing a; };\n")


def test_link_to_nothing() -> None:
    Path("input.idl").symlink_to("gone.idl")
    result = load([Path("input.idl")], root=Path.cwd())
    (finding,) = result.diagnostics
    assert finding.code == "IDL0001"
    assert finding.hint is not None
    assert "did you mean" not in finding.hint
