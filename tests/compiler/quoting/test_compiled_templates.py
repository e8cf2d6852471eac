"""The code of templates is made when rtgen is packed; a template that differs is compiled."""

from __future__ import annotations

import importlib
import shutil
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from jinja2 import Environment

from rtgen.compiler.backends.kit import compiled_templates, rendering
from rtgen.compiler.backends.kit.compiled_templates import CompiledLoader

MODULE = "template_code_of_a_test"


@pytest.fixture
def packed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder of templates with a module of their code."""
    monkeypatch.setattr(compiled_templates, "_CODE", tmp_path / f"{MODULE}.py")
    monkeypatch.setattr(compiled_templates, "_MODULE", MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    folder = tmp_path / "templates"
    folder.mkdir()
    texts = {
        "a.py.j2": "{% for n in names %}{{ n }}\\n'''\n\t\"{% endfor %}",
        "b.py.j2": "{% extends 'c.py.j2' %}{% block x %}b{% endblock %}",
        "c.py.j2": "{% block x %}c{% endblock %}!",
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    pack(folder)
    yield folder
    sys.modules.pop(MODULE, None)


def pack(folder: Path) -> None:
    names = sorted(path.name for path in folder.iterdir())
    compiled_templates.write(dict.fromkeys(names, environment(folder)))
    sys.modules.pop(MODULE, None)
    # Of a file that was written in the same second.
    shutil.rmtree(folder.parent / "__pycache__", ignore_errors=True)
    importlib.invalidate_caches()
    compiled_templates._code.cache_clear()


@pytest.fixture(autouse=True)
def original() -> Iterator[None]:
    """After a test, the code is that of rtgen's templates again."""
    compiled_templates._code.cache_clear()
    yield
    compiled_templates._code.cache_clear()


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the templates that are compiled from now on."""
    names: list[str] = []
    compile_ = Environment._compile

    def noted(self: Environment, source: str, filename: str) -> object:
        names.append(Path(filename).name)
        return compile_(self, source, filename)

    monkeypatch.setattr(Environment, "_compile", noted)
    return names


def environment(folder: Path) -> Environment:
    return Environment(loader=CompiledLoader(folder))


def rendered(
    folder: Path, name: str, values: Mapping[str, object] | None = None
) -> str:
    return environment(folder).get_template(name).render(values or {})


def test_a_packed_template_is_not_compiled(packed: Path, compiled: list[str]) -> None:
    text = rendered(packed, "a.py.j2", {"names": "xy"})
    assert text == "x\\n'''\n\t\"y\\n'''\n\t\""
    assert rendered(packed, "b.py.j2") == "b!"
    assert not compiled


def test_another_text_is_compiled(packed: Path, compiled: list[str]) -> None:
    (packed / "c.py.j2").write_text("{% block x %}c{% endblock %}?")
    assert rendered(packed, "b.py.j2") == "b?"
    assert compiled == ["c.py.j2"]
    pack(packed)
    compiled.clear()
    assert rendered(packed, "b.py.j2") == "b?"
    assert not compiled


def test_all_are_compiled_with_another_jinja_or_quoting(
    packed: Path, compiled: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiled_templates, "_compiler", lambda: "another")
    assert rendered(packed, "b.py.j2") == "b!"
    assert compiled == ["b.py.j2", "c.py.j2"]


@pytest.mark.parametrize("text", [None, "CODE = {}\n", "raise ImportError\n"])
def test_without_their_code_templates_are_compiled(
    packed: Path, compiled: list[str], text: str | None
) -> None:
    module = packed.parent / f"{MODULE}.py"
    if text is None:
        module.unlink()
    else:
        module.write_text(text)
    importlib.invalidate_caches()
    assert rendered(packed, "b.py.j2") == "b!"
    assert compiled == ["b.py.j2", "c.py.j2"]


def test_rtgen_is_packed_with_the_code_of_its_templates(
    packed: Path, compiled: list[str]
) -> None:
    rendering.write_code()
    sys.modules.pop(MODULE, None)
    importlib.invalidate_caches()
    compiled_templates._code.cache_clear()
    compiled.clear()
    names = rendering.template_names()
    environments = {rendering.suffix_of(name) for name in names}
    fresh = {each: rendering._environment.__wrapped__(each) for each in environments}
    for name in names:
        fresh[rendering.suffix_of(name)].get_template(name)
    assert not compiled
