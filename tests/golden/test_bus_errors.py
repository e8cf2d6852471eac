"""Printed findings about bus files: a folder for each case, with bus.toml and expected.txt.

`board.eds`, beside it, is the base.eds of the cases of EDS, with a heartbeat.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rtgen.diagnostics import Severity
from rtgen.diagnostics.report import report
from rtgen.frontends.bus import load
from rtgen.frontends.bus.rules import RULES

CASES = Path(__file__).with_name("bus_errors")
BASE = Path(__file__).with_name("eds_errors") / "base.eds"
NAMES = sorted(path.name for path in CASES.iterdir())
CODE = re.compile(r"\b(?:error|warning|note)\[([A-Z]+\d{4})\]")


def with_heartbeat(eds: str) -> str:
    """Return the description with object 1017h appended."""
    listed = "[OptionalObjects]\nSupportedObjects=6\n"
    assert listed in eds
    more = listed.replace("6", "7") + "7=0x1017\n"
    return eds.replace(listed, more) + (
        "\n[1017]\nParameterName=Producer heartbeat time\nDataType=0x0006\n"
        "AccessType=rw\nDefaultValue=1000\n"
    )


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    (tmp_path / "bus.toml").write_bytes((CASES / name / "bus.toml").read_bytes())
    (tmp_path / "board.eds").write_text(with_heartbeat(BASE.read_text()))
    monkeypatch.chdir(tmp_path)
    result = load(Path("bus.toml"), root=tmp_path)
    found = report(result.diagnostics, result.sources)
    expected = CASES / name / "expected.txt"
    if update_golden:
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")
    assert set(CODE.findall(found)) == {name.partition("_")[0]}
    assert all(d.hint for d in result.diagnostics if d.severity is Severity.ERROR)


def test_every_rule_has_a_case() -> None:
    assert [name.partition("_")[0] for name in NAMES] == [rule.code for rule in RULES]
