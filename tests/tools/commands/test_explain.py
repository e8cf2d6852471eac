"""The pages of `rtgen explain`."""

from __future__ import annotations

import ast
import importlib
import re
import sys
import tomllib
from pathlib import Path

import pytest
from rtgen_sources import trees

from rtgen.cli import run
from rtgen.compiler import diagnostics
from rtgen.compiler.diagnostics import Rule, Severity
from rtgen.compiler.diagnostics.explain import MODULES, rule_of, rules
from rtgen.compiler.kit import own_files, plugins
from rtgen.tools.kit import pages

FOLDER = Path(diagnostics.__file__).parent


def test_every_module_with_rules_is_known() -> None:
    """Rules that one module collects from its neighbours count as known."""
    having = set()
    for path, tree in trees(r"^RULES\b"):
        for node in tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
            if any(isinstance(t, ast.Name) and t.id == "RULES" for t in targets):
                name = f"rtgen/{path}".removesuffix(".py").replace("/", ".")
                having.add(name.removesuffix(".__init__"))
    known = set(rules())
    for name in having - set(MODULES):
        module = __import__(name, fromlist=["RULES"])
        assert {rule.code for rule in module.RULES} <= known, name


def test_codes_titles_and_stories_are_whole() -> None:
    for code, rule in rules().items():
        assert re.fullmatch(r"[A-Z]{2,4}\d{4}", code)
        assert rule.title
        assert len(rule.explanation.split()) > 4, code


def test_each_rule_is_where_its_letters_say() -> None:
    for name, letters in MODULES.items():
        codes = {rule.code for rule in importlib.import_module(name).RULES}
        assert {code.rstrip("0123456789") for code in codes} == {*letters.split()}
    for code, rule in rules().items():
        assert rule_of(code.lower()) is rule
    assert rule_of("XYZ0001") is None


def test_every_page_belongs_to_a_rule() -> None:
    pages = {file.stem for file in (FOLDER / "pages").iterdir()}
    assert pages == {code for code, rule in rules().items() if rule.text is None}


def test_every_hint_belongs_to_a_rule() -> None:
    hints = tomllib.loads((FOLDER / "hints.toml").read_text("utf-8"))
    assert hints.keys() <= rules().keys()


def test_a_rule_of_a_plug_in_brings_its_text() -> None:
    assert (
        Rule("ACME0001", "a title", Severity.ERROR, "A text.").explanation == "A text."
    )
    assert Rule("ACME0001", "a title", Severity.ERROR).explanation == ""


def test_every_story_of_definitions_has_an_example() -> None:
    for code, rule in rules().items():
        if code.startswith(("IDL", "LINT")):
            assert rule.explanation.count("```") >= 2, code
            assert rule.explanation.count("```") % 2 == 0, code
        assert max(map(len, rule.explanation.splitlines())) <= 100, code


def test_the_list_of_codes(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["explain"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == sorted(rules())


def test_a_story(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "prj0101"]) == 0
    assert capfd.readouterr().out.startswith("# PRJ0101: two files of one name\n\n")


def test_a_story_without_a_translation_says_so(
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert run(["--language", "ja", "explain", "RTC0597"]) == 0
    assert "\n\nこの説明はまだ英語だけです。\n\nA connector" in capfd.readouterr().out
    assert run(["--language", "ja", "explain", "IDL0200"]) == 0
    assert "英語だけ" not in capfd.readouterr().out
    assert run(["explain", "RTC0597"]) == 0
    assert "only" not in capfd.readouterr().out


def test_an_unknown_code(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "PRJ01O1"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert "did you mean" in err
    assert "PRJ0101" in err


def test_the_page_of_lint_has_each_of_its_rules() -> None:
    page = (Path(__file__).parents[3] / "docs" / "lint.md").read_text("utf-8")
    codes = {code for code in rules() if code.startswith("LINT")}
    assert {code for code in codes if f"| `{code}` |" not in page} == set()


@pytest.mark.nightly
def test_the_short_way_prints_what_the_command_prints(
    monkeypatch: pytest.MonkeyPatch, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    some = ("IDL0200", "RTC0600")
    for locale, codes in {"C": (*rules(), "idl0200"), "ja_JP": some}.items():
        monkeypatch.setenv("LC_ALL", locale)
        for code in codes:
            assert run(["explain", code]) == 0
            by_command = capfdbinary.readouterr()
            assert pages.explained(["explain", code]) == 0
            assert capfdbinary.readouterr() == by_command


def test_what_the_command_alone_knows_is_left_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    own = ["explain", "IDL0200"]
    for others in ([], ["PRJ01O1"], [""], ["-h"], ["--"], ["IDL0200", "IDL0200"]):
        assert pages.explained(["explain", *others]) is None
    with monkeypatch.context() as context:
        context.setenv("_RTGEN_COMPLETE", "bash_source")
        assert pages.explained(own) is None
    with monkeypatch.context() as context:
        context.setattr(sys.stdout, "isatty", lambda: True)
        assert pages.explained(own) is None
    with monkeypatch.context() as context:
        context.setattr(plugins, "announced", lambda *_: (object(),))
        assert pages.explained(own) is None
    journal = Path(own_files.RENAME_JOURNAL)
    journal.write_text("{}")
    assert pages.explained(own) is None
    journal.unlink()
    assert capfd.readouterr() == ("", "")
    assert pages.explained(own) == 0
    assert capfd.readouterr().out.startswith("# IDL0200: ")
