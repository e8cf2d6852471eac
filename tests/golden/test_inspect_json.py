"""`inspect --json`: a declaration of each kind, key by key."""

import json
from pathlib import Path

import pytest

from rtgen.diagnostics import has_errors
from rtgen.frontends.idl import load
from rtgen.inspect import inspect

FOLDER = Path(__file__).with_name("inspect")


def test_kinds(monkeypatch: pytest.MonkeyPatch, update_golden: bool) -> None:
    monkeypatch.chdir(FOLDER)
    result = load([Path("kinds.idl")], root=FOLDER)
    assert not has_errors(result.diagnostics), result.diagnostics
    shown = inspect(result.model, [])
    if update_golden:
        text = json.dumps(shown, indent=1, ensure_ascii=False)
        Path("kinds.json").write_text(text + "\n", encoding="utf-8")
    assert shown == json.loads(Path("kinds.json").read_text(encoding="utf-8"))
