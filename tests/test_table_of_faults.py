"""The table of faults: its tests exist, and docs/faults.md is up to date."""

import ast

from fault_table import ROOT, faults, page


def test_the_page_is_the_table() -> None:
    text = (ROOT / "docs/faults.md").read_text("utf-8")
    assert text == page(), "python tests/fault_table.py > docs/faults.md"


def test_each_row_has_tests_that_exist() -> None:
    for row in faults():
        assert row.tests, row.fault
        for test in row.tests:
            path, _, name = test.partition("::")
            tree = ast.parse((ROOT / path).read_text("utf-8"))
            functions = {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}
            assert not name or name in functions, test
