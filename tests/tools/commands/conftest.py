"""Fixture of a small pipeline that replaces the real front and back ends."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_pipeline import Pipeline

from rtgen.compiler import compilation
from rtgen.compiler.backends import stage


@pytest.fixture
def pipeline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Pipeline:
    """Return the pipeline in a folder of its own with two inputs, a cache, and no project file."""
    small = Pipeline()
    monkeypatch.setattr(compilation, "read", small.read)
    monkeypatch.setattr(stage, "backends", small.emitting)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    Path("a.idl").write_text("one\n")
    Path("b.idl").write_text("two\n")
    return small
