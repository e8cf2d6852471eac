"""Templates: what they insert without a filter is quoted or refused by the language."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import pytest
from jinja2 import DictLoader, nodes

from rtgen.backends.kit import rendering
from rtgen.backends.kit.quoting import UnquotableError

TEMPLATES = Path(rendering.__file__).parents[2] / "templates"
TEXT = "x\nimport os; os.system('id') # \"$(id)\" %PATH% <a> & -- \\"


def _inserted(suffix: str, text: str) -> str:
    environment = rendering._environment(suffix).overlay(
        loader=DictLoader({"t": "{{ text }}"})
    )
    return environment.get_template("t").render(text=text)


@pytest.mark.parametrize("suffix", [".py", ".conf", ".txt", ".bat", ".rb"])
def test_plain_insertion_of_a_text_is_refused(suffix: str) -> None:
    with pytest.raises(UnquotableError):
        _inserted(suffix, TEXT)


@pytest.mark.parametrize("suffix", [".sh", ".xml", ".svg"])
def test_plain_insertion_of_a_text_is_quoted(suffix: str) -> None:
    assert TEXT not in _inserted(suffix, TEXT)
    assert "\n" in _inserted(".sh", TEXT)


@pytest.mark.parametrize("suffix", rendering.LANGUAGES)
def test_code_of_the_language_is_inserted_as_it_is(suffix: str) -> None:
    code = rendering.LANGUAGES[suffix].code(TEXT)
    environment = rendering._environment(suffix).overlay(
        loader=DictLoader({"t": "{{ text }}"})
    )
    assert environment.get_template("t").render(text=code) == TEXT


def test_every_template_is_of_a_known_language() -> None:
    files = [*TEMPLATES.rglob("*.j2")]
    assert {PurePosixPath(p.name).suffixes[-2] for p in files} == set(
        rendering.LANGUAGES
    )


def test_no_template_switches_its_quoting_off() -> None:
    """`safe` and `autoescape` would; `code` is for statements that a back end has made."""
    for path in TEMPLATES.rglob("*.j2"):
        suffix = PurePosixPath(path.name).suffixes[-2]
        tree = rendering._environment(suffix).parse(path.read_text())
        names = {found.name for found in tree.find_all(nodes.Filter)}
        assert "safe" not in names, path
        assert not list(tree.find_all(nodes.ScopedEvalContextModifier)), path
