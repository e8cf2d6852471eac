"""`rtgen lint` reports each error for which `rtgen generate` and `check` refuse definitions."""

from __future__ import annotations

import re
import shutil
import tomllib
from pathlib import Path

import pytest

from rtgen.cli import run

CASES = Path(__file__).parent / "cases"
OF_OUTPUT = {"PRJ0022", "PRJ0106", "RTC0109"}
"""Errors about files in the folders of outputs and skeletons, and renames, not definitions."""
OPTIONS = {"-o": 1, "--target": 1, "--no-cache": 0, "-q": 0}
"""Options of generate that lint does not have, with their numbers of arguments."""


def refused() -> dict[str, set[str]]:
    """Return the cases in which generate refuses definitions, with the codes of the errors."""
    cases = {}
    for file in sorted(CASES.glob("*/case.toml")):
        settings = tomllib.loads(file.read_text(encoding="utf-8"))
        output = file.with_name("stderr.txt")
        if settings["arguments"][0] in ("generate", "check") and settings["exit"] == 2:
            codes = set(re.findall(r"\berror\[(\w+)\]", output.read_text("utf-8")))
            if codes := codes - OF_OUTPUT:
                cases[file.parent.name] = codes
    return cases


REFUSED = refused()
REFUSED["PRJ0008_system_without_its_target"] = {"PRJ0007"}
"""lint judges systems for every target, and lacks the components of this one."""


@pytest.mark.sampled(15)
@pytest.mark.parametrize("case", REFUSED)
def test_lint_knows_the_errors(
    case: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    work = tmp_path / "work"
    work.mkdir()
    if (CASES / case / "input").is_dir():
        shutil.copytree(CASES / case / "input", work, dirs_exist_ok=True)
    settings = tomllib.loads((CASES / case / "case.toml").read_text(encoding="utf-8"))
    rest = iter(settings["arguments"][1:])
    arguments: list[str] = []
    for each in rest:
        if each not in OPTIONS:
            arguments.append(each)
            continue
        values = [next(rest) for _ in range(OPTIONS[each])]
        if each == "--target":
            text = f'[output]\ntarget = "{values[0]}"\n'
            (work / "rtgen.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(work)
    assert run(["lint", *arguments]) == 2
    assert set(re.findall(r"\berror\[(\w+)\]", capfd.readouterr().err)) == REFUSED[case]


def test_there_are_errors_of_back_ends_among_them() -> None:
    codes = {code for each in REFUSED.values() for code in each}
    assert codes >= {"PY0001", "PY0003", "RTC0101", "RTC0570", "CDL1003", "EDS0805"}
