"""Conditions of C headers: 64 bits as in C, and bounded work."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from rtgen.compiler.frontends import FrontendResult, cdl

CONDITIONS = {
    "(1 << 4) == 16": True,
    "-1 > 0U": True,
    "-1 > 0": False,
    "9223372036854775807 / 3 == 3074457345618258602": True,
    "-7 / 2 == -3 && -7 % 2 == -1": True,
    "0 && 1 / 0": False,
    "1 ? 2 : 1 / 0": True,
    "'\\x41' == 65 && 'A' == 0101 && '\\0' == 0 && '\\n' == 10": True,
    "defined(TECSGEN) && !defined NOTHING": True,
    "NOTHING": False,
    "!!!!!!!!1": True,
    "~0u == 0xFFFFFFFFFFFFFFFFu": True,
    "(((((1)))))": True,
    "__GNUC__ > 4 && __SIZEOF_POINTER__ == 8": True,
    "0x7fffffffffffffff + 0 > 0": True,
}
NO_CONDITIONS = {
    "(1 << 9999999999) > 0": "a shift by 9999999999 is not between 0 and 63",
    "1 >> -1": "a shift by -1 is not between 0 and 63",
    "1 / (1 - 1)": "division by zero",
    "9" * 5_000: "the number is too large",
    "0x" + "f" * 100_000: "the number is too large",
    "1 <<": "an operand is missing at the end",
    "(" * 10_000 + "1": "the expression is nested too deeply",
    "1 2": "'2' is not allowed here",
}


def read(folder: Path, condition: str) -> FrontendResult:
    (folder / "a.h").write_text(
        f"#if {condition}\ntypedef struct tag {{ int a; }} tYes;\n#endif\n"
    )
    (folder / "a.cdl").write_text(
        'import_C("a.h");\nsignature sS { void f([in] const tYes *a); };\n'
    )
    return cdl.load([folder / "a.cdl"], root=folder)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_conditions(condition: str, tmp_path: Path) -> None:
    found = read(tmp_path, condition).diagnostics
    assert "CDL0901" not in {d.code for d in found}
    assert (found == ()) is CONDITIONS[condition]


@pytest.mark.peer
def test_conditions_have_the_values_of_a_compiler(tmp_path: Path) -> None:
    compiler = shutil.which("cpp")
    if compiler is None:
        pytest.skip("cpp is missing")
    for condition, value in CONDITIONS.items():
        given = f"#if {condition}\nyes\n#endif\n"
        done = subprocess.run(
            [compiler, "-DTECSGEN", "-P", "-"],
            input=given,
            capture_output=True,
            text=True,
            check=True,
        )
        assert (done.stdout.strip() == "yes") is value, condition


@pytest.mark.parametrize("condition", NO_CONDITIONS, ids=lambda text: text[:20])
def test_conditions_without_a_value(condition: str, tmp_path: Path) -> None:
    messages = [d.message for d in read(tmp_path, condition).diagnostics]
    reason = NO_CONDITIONS[condition]
    wanted = f"a.h:1: a condition cannot be evaluated: {reason}"
    assert any(message.endswith(wanted) for message in messages)
