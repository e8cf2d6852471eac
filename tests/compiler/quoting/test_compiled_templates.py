"""Compiled templates are stored beside their sources, and compiled again after a change."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from jinja2 import DictLoader, Environment

from rtgen.compiler.backends.kit import compiled_templates
from rtgen.compiler.backends.kit.compiled_templates import CompiledTemplates


def rendered(folder: Path, source: str, environment: str = ".py") -> str:
    kept = CompiledTemplates(folder, environment)
    jinja = Environment(loader=DictLoader({"a.j2": source}), bytecode_cache=kept)
    return jinja.get_template("a.j2").render(name="x")


@pytest.fixture(autouse=True)
def writing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)


def test_a_template_is_compiled_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "__pycache__"
    assert rendered(folder, "{{ name }}!") == "x!"
    assert len(list(folder.iterdir())) == 1
    monkeypatch.setattr(Environment, "_compile", None)
    assert rendered(folder, "{{ name }}!") == "x!"


def test_another_text_is_compiled_anew(tmp_path: Path) -> None:
    assert rendered(tmp_path, "{{ name }}!") == "x!"
    assert rendered(tmp_path, "{{ name }}?") == "x?"


def test_another_environment_or_quoting_has_code_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rendered(tmp_path, "{{ name }}")
    rendered(tmp_path, "{{ name }}", ".xml")
    assert len(list(tmp_path.iterdir())) == 2
    monkeypatch.setattr(compiled_templates, "_stamps", lambda: [("python.py", 1, 1)])
    rendered(tmp_path, "{{ name }}")
    assert len(list(tmp_path.iterdir())) == 3


def test_damaged_and_unwritable_files_are_no_harm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rendered(tmp_path, "{{ name }}")
    [file] = tmp_path.iterdir()
    for damaged in (b"", b"\0" * 40, file.read_bytes()[:-10]):
        file.write_bytes(damaged)
        assert rendered(tmp_path, "{{ name }}") == "x"
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert rendered(blocked / "inside", "{{ name }}") == "x"
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert rendered(tmp_path / "unwritten", "{{ name }}") == "x"
    assert not (tmp_path / "unwritten").exists()
