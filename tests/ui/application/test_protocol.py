"""The messages between server and page equal those generated from their IDL, on both sides."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen import api
from rtgen.compiler.backends import Options
from rtgen.facts.version import __version__

ROOT = Path(__file__).resolve().parents[3]
IDL = ROOT / "src/rtgen/compiler/kit/idl/Ui.idl"
PYTHON = "rtgen.ui.protocol"
PLACES = {"rtgen/ui/protocol": ROOT / "src", "typescript": ROOT / "ui/src/protocol"}


def made() -> dict[Path, str]:
    """Return the files that belong in the repository, with their texts."""
    model = api.compile(IDL)
    found: dict[Path, str] = {}
    for name in ("types", "typescript"):
        options = Options(PYTHON, "", __version__, target="typescript")
        for artifact in api.emit(model, name, options=options).artifacts:
            path = artifact.path.removeprefix("typescript/")
            folder = PLACES[
                "typescript" if name == "typescript" else "rtgen/ui/protocol"
            ]
            found[folder / path] = artifact.text
    return found


def test_both_sides_are_generated(
    update_golden: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    files = made()
    assert len(files) > 6
    for path, text in files.items():
        if update_golden:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        assert path.read_text(encoding="utf-8") == text, path
