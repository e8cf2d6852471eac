"""`inspect --json`: a declaration of each kind, key by key."""

import json
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends import FrontendResult, cdl, idl
from rtgen.compiler.inspection.models import inspect, tree

FOLDER = Path(__file__).with_name("inspect")


def test_kinds(monkeypatch: pytest.MonkeyPatch, update_golden: bool) -> None:
    monkeypatch.chdir(FOLDER)
    result = idl.load([Path("kinds.idl")], root=FOLDER)
    compare(result, "kinds", update_golden)


def test_kinds_of_cdl(monkeypatch: pytest.MonkeyPatch, update_golden: bool) -> None:
    monkeypatch.chdir(FOLDER)
    result = cdl.load([Path("components.cdl")], root=FOLDER)
    compare(result, "components", update_golden)
    text = tree(result.model)
    if update_golden:
        Path("components.txt").write_text(text, encoding="utf-8")
    assert text == Path("components.txt").read_text(encoding="utf-8")


def compare(result: FrontendResult, name: str, update_golden: bool) -> None:
    """Compare the JSON of a model with that of a file."""
    assert not has_errors(result.diagnostics), result.diagnostics
    shown = inspect(result.model, [])
    file = Path(f"{name}.json")
    if update_golden:
        text = json.dumps(shown, indent=1, ensure_ascii=False)
        file.write_text(text + "\n", encoding="utf-8")
    assert shown == json.loads(file.read_text(encoding="utf-8"))
