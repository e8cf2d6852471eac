"""Cases `openrtm_python/*.txt`: the IDL of a module's component, and the findings."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace
from test_rtc_profiles import SPECS, shown

from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.diagnostics import Diagnostic, in_order
from rtgen.compiler.frontends import idl
from rtgen.compiler.lowering.profiles.components import components
from rtgen.openrtm import python_modules
from rtgen.openrtm.python_modules import rules

CASES = Path(__file__).parent / "openrtm_python"


def read(path: Path) -> tuple[str, list[Diagnostic]]:
    """Return the component as IDL, and the findings."""
    base = idl.load(
        [SPECS / "ExtendedDataTypes.idl"], root=SPECS, include=[SPECS]
    ).model
    result = python_modules.read(path)
    if result.profile is None:
        return "", list(result.diagnostics)
    made, found = components([result.profile], base)
    whole = replace(base, declarations=(*base.declarations, *made))
    text = idl_text(whole, made, components=True)
    return text, in_order((*result.diagnostics, *found))


@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.txt")))
def test_case(name: str, update_golden: bool) -> None:
    text, found = read(CASES / f"{name}.txt")
    for suffix, content in {".idl": text, ".findings": shown(found)}.items():
        file = CASES / f"{name}{suffix}"
        if update_golden:
            file.write_text(content, encoding="utf-8", newline="")
        assert content == file.read_bytes().decode()


def test_every_rule_has_a_case() -> None:
    codes = {d.code for file in CASES.glob("*.txt") for d in read(file)[1]}
    assert {rule.code for rule in rules.RULES} <= codes


def test_nothing_is_executed(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    module = tmp_path / "module.py"
    module.write_text(f"open({str(mark)!r}, 'w')\n", encoding="utf-8")
    assert python_modules.read(module).profile is None
    assert not mark.exists()
