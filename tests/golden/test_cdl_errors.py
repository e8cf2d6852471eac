"""Printed findings of the CDL front end: a folder for each case, with input.cdl and expected.txt.

The optional `case.toml` has settings: the `files` to read instead of input.cdl, the `include`
folders, `kcode` and `prelude`, and in `[fill]` the replacement of a mark of the input: a text and
its number of repetitions; `only` names the codes to show, if there are many others. FOLDER is the
folder of the case.
"""

from __future__ import annotations

import json
import re
import shutil
import tomllib
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.diagnostics.explain import rules
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends.cdl import load
from rtgen.compiler.frontends.cdl.rules import RULES

CASES = Path(__file__).with_name("cdl_errors")
NAMES = sorted(path.name for path in CASES.iterdir() if path.is_dir())
FAMILIES = (
    "CDL00",
    "CDL01",
    "CDL02",
    "CDL03",
    "CDL04",
    "CDL05",
    "CDL06",
    "CDL07",
    "CDL08",
    "CDL09",
)
"""The families of rules with a case for each rule."""

CODE = re.compile(r"\b(?:error|warning|note)\[([A-Z]+\d{4})\]")


def findings(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[tuple[Diagnostic, ...], dict[str, str]]:
    """Return the findings to show of a case, and the texts that they refer to."""
    shutil.copytree(CASES / name, folder, dirs_exist_ok=True)
    toml = folder / "case.toml"
    settings = tomllib.loads(toml.read_text(encoding="utf-8")) if toml.exists() else {}
    for mark, (text, times) in settings.get("fill", {}).items():
        file = folder / "input.cdl"
        filled = file.read_text(encoding="utf-8").replace(mark, text * times)
        file.write_text(filled, encoding="utf-8")
    monkeypatch.chdir(folder)
    result = load(
        [Path(file) for file in settings.get("files", ["input.cdl"])],
        root=folder,
        include=[Path(folder) for folder in settings.get("include", [])],
        encoding=settings.get("kcode", "auto"),
        prelude=settings.get("prelude", True),
    )
    only = settings.get("only", rules())
    return tuple(d for d in result.diagnostics if d.code in only), dict(result.sources)


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    diagnostics, sources = findings(name, tmp_path, monkeypatch)
    found = report(diagnostics, sources).replace(tmp_path.as_posix(), "FOLDER")
    expected = CASES / name / "expected.txt"
    if update_golden:
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")
    assert name.partition("_")[0] in CODE.findall(found)
    for plain in json.loads(report(diagnostics, {}, "json")):
        assert plain["file"] is not None
        assert plain["line"] >= 1
        assert plain["hint"] or plain["severity"] != "error"


def test_every_rule_has_a_case() -> None:
    cases = {name.partition("_")[0] for name in NAMES}
    wanted = {rule.code for rule in RULES if rule.code.startswith(FAMILIES)}
    assert wanted - cases == set()
