"""Statements over several lines in templates: joined, and split as `fit` does."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from rtgen.compiler.backends.kit.python_text import fit
from rtgen.compiler.backends.kit.statements import statements

GENERATED = Path(__file__).resolve().parents[3] / "generated"


@pytest.mark.parametrize(
    ("text", "joined"),
    [
        ("f(\n    a,\n    b,\n)", "f(a, b)"),
        ("    f(\n        a,\n    )\nx", "    f(a)\nx"),
        ("x = (\n    a,\n)", "x = (a,)"),
        ("x = (\n    a,\n    b,\n)", "x = (a, b)"),
        ("x = (\n)\ny = {\n}\nf(\n)", "x = ()\ny = {}\nf()"),
        (
            "return {\n\n    1: a,\n\n    2: f(\n        b,\n    ),\n}",
            "return {1: a, 2: f(b)}",
        ),
        ("x = [\n    (\n        a,\n    ),\n]", "x = [(a,)]"),
        (
            "x = f(\n    (\n        a,\n    ),\n    k=(\n        b,\n    ),\n)",
            "x = f((a,), k=(b,))",
        ),
        ("a[\n    0\n] = g()(\n    1,\n)", "a[0] = g()(1)"),
        ('"""Text, (in brackets)."""\n\npass', '"""Text, (in brackets)."""\n\npass'),
    ],
)
def test_a_statement_is_on_one_line(text: str, joined: str) -> None:
    assert statements(text) == joined


@pytest.mark.sampled(0)
def test_what_fit_splits_is_joined_again() -> None:
    count = 0
    for file in sorted(GENERATED.rglob("*.py")):
        source = file.read_text("utf-8")
        for node in ast.parse(source).body:
            text = ast.get_source_segment(source, node) or ""
            if not isinstance(node, ast.Assign | ast.Expr) or '"""' in text:
                continue
            joined = statements(text)
            assert "\n" not in joined, (file, text)
            assert fit(joined) == text
            count += "\n" in text
    assert count > 20
