"""Every rule by the smallest definition that breaks it, and definitions without findings."""

from pathlib import Path

import pytest
from cases import ACCEPTED, FOUND

from rtgen.compiler.diagnostics import Diagnostic, Rule
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.frontends.idl.rules import RULES


def findings(folder: Path, text: str) -> tuple[Diagnostic, ...]:
    path = folder / "input.idl"
    path.write_text(text, encoding="utf-8")
    return load([path], root=folder).diagnostics


@pytest.mark.parametrize("name", ACCEPTED)
def test_accepted(name: str, tmp_path: Path) -> None:
    assert findings(tmp_path, ACCEPTED[name]) == ()


@pytest.mark.parametrize("name", FOUND)
def test_found(name: str, tmp_path: Path) -> None:
    text, codes = FOUND[name]
    found = findings(tmp_path, text)
    assert tuple(d.code for d in found) == codes, found


@pytest.mark.parametrize("name", FOUND)
def test_span_lies_in_the_text(name: str, tmp_path: Path) -> None:
    text, _ = FOUND[name]
    lines = text.split("\n")
    for diagnostic in findings(tmp_path, text):
        span = diagnostic.span
        assert span is not None
        assert 1 <= span.line <= span.end_line <= len(lines)
        assert 1 <= span.column <= len(lines[span.line - 1]) + 1
        assert (span.line, span.column) < (span.end_line, span.end_column)


def test_codes_are_unique_and_explained() -> None:
    codes = [rule.code for rule in RULES]
    assert len(set(codes)) == len(codes)
    assert all(rule.title and rule.explanation.strip() for rule in RULES)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.code)
def test_codes_have_their_form(rule: Rule) -> None:
    assert rule.code.startswith("IDL")
    assert len(rule.code) == 7
    assert not rule.title.endswith(".")
