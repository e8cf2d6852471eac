"""Accepted and refused celltypes, composites, cells, joins and regions."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends.cdl.pipeline import read_text
from rtgen.compiler.frontends.cdl.rules import RULES
from rtgen.compiler.model.tecs import Cell

FOLDER = Path(__file__).parent
BASE = (FOLDER / "base.cdl").read_text(encoding="utf-8")


def cases(name: str) -> dict[str, str]:
    """Return the texts of a file by their titles."""
    _, *blocks = (FOLDER / name).read_text(encoding="utf-8").split("\n== ")
    return dict(block.split("\n", 1) for block in blocks)


TAKEN = cases("taken.txt")
REFUSED = cases("refused.txt")


def errors(text: str) -> list[str]:
    """Return the errors of a text that is appended to the common part."""
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


OF_CELLS = (
    "check the spelling and the name space, or declare a prototype: cell tType Name;"
)


@pytest.mark.parametrize(
    ("target", "message", "hint"),
    [
        ("Q", "Q is not known: a join leads to a cell", OF_CELLS),
        ("Inne", "Inne is not known: a join leads to a cell", "did you mean Inner?"),
        ("n", "n is not a cell of tC: a join leads to a cell", OF_CELLS),
        ("Worker", "Worker is not known: a join leads to a cell", OF_CELLS),
    ],
)
def test_a_join_inside_a_composite_leads_to_a_cell_of_it(
    target: str, message: str, hint: str
) -> None:
    text = (
        "[active] composite tC { attr { int32_t n = 1; }; entry sWork eW;"
        " cell tWorker Inner { number = composite.n; };"
        f" cell tUser U {{ cWork = {target}.eWork; }}; eW => Inner.eWork; }};"
    )
    _, found = read_text(BASE + text)
    [diagnostic] = [d for d in found if d.severity is Severity.ERROR]
    assert (diagnostic.code, diagnostic.message, diagnostic.hint) == (
        "CDL0610",
        message,
        hint,
    )


def test_joins_of_a_cell_whose_celltype_is_missing() -> None:
    """The error is in the file; the target of the join is resolved all the same."""
    text = "import( <no_file.cdl> ); cell tMissing M { cX = Worker.eWork; };"
    unit, found = read_text(BASE + text)
    assert [d.code for d in found if d.severity is Severity.ERROR] == ["CDL0006"]
    assert "CDL0608" not in {
        d.code for d in found if "Worker" in d.message
    }, "somebody calls it"
    [cell] = [d for d in unit.declarations if isinstance(d, Cell) and d.name == ("M",)]
    [join] = cell.joins
    assert (join.port, join.target, join.target_port) == ("cX", ("Worker",), "eWork")
