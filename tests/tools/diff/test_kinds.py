"""Each kind of change is found, with its classes; pages and documentation agree."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest
from change_cases import Case, cases, page, table
from json_schemas import validator

from rtgen.compiler import diagnostics
from rtgen.tools.diff.kinds.catalogue import KINDS
from rtgen.tools.diff.report import as_json, classes_text

PAGES = Path(diagnostics.__file__).parent / "pages"
DOCS = Path(__file__).parents[3] / "docs" / "changes.md"
BEGIN, END = "<!-- table of changes -->\n\n", "\n<!-- end of the table -->"


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder without a project around."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.sampled(30)
@pytest.mark.parametrize("case", cases(), ids=lambda case: case.name)
def test_a_change_is_found_with_its_classes(case: Case, tmp_path: Path) -> None:
    found = case.changes(tmp_path)
    own = [c for c in found if c.kind.code == case.code]
    assert own, [(c.kind.code, c.message) for c in found]
    assert {classes_text(c) for c in own} == {case.breaks}
    assert sorted({c.kind.code for c in found} - {case.code}) == sorted(case.also)
    for change in found:
        assert change.old is not None or change.new is not None, change
        assert change.message
        assert change.subject
    document = as_json(("old", "new"), found, {})
    validator("diff.schema.json").validate(json.loads(json.dumps(document)))


@pytest.mark.sampled(10)
@pytest.mark.parametrize("case", cases()[::9], ids=lambda case: case.name)
def test_nothing_is_found_between_equal_versions(case: Case, tmp_path: Path) -> None:
    same = Case(case.code, case.form, "", case.new, case.new, case.both)
    assert same.changes(tmp_path) == []


def test_every_kind_has_a_case() -> None:
    assert {case.code for case in cases()} == {kind.code for kind in KINDS}
    names = Counter(case.name for case in cases())
    assert max(names.values()) == 1
    assert len(names) >= 120


@pytest.mark.parametrize("code", [kind.code for kind in KINDS])
def test_the_page_of_a_kind_is_made_of_the_table(
    code: str, update_golden: bool
) -> None:
    path = PAGES / f"{code}.md"
    if update_golden:
        path.write_text(page(code), encoding="utf-8")
    assert path.read_text(encoding="utf-8") == page(code)


def test_the_documentation_has_the_table(update_golden: bool) -> None:
    text = DOCS.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    shown, end, after = rest.partition(END)
    assert end
    if update_golden:
        DOCS.write_text(before + BEGIN + table() + END + after, encoding="utf-8")
        shown = table()
    assert shown == table()
