"""Findings about bus files as they are printed: a folder each: bus.toml and expected.txt.

`board.eds`, beside it, is the base.eds of the cases of EDS.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from rtgen.frontends.bus import load
from rtgen.frontends.bus.rules import RULES
from rtgen.report import report

CASES = Path(__file__).with_name("bus_errors")
BASE = Path(__file__).with_name("eds_errors") / "base.eds"
NAMES = sorted(path.name for path in CASES.iterdir())
CODE = re.compile(r"\b(?:error|warning|note)\[([A-Z]+\d{4})\]")


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    shutil.copy(CASES / name / "bus.toml", tmp_path)
    shutil.copy(BASE, tmp_path / "board.eds")
    monkeypatch.chdir(tmp_path)
    result = load(Path("bus.toml"), root=tmp_path)
    found = report(result.diagnostics, result.sources)
    expected = CASES / name / "expected.txt"
    if update_golden:
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")
    assert set(CODE.findall(found)) == {name.partition("_")[0]}


def test_every_rule_has_a_case() -> None:
    assert [name.partition("_")[0] for name in NAMES] == [rule.code for rule in RULES]
