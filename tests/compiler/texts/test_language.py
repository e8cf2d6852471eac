"""The language of texts: an option, else the project's, else that of the locale; widths; cp932."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import unicodedata
from pathlib import Path

import pytest

from rtgen.cli import COMMANDS, run
from rtgen.compiler.diagnostics.explain import rules, story
from rtgen.compiler.kit import translation
from rtgen.compiler.kit.translation.blocks import paragraphs
from rtgen.compiler.kit.translation.catalogue import catalogue
from rtgen.facts import columns
from rtgen.facts.substitutes import registered

BROKEN = (
    "struct Wheel { double radius; } ;\nstruct /* 車輪の型 */ Wheel { double d; };\n"
)
LOCALE = ("LC_ALL", "LC_MESSAGES", "LANG")


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "wheel.idl").write_text(BROKEN, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    for name in LOCALE:
        monkeypatch.delenv(name, raising=False)
    return tmp_path


def said(capfd: pytest.CaptureFixture[str], *options: str) -> str:
    assert run(["inspect", "wheel.idl", *options]) == 2
    return capfd.readouterr().err


@pytest.mark.parametrize(
    ("option", "of_project", "locale", "language"),
    [
        ((), None, {}, "en"),
        ((), None, {"LANG": "ja_JP.UTF-8"}, "ja"),
        ((), None, {"LANG": "ja"}, "ja"),
        ((), None, {"LANG": "ja_JP.UTF-8", "LC_MESSAGES": "en_GB.UTF-8"}, "en"),
        ((), None, {"LANG": "ja_JP.UTF-8", "LC_ALL": "C"}, "en"),
        ((), None, {"LANG": "en_US.UTF-8", "LC_ALL": "", "LC_MESSAGES": "ja_JP"}, "ja"),
        ((), None, {"LANG": "java"}, "en"),
        ((), None, {"LANG": "de_DE.UTF-8"}, "en"),
        ((), "ja", {"LANG": "en_US.UTF-8"}, "ja"),
        ((), "en", {"LANG": "ja_JP.UTF-8"}, "en"),
        (("--language", "en"), "ja", {"LANG": "ja_JP.UTF-8"}, "en"),
        (("--language", "ja"), "en", {"LANG": "C"}, "ja"),
    ],
)
def test_the_option_goes_before_the_project_and_that_before_the_locale(
    project: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    option: tuple[str, ...],
    of_project: str | None,
    locale: dict[str, str],
    language: str,
) -> None:
    if of_project is not None:
        text = f'[rtgen]\nlanguage = "{of_project}"\n'
        (project / "rtgen.toml").write_text(text, encoding="utf-8")
    for name, value in locale.items():
        monkeypatch.setenv(name, value)
    text = said(capfd, *option)
    assert ("エラー[IDL0202]" in text) == (language == "ja")
    assert ("error[IDL0202]" in text) == (language == "en")


def test_the_option_of_the_program_holds_for_its_command(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["--language", "ja", "inspect", "wheel.idl"]) == 2
    assert "エラー 1 件" in capfd.readouterr().err
    assert "1 error" in said(capfd)


@pytest.mark.parametrize("form", ["json", "sarif", "github"])
def test_machine_formats_stay_english(
    project: Path, capfd: pytest.CaptureFixture[str], form: str
) -> None:
    english = said(capfd, "--diagnostics", form)
    assert said(capfd, "--diagnostics", form, "--language", "ja") == english
    assert english.isascii()


def test_a_language_that_a_project_cannot_choose_is_reported(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (project / "rtgen.toml").write_text('[rtgen]\nlanguage = "fr"\n', encoding="utf-8")
    assert run(["generate"]) == 2
    assert "'language' in [rtgen] must be one of 'en', 'ja'" in capfd.readouterr().err


def test_the_language_of_a_command_ends_with_it(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A program that runs commands, and a locale that changes, have no texts of an earlier one."""
    (project / "rtgen.toml").write_text('[rtgen]\nlanguage = "ja"\n', encoding="utf-8")
    for options in ((), ("--language", "ja"), ("--no-such", "--language", "ja")):
        run(["inspect", "wheel.idl", *options])
        assert translation.translated("1 error") == "1 error"
    monkeypatch.setenv("LANG", "ja_JP.UTF-8")
    assert translation.translated("1 error") == "エラー 1 件"


def test_explain_and_help_are_japanese(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "CDL0201", "--language", "ja"]) == 0
    page = capfd.readouterr().out
    assert page.startswith("# CDL0201: セミコロンがない\n\n文は、")
    assert "```cdl\n" in page
    assert run(["--language", "ja", "--help"]) == 0
    assert "定義からファイルを生成する。" in capfd.readouterr().out
    assert run(["explain", "--language", "ja"]) == 0
    assert "CDL0201  エラー   セミコロンがない" in capfd.readouterr().out


def test_no_paragraph_of_a_page_is_translated_in_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A page has no insertions; what the catalogue does not have stays English, and says so."""
    monkeypatch.setattr(translation._Choice, "language", "ja")
    texts = {*catalogue("ja")._plain.values()}
    for rule in rules().values():
        english = {*paragraphs(rule.explanation)}
        _, *shown = paragraphs(story(rule))
        assert not {*shown} - english - texts, rule.code
        is_english = {*shown} & english == english
        assert ("この説明はまだ英語だけです。" in shown) == is_english, rule.code


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("--help", "--language", "ja"), 0, "使い方: rtgen [OPTIONS]"),
        (("--language=ja", "run", "--help"), 0, "使い方: rtgen run [OPTIONS]"),
        (("run", "--help", "--language=ja"), 0, "使い方: rtgen run [OPTIONS]"),
        (("can", "--language", "ja", "--help"), 0, "使い方: rtgen can [OPTIONS]"),
        (("run", "--no-such", "--language", "ja"), 2, "エラー: オプション '--no-such'"),
        (("no-such", "--language", "ja"), 2, "エラー: コマンド 'no-such' はありません"),
        (("run", "--rate", "x", "--language", "ja"), 2, "'x' は数ではありません"),
        (("--language", "ja", "can", "sdo"), 2, "エラー: 引数 "),
        (("diff", "a", "b", "c", "--language", "ja"), 2, "比較するのは二つの版"),
    ],
)
def test_help_and_errors_of_usage_do_not_wait_for_the_option(
    project: Path,
    capfd: pytest.CaptureFixture[str],
    arguments: tuple[str, ...],
    code: int,
    text: str,
) -> None:
    assert run(arguments) == code
    printed = capfd.readouterr()
    assert text in printed.out + printed.err
    assert not re.search("Usage|Error|Try ", printed.out + printed.err)


def test_help_fits_the_terminal(capfd: pytest.CaptureFixture[str]) -> None:
    commands: list[tuple[str, ...]] = [(), *((name,) for name in COMMANDS)]
    commands += [("can", name) for name in ("scan", "sdo", "send", "replay")]
    for name in commands:
        assert run([*name, "--help", "--language", "ja"]) == 0
        lines = capfd.readouterr().out.split("\n")
        examples = (line for line in lines if not line.startswith("例: "))
        widest = max(examples, key=columns.columns)
        assert columns.columns(widest) <= 80, widest
        assert not any(line.lstrip().startswith(("、", "。")) for line in lines)


@pytest.mark.parametrize(
    ("text", "width", "lines"),
    [
        ("", 10, []),
        ("one two three", 8, ["one two", "three"]),
        ("車輪の速度。次", 8, ["車輪の速", "度。次"]),
        ("車輪の速度、次", 10, ["車輪の速", "度、次"]),
        ("rtgen.toml の値", 12, ["rtgen.toml", "の値"]),
    ],
)
def test_lines_of_a_paragraph(text: str, width: int, lines: list[str]) -> None:
    assert columns.wrapped(text, width) == lines


def test_english_runs_load_no_catalogue(project: Path) -> None:
    code = (
        "import sys\nfrom rtgen.cli import run\nrun(['inspect', 'wheel.idl'])\n"
        "print(*(m for m in sys.modules if m.endswith(('.catalogue', '.blocks'))"
        " and 'translation' in m))"
    )
    done = _python("-c", code)
    assert b"error[IDL0202]" in done.stderr
    assert done.stdout.split() == []


def test_terminals_of_cp932_get_what_they_can_show(project: Path) -> None:
    """Characters that the encoding lacks are replaced, on both streams."""
    (project / "wheel.idl").write_text(
        f"{BROKEN}struct Größe☃ {{ long a; }};\n", encoding="utf-8"
    )
    for name in ("inspect", "explain"):
        arguments = {"inspect": ["wheel.idl"], "explain": []}[name]
        done = _python(
            "-m",
            "rtgen",
            "--language",
            "ja",
            name,
            *arguments,
            PYTHONIOENCODING="cp932",
        )
        assert b"Traceback" not in done.stderr
        text = (done.stderr + done.stdout).decode("cp932")
        assert "エラー" in text
        if name == "inspect":
            assert "Gr??e?" in text.replace("\N{REPLACEMENT CHARACTER}", "?")


def _python(*arguments: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    variables = {**os.environ, "LC_ALL": "C.UTF-8", **environment}
    return subprocess.run(
        [sys.executable, *arguments], env=variables, capture_output=True, check=False
    )


@pytest.mark.parametrize(
    ("encoding", "text", "shown"),
    [
        ("cp932", "╭─╮ → 5 µm² · 2\N{EN DASH}3 …", "┌─┐ → 5 μm2 ・ 2-3 …"),
        ("cp932", "車輪 Größe ☃", "車輪 Gr??e ?"),
        ("euc_jp", "╔═╗", "┏━┓"),
        ("ascii", "│→ •\N{NO-BREAK SPACE}✔", "|> * ?"),
    ],
)
def test_signs_that_an_encoding_lacks(encoding: str, text: str, shown: str) -> None:
    assert text.encode(encoding, registered()).decode(encoding) == shown


def test_carets_are_below_the_characters_that_they_mark(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    lines = said(capfd, "--language", "ja").split("\n")
    source = next(line for line in lines if "車輪" in line)
    carets = lines[lines.index(source) + 1]
    assert columns.columns(source[: source.index("Wheel")]) == carets.index("^")
    assert carets.count("^") == len("Wheel")


@pytest.mark.parametrize(
    ("text", "width"),
    [
        ("", 0),
        ("abc", 3),
        ("車輪", 4),
        ("ｱｲｳ", 3),
        ("\N{FULLWIDTH LATIN CAPITAL LETTER A}", 2),
        ("e\N{COMBINING ACUTE ACCENT}", 1),
        ("か\N{COMBINING KATAKANA-HIRAGANA VOICED SOUND MARK}", 2),
        ("a\N{ZERO WIDTH JOINER}b", 2),
        ("°", 1),
    ],
)
def test_columns_of_a_text(text: str, width: int) -> None:
    assert columns.columns(text) == width


def test_ambiguous_characters_are_wide_on_terminals_of_cp932() -> None:
    code = (
        "from rtgen.facts.columns import columns\n"
        "print(columns('°±'), columns('°±', on_terminal=False), columns('m²µ'))"
    )
    for encoding, widths in (
        ("cp932", [b"4", b"2", b"4"]),
        ("utf-8", [b"2", b"2", b"3"]),
    ):
        assert _python("-c", code, PYTHONIOENCODING=encoding).stdout.split() == widths
    assert unicodedata.east_asian_width("°") == "A"


def test_columns_of_a_table_are_aligned() -> None:
    rows = [("name", "n"), ("左の車輪", "10"), ("arm", "7")]
    lines = columns.table(rows, right=(1,))
    assert lines == ["name       n", "左の車輪  10", "arm        7"]
    assert {columns.columns(line) for line in lines} == {12}


def test_a_stored_answer_is_in_the_language_of_its_call(project: Path) -> None:
    (project / "rtgen.toml").write_text('[sources]\npaths = ["wheel.idl"]\n', "utf-8")
    own = {"RTGEN_CACHE_DIR": str(project / "cache"), "LC_ALL": ""}
    for language in ("en", "ja", "en"):
        locale = {"en": "en_US.UTF-8", "ja": "ja_JP.UTF-8"}[language]
        done = _python("-m", "rtgen", "check", LC_MESSAGES=locale, **own)
        assert ("エラー" in done.stderr.decode()) == (language == "ja")
    (project / "rtgen.toml").write_text(
        '[rtgen]\nlanguage = "ja"\n[sources]\npaths = ["wheel.idl"]\n', "utf-8"
    )
    done = _python("-m", "rtgen", "check", LC_MESSAGES="en_US.UTF-8", **own)
    assert "エラー" in done.stderr.decode()
