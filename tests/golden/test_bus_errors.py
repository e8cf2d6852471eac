"""Printed findings about bus files: a folder for each case, with bus.toml and expected.txt.

`board.eds`, beside it, is the base.eds of the cases of EDS, with a heartbeat, and `wired.eds`
has more objects of the communication profile.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends.bus import load
from rtgen.compiler.frontends.bus.rules import RULES

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


def wired(eds: str) -> str:
    """Return the description with SYNC, consumers, a TPDO 2 of a read-only COB-ID, and no LSS."""
    objects = {
        "1005": [(7, "rw", "0x80")],
        "1016": [(5, "const", "2"), (7, "rw", "0"), (7, "rw", "0")],
        "1019": [(5, "rw", "0")],
        "1801": [(5, "const", "2"), (7, "ro", "$NODEID+0x280"), (5, "rw", "255")],
        "1A01": [(5, "rw", "1"), (7, "rw", "0x60000108")],
    }
    listed = "[OptionalObjects]\nSupportedObjects=7\n"
    assert listed in eds
    more = "".join(f"{n}=0x{index}\n" for n, index in enumerate(objects, 8))
    eds = eds.replace(listed, listed.replace("7", str(7 + len(objects))) + more)
    eds = eds.replace("NrOfTXPDO=1", "NrOfTXPDO=2")
    eds = eds.replace("LSS_Supported=1", "LSS_Supported=0")
    form = "ParameterName=Sub {}\nDataType={}\nAccessType={}\nDefaultValue={}\n"
    for index, subs in objects.items():
        if len(subs) == 1:
            eds += f"\n[{index}]\nObjectType=7\n" + form.format(index, *subs[0])
            continue
        head = f"ParameterName=Object {index}\nObjectType=9\nSubNumber={len(subs)}\n"
        eds += f"\n[{index}]\n{head}"
        for place, sub in enumerate(subs):
            eds += f"\n[{index}sub{place}]\n" + form.format(place, *sub)
    return eds


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    (tmp_path / "bus.toml").write_bytes((CASES / name / "bus.toml").read_bytes())
    board = with_heartbeat(BASE.read_text())
    (tmp_path / "board.eds").write_text(board)
    (tmp_path / "wired.eds").write_text(wired(board))
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
