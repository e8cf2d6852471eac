"""Printed findings of the EDS front end: a folder for each case, with input.eds and expected.txt.

The sections of `base.eds` that a case does not have are added to its end, so a case holds only what
differs. The optional `case.toml` has settings: `base = false` to add nothing, the `files` to read,
and in `[fill]` the replacement of a mark of the input: a text and its number of repetitions. FOLDER
is the folder of the case.
"""

from __future__ import annotations

import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from condensed import shortened

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.diagnostics.explain import rules
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.eds import load
from rtgen.compiler.frontends.eds.rules import RULES

CASES = Path(__file__).with_name("eds_errors")
NAMES = sorted(path.name for path in CASES.iterdir() if path.is_dir())
CODE = re.compile(r"\b(?:error|warning|note)\[([A-Z]+\d{4})\]")
SECTION = re.compile(rb"^\[([^\]\n]*)\]?", re.MULTILINE)


def completed(text: bytes) -> bytes:
    """Return the text with the missing sections of base.eds."""
    base = (CASES / "base.eds").read_bytes()
    starts = [found.start() for found in SECTION.finditer(base)]
    blocks = [base[a:b] for a, b in zip(starts, [*starts[1:], None], strict=True)]
    written = {name.lower() for name in SECTION.findall(text)}
    missing = [b for b in blocks if SECTION.findall(b)[0].lower() not in written]
    return text.rstrip(b"\n") + b"\n\n" + b"".join(missing)


def prepare(case: Path, folder: Path) -> dict[str, Any]:
    """Copy a case's input, complete it, and return its settings."""
    shutil.copytree(case, folder, dirs_exist_ok=True)
    toml = case / "case.toml"
    settings = tomllib.loads(toml.read_text(encoding="utf-8")) if toml.exists() else {}
    for file in folder.glob("input.*"):
        content = file.read_bytes()
        for mark, (text, times) in settings.get("fill", {}).items():
            lines = (text.replace("#", f"{n:04x}") for n in range(times))
            content = content.replace(mark.encode(), "".join(lines).encode())
        file.write_bytes(completed(content) if settings.get("base", True) else content)
    return settings


def findings(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[FrontendResult, dict[str, Any]]:
    """Return the result of reading a case, and its settings."""
    settings = prepare(CASES / name, folder)
    monkeypatch.chdir(folder)
    inputs = sorted(path.name for path in folder.glob("input.*"))
    return (
        load([Path(file) for file in settings.get("files", inputs)], root=folder),
        settings,
    )


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    result, settings = findings(name, tmp_path, monkeypatch)
    found = report(result.diagnostics, result.sources)
    found = found.replace(tmp_path.as_posix(), "FOLDER")
    if "shown" in settings:
        found = shortened(found, settings["shown"])
    expected = CASES / name / "expected.txt"
    if update_golden:
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")
    assert name.partition("_")[0] in CODE.findall(found)
    assert all(d.span is not None for d in result.diagnostics)
    assert all(d.hint for d in result.diagnostics if d.severity is Severity.ERROR)


def test_base_has_no_findings(tmp_path: Path) -> None:
    result = load([CASES / "base.eds"], root=CASES)
    assert result.diagnostics == ()
    assert len(result.model.devices) == 1


def test_every_rule_has_a_case() -> None:
    found = {
        code
        for file in CASES.glob("*/expected.txt")
        for code in CODE.findall(file.read_text(encoding="utf-8"))
    }
    assert {rule.code for rule in RULES} - found == set()
    assert found <= rules().keys()
