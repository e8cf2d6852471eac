"""Printed findings of the IDL front end: a folder for each case, with input.idl and expected.txt.

The optional `case.toml` has settings: the `files` to read instead of input.idl, the `include`
folders, the macros to `define`, and in `[fill]` the replacement of a mark of the input: a text and
its number of repetitions; `only` names the codes to show, if there are many others. FOLDER is the
folder of the case.
"""

from __future__ import annotations

import json
import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.diagnostics.explain import rules
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.frontends.idl.rules import RULES

GOLDEN = Path(__file__).parent
CASES = GOLDEN / "idl_errors"
NAMES = sorted(path.name for path in CASES.iterdir() if path.is_dir())
CODE = re.compile(r"\b(?:error|warning|note)\[([A-Z]+\d{4})\]")
OF_THE_TOOL = ("PRJ", "ENV", "PY", "LINT", "RTC", "SYS")
"""Prefixes of the codes of the tool itself, whose cases are below `cases`."""


def prepare(case: Path, folder: Path) -> dict[str, Any]:
    """Copy a case's input, fill in its marks, and return its settings."""
    shutil.copytree(case, folder, dirs_exist_ok=True)
    toml = case / "case.toml"
    settings = tomllib.loads(toml.read_text(encoding="utf-8")) if toml.exists() else {}
    for mark, (text, times) in settings.get("fill", {}).items():
        for file in folder.rglob("*.idl"):
            content = file.read_bytes()
            if mark.encode() in content:
                file.write_bytes(
                    content.replace(mark.encode(), (text * times).encode())
                )
    return settings


def findings(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> FrontendResult:
    """Return the result of reading a case, with the findings to show."""
    settings = prepare(CASES / name, folder)
    monkeypatch.chdir(folder)
    result = load(
        [Path(file) for file in settings.get("files", ["input.idl"])],
        root=folder,
        include=[Path(folder) for folder in settings.get("include", [])],
        define=settings.get("define", {}),
    )
    only = settings.get("only", rules())
    shown = tuple(d for d in result.diagnostics if d.code in only)
    return replace(result, diagnostics=shown)


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    result = findings(name, tmp_path, monkeypatch)
    found = report(result.diagnostics, result.sources)
    found = found.replace(tmp_path.as_posix(), "FOLDER")
    expected = CASES / name / "expected.txt"
    if update_golden:
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")
    assert all(d.hint for d in result.diagnostics if d.severity is Severity.ERROR)
    if name.startswith("IDL"):
        assert name.partition("_")[0] in CODE.findall(found)


@pytest.mark.parametrize("name", NAMES)
def test_forms_for_machines(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each finding is complete in JSON, SARIF 2.1.0 (3.27, 3.30, 3.49) and annotations."""
    found = findings(name, tmp_path, monkeypatch).diagnostics
    [run] = json.loads(report(found, {}, "sarif"))["runs"]
    known = run["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in known] == sorted({d.code for d in found})
    assert all(rule["shortDescription"]["text"] for rule in known)
    assert all(rule["help"]["markdown"] for rule in known)
    objects = json.loads(report(found, {}, "json"))
    lines = report(found, {}, "github").splitlines()
    assert len(run["results"]) == len(objects) == len(lines) > 0
    for result, plain, line in zip(run["results"], objects, lines, strict=True):
        assert known[result["ruleIndex"]]["id"] == result["ruleId"] == plain["code"]
        assert result["level"] == plain["severity"] in ("error", "warning", "note")
        assert result["message"]["text"].startswith(plain["message"])
        assert re.match(rf"::(error|warning|notice) .*title={plain['code']}::", line)
        for place in (
            *result.get("locations", ()),
            *result.get("relatedLocations", ()),
        ):
            region = place["physicalLocation"]["region"]
            start = region["startLine"], region["startColumn"]
            assert (1, 1) <= start <= (region["endLine"], region["endColumn"])
        assert ("locations" in result) == (plain["file"] is not None)


def test_every_rule_of_idl_has_a_case() -> None:
    found = {
        code
        for file in CASES.glob("*/expected.txt")
        for code in CODE.findall(file.read_text(encoding="utf-8"))
    }
    assert {rule.code for rule in RULES} - found == set()
    assert found <= rules().keys()


OF_PLUG_INS = {
    *("PRJ0101", "PRJ0102", "PRJ0103", "PRJ0104", "PRJ0105", "PRJ0107", "SYS0002"),
}
"""Codes that need other packages or a changed output folder; tested with those."""


OF_BUSES = {"ENV0002"}
"""Codes that need a CAN bus; `tests/runtime/canopen` has cases with one."""


OF_MODELS = {
    *("RTC0104", "RTC0201", "RTC0202", "RTC0203", "RTC0301", "RTC0302", "RTC0305"),
}
"""Codes of models that the IDL front end refuses; `tests/compiler/components` has such models."""


OF_RUNS = {"SYS0023", "SYS0024"}
"""Codes reported while code runs; tested there."""


OF_INSTALLATIONS = {"ENV0003"}
"""Codes of what is not installed: `tests/ui/application/test_command.py`."""


OF_MANY = {"RTC0506"}
"""Codes that need a thousand findings: `tests/compiler/components/test_yaml_places.py`."""


OF_BAGS = {"SYS0035"}
"""Codes of bags, which are binary: `tests/tools/recording/test_topic_replay.py`."""


def test_every_rule_of_the_tool_has_a_case() -> None:
    found = {
        code
        for file in (GOLDEN / "cases").glob("*/stderr.txt")
        for code in CODE.findall(file.read_text(encoding="utf-8"))
    }
    made = [*(GOLDEN / "components").glob("*/diagnostics.txt")]
    made += (GOLDEN / "rtc_profile").glob("*.txt")
    made += (GOLDEN / "openrtm_python").glob("*.findings")
    for file in made:
        found.update(re.findall(r" ([A-Z]+\d{4}): ", file.read_text(encoding="utf-8")))
    wanted = {code for code in rules() if code.startswith(OF_THE_TOOL)}
    elsewhere = (
        OF_PLUG_INS | OF_BUSES | OF_MODELS | OF_RUNS | OF_INSTALLATIONS | OF_BAGS
    )
    for code in sorted(wanted - found - elsewhere - OF_MANY):
        pytest.fail(f"{code} has no golden case: tests/golden/cases/{code}_...")
    assert wanted - found == elsewhere | OF_MANY
    assert found <= rules().keys()
