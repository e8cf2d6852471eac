"""Printed findings about ROS 2 interface files: a folder of packages for each case.

The files read are all `Main.*`, and `main_.msg`.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.diagnostics.report import report
from rtgen.ros2.rosidl import load
from rtgen.ros2.rosidl.rules import RULES, TOO_MANY

CASES = Path(__file__).with_name("ros_errors")
NAMES = sorted(path.name for path in CASES.iterdir())
CODE = re.compile(r"\b(?:error|warning|note)\[([A-Z]+\d{4})\]")


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    shutil.copytree(CASES / name, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    found = sorted(Path().glob("*/*/[Mm]ain*.*")) or [Path("lab/msg/Main.msg")]
    result = load(found, root=tmp_path)
    printed = report(result.diagnostics, result.sources)
    expected = CASES / name / "expected.txt"
    if update_golden:
        expected.write_text(printed, encoding="utf-8")
    assert printed == expected.read_text(encoding="utf-8")
    assert set(CODE.findall(printed)) == {name.partition("_")[0]}
    assert all(d.hint for d in result.diagnostics if d.severity is Severity.ERROR)
    has_errors = any(d.severity is Severity.ERROR for d in result.diagnostics)
    assert bool(result.model.declarations) is not has_errors


def test_every_rule_has_a_case() -> None:
    codes = [rule.code for rule in RULES if rule is not TOO_MANY]
    assert [name.partition("_")[0] for name in NAMES] == codes
