"""Cases below `components`: definitions, with all output of the component back ends.

`input/` holds the definitions, `expected/` the files (skeletons below `skeletons/`),
`diagnostics.txt` the findings.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import black
import pytest
from lxml import etree

from rtgen.compiler.backends import Options, Owner
from rtgen.compiler.backends.components.backend import BACKEND
from rtgen.compiler.backends.profiles import rtc_profile
from rtgen.compiler.diagnostics import Diagnostic, in_order
from rtgen.compiler.frontends.idl import load

CASES = Path(__file__).parent / "components"
OPTIONS = Options(package="robots", skeleton_package="behaviours", version="0.1.0")


def emit(folder: Path) -> tuple[dict[str, str], list[Diagnostic]]:
    """Return the texts of all files by their relative paths, and all findings."""
    paths = sorted((folder / "input").glob("*.idl"))
    read = load(paths, root=folder / "input")
    emissions = [
        backend.emit(read.model, OPTIONS) for backend in (BACKEND, rtc_profile.BACKEND)
    ]
    files = {
        f"skeletons/{a.path}" if a.owner is Owner.USER else a.path: a.text
        for emission in emissions
        for a in emission.artifacts
    }
    found = [
        *read.diagnostics,
        *(d for emission in emissions for d in emission.diagnostics),
    ]
    return files, in_order(found)


def shown(found: list[Diagnostic]) -> str:
    lines = []
    for diagnostic in found:
        assert diagnostic.span is not None
        place = f"{Path(diagnostic.span.file).name}:{diagnostic.span.line}:{diagnostic.span.column}"
        lines.append(
            f"{place}: {diagnostic.severity} {diagnostic.code}: {diagnostic.message}\n"
        )
        lines += [
            f"  {label.label}: line {label.span.line}\n" for label in diagnostic.related
        ]
        lines += [f"  hint: {diagnostic.hint}\n"] if diagnostic.hint else []
    return "".join(lines)


@pytest.mark.parametrize("case", sorted(path.name for path in CASES.iterdir()))
def test_case(case: str, update_golden: bool) -> None:
    folder = CASES / case
    files, found = emit(folder)
    written = {f"expected/{path}": text for path, text in files.items()}
    if found:
        written["diagnostics.txt"] = shown(found)
    if update_golden:
        shutil.rmtree(folder / "expected", ignore_errors=True)
        (folder / "diagnostics.txt").unlink(missing_ok=True)
        for name, text in written.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8", newline="")
    expected = {
        path.relative_to(folder).as_posix(): path.read_bytes().decode()
        for path in folder.rglob("*")
        if path.is_file() and "input" not in path.relative_to(folder).parts
    }
    assert sorted(written) == sorted(expected)
    for name, text in written.items():
        assert text == expected[name], name
        if name.endswith(".py"):
            assert black.format_str(text, mode=black.Mode()) == text
        if name.endswith(".xml"):
            etree.fromstring(text.encode())
