"""Findings of the IDL front end word for word: a folder each, with input.idl and expected.txt."""

from pathlib import Path

import pytest

from rtgen.diagnostics import Diagnostic, Span
from rtgen.frontends import FrontendResult
from rtgen.frontends.idl import load

CASES = Path(__file__).with_name("idl_errors")
NAMES = sorted(path.name for path in CASES.iterdir() if path.is_dir())


def place(span: Span | None) -> str:
    return f"{span.file}:{span.line}:{span.column}" if span else "nowhere"


def shown(diagnostic: Diagnostic, result: FrontendResult) -> str:
    """The finding with its line and caret, its related places and its hint."""
    span = diagnostic.span
    parts = [
        f"{place(span)}: {diagnostic.severity} {diagnostic.code}: {diagnostic.message}"
    ]
    text = result.sources.get(span.file) if span else None
    if span is not None and text is not None:
        line = text.split("\n")[span.line - 1]
        end = span.end_column if span.end_line == span.line else len(line) + 1
        parts += [
            f"  {line}",
            "  " + " " * (span.column - 1) + "^" * (end - span.column),
        ]
    parts += [
        f"  {place(related.span)}: {related.label}" for related in diagnostic.related
    ]
    if diagnostic.hint:
        parts.append(f"  hint: {diagnostic.hint}")
    return "\n".join(parts) + "\n"


@pytest.mark.parametrize("name", NAMES)
def test_findings(
    name: str, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    folder = CASES / name
    monkeypatch.chdir(folder)
    result = load([Path("input.idl")], root=folder)
    found = "\n".join(shown(diagnostic, result) for diagnostic in result.diagnostics)
    found = found.replace(folder.as_posix(), "FOLDER")
    expected = folder / "expected.txt"
    if update_golden:
        expected.write_text(found, encoding="utf-8")
    assert found == expected.read_text(encoding="utf-8")
