"""What is taken and what is refused of celltypes, composites, cells, joins and regions."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rtgen.diagnostics import Severity
from rtgen.frontends.cdl.pipeline import read_text
from rtgen.frontends.cdl.rules import RULES

FOLDER = Path(__file__).parent
BASE = (FOLDER / "base.cdl").read_text(encoding="utf-8")


def cases(name: str) -> dict[str, str]:
    """The texts of a file by their titles."""
    _, *blocks = (FOLDER / name).read_text(encoding="utf-8").split("\n== ")
    return dict(block.split("\n", 1) for block in blocks)


TAKEN = cases("taken.txt")
REFUSED = cases("refused.txt")


def errors(text: str) -> list[str]:
    """The errors that a text gives behind what all cases share."""
    _, found = read_text(BASE + text)
    return [d.code for d in found if d.severity is Severity.ERROR]


@pytest.mark.parametrize("title", TAKEN)
def test_taken(title: str) -> None:
    assert errors(TAKEN[title]) == []


@pytest.mark.parametrize("title", REFUSED)
def test_refused_with_one_finding(title: str) -> None:
    assert errors(REFUSED[title]) == [title.partition(" -> ")[2]]


EXAMPLES = {
    rule.code: example
    for rule in RULES
    for example in re.findall(
        r"```cdl\n// gives this finding\n(.*?)```", rule.explanation, re.S
    )
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_examples_of_explain(code: str) -> None:
    _, found = read_text(EXAMPLES[code])
    assert code in {d.code for d in found}
