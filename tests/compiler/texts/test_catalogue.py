"""The Japanese catalogue is complete for its rules, and follows the English texts.

`python tests/compiler/texts/update.py` brings the catalogue to the texts of the sources; what it
adds is empty, and these tests fail until it is translated.
"""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import extraction
import pytest
import update
from babel.messages.catalog import Catalog
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po
from update import CONTEXTS, beside_rules, texts, texts_of

from rtgen.compiler.kit.translation.catalogue import (
    FOLDER,
    PAGE,
    SERVER,
    WORD,
    Catalogue,
)

JA = FOLDER / "ja" / "LC_MESSAGES" / "rtgen.po"
GOLDEN = extraction.ROOT / "tests" / "golden"
LEAST_RULES = 200
HEAD = re.compile(r"(?:.*?:\d+:\d+: )?(?:error|warning|note)\[([A-Z]+\d{4})\]: (.*)")
RELATED = re.compile(r".*?:\d+:\d+: note: (.*)")
HINT = "  hint: "
PROSE = re.compile(r"[a-z]{2,}[ -][a-z]{2,}")
OF_USERS = (
    "fathoms per day",
    "no fan here",
    "not for this board",
    "scaled in the motor",
    "the motor goes 1 m in each second",
)
"""Texts that inputs of golden cases have."""
OF_LIBRARIES = ("Missing type in declaration", "at the end of a table declaration")
QUOTED = re.compile(r"'[^']*'|`[^`]*`|\"[^\"]*\"|\([^)]*\)|--\w+ [\w-]+")
ENGLISH = re.compile(
    r"\b[a-z]{2,} (?:the|is|are|not|of|to|by|it|be|must|has|have) [a-z]{2,}\b"
)


@cache
def ja() -> Catalog:
    with JA.open("rb") as file:
        return read_po(file, abort_invalid=True)


@cache
def catalogue() -> Catalogue:
    return Catalogue(
        {str(m.id): str(m.string) for m in ja() if m.id and m.string and not m.context}
    )


def covered() -> set[str]:
    """Return the codes of the rules that the catalogue has: its titles name them."""
    return {
        code for m in ja() for comment in m.auto_comments for code in comment.split()
    }


def test_the_rules_of_the_catalogue_are_written_in_japanese() -> None:
    entries = {m.id for m in ja() if m.string and not m.context}
    rules = covered()
    assert [text for text in texts_of(rules) if text not in entries] == []
    assert len(rules) >= LEAST_RULES


def test_entries_follow_the_english_texts() -> None:
    """An entry whose English text was changed, or is gone, has to be translated anew."""
    known = texts(None)
    assert [m.id for m in ja() if m.id and not m.context and m.id not in known] == []
    assert not ja().obsolete
    assert {m.context for m in ja()} == {None, *CONTEXTS}


def test_what_is_said_beside_rules_is_in_the_catalogue() -> None:
    """Titles of all rules, help, and what commands print that are no diagnostics."""
    entries = {str(m.id) for m in ja() if m.string and not m.context}
    assert sorted(beside_rules() - entries) == []


def test_errors_that_messages_end_with_are_in_the_catalogue() -> None:
    """What is raised with a text for people, and what systems say of files and connections."""
    english = {}
    systems = map(os.strerror, extraction.OF_SYSTEMS)
    for template in extraction.raised_texts().union(map(extraction.plain, systems)):
        text = template.format(*(f"'v{number}'" for number in range(20)))
        japanese = catalogue().translated(text)
        if PROSE.search(QUOTED.sub("", text)) and (
            japanese == text or ENGLISH.search(QUOTED.sub("", japanese))
        ):
            english[template] = japanese
    assert not english


def test_words_that_stand_alone_are_in_the_catalogue() -> None:
    entries = {str(m.id) for m in ja() if m.string and m.context == WORD}
    assert entries == extraction.words_alone()


def test_what_the_server_of_a_page_says_is_written_in_japanese() -> None:
    entries = {str(m.id) for m in ja() if m.context == SERVER}
    assert entries == extraction.said_by_server()


def test_without_the_packages_of_the_page_its_entries_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def page() -> None:
        raise LookupError("no packages")

    file = tmp_path / JA.name
    file.write_text(
        'msgid ""\nmsgstr ""\n\n'
        'msgctxt "page"\nmsgid "Of an earlier page"\nmsgstr "x"\n\n'
        'msgctxt "word"\nmsgid "Of no source"\nmsgstr "x"\n',
        encoding="utf-8",
    )
    monkeypatch.setattr(extraction, "page", page)
    monkeypatch.setattr(update, "FOLDER", tmp_path)
    update.main()
    assert "no packages" in capsys.readouterr().err
    with file.open("rb") as stream:
        catalogue = read_po(stream)
    assert catalogue.get("Of an earlier page", PAGE) is not None
    assert catalogue.get("Of no source", WORD) is None


@pytest.fixture
def page() -> dict[str, list[tuple[str, str]]]:
    try:
        return extraction.page()
    except LookupError as error:
        pytest.skip(str(error))


@pytest.mark.peer
def test_each_text_of_the_page_goes_through_the_catalogue(
    page: dict[str, list[tuple[str, str]]],
) -> None:
    """A text of JSX, of a seen attribute, or with words, which is no argument of `t` or `rich`."""
    assert page["flaws"] == []


@pytest.mark.peer
def test_the_texts_of_the_page_are_those_of_the_catalogue(
    page: dict[str, list[tuple[str, str]]],
) -> None:
    english = {text for _, text in page["texts"]}
    assert {str(m.id) for m in ja() if m.context == PAGE} == english


def test_no_entry_is_empty_or_fuzzy() -> None:
    assert [m.id for m in ja() if m.id and (m.fuzzy or not m.string)] == []


def test_translations_have_the_insertions_of_their_texts() -> None:
    differing = [
        (m.id, m.string)
        for m in ja()
        if m.id
        and extraction.placeholders(str(m.id)) != extraction.placeholders(str(m.string))
    ]
    assert not differing


def test_code_in_a_text_stays() -> None:
    """What is in backquotes is code, so it is the same in both languages."""
    code = re.compile(r"`[^`]+`")
    changed = [
        (m.id, m.string)
        for m in ja()
        if m.id and set(code.findall(str(m.id))) != set(code.findall(str(m.string)))
    ]
    assert not changed


def test_the_compiled_catalogue_is_that_of_the_text() -> None:
    compiled = io.BytesIO()
    write_mo(compiled, ja())
    file = JA.with_suffix(".mo")
    assert file.read_bytes() == compiled.getvalue(), "run `make` to install rtgen again"


def _shown() -> Iterator[tuple[Path, str, str]]:
    """Yield the messages, labels and hints that the golden cases show, with their codes."""
    for file in sorted(GOLDEN.rglob("*.txt")):
        if "input" in file.parts:
            continue
        code = None
        for line in file.read_text(encoding="utf-8", errors="replace").split("\n"):
            if head := HEAD.fullmatch(line):
                code = head[1]
                yield file, code, head[2]
            elif code is not None and line.startswith(HINT):
                yield file, code, line.removeprefix(HINT)
            elif code is not None and (related := RELATED.fullmatch(line)):
                yield file, code, related[1]


@pytest.mark.nightly
def test_what_the_golden_cases_show_is_said_in_japanese() -> None:
    """Of all codes, also of those whose pages for `rtgen explain` are English."""
    english = {}
    for file, code, text in _shown():
        for users in (*OF_USERS, *OF_LIBRARIES):
            text = text.replace(users, "")
        if PROSE.search(QUOTED.sub("", text)):
            japanese = catalogue().translated(text)
            if japanese == text or ENGLISH.search(QUOTED.sub("", japanese)):
                english[code, text] = (file.parent.name, japanese)
    assert not english


@pytest.mark.parametrize(
    ("english", "japanese"),
    [
        ("/x: No such file or directory", "/x: ないファイルかフォルダ"),
        ("'of' is a keyword or a name of Python", "'of' は Python の語か名前"),
        ("no port 'x'; known: a or b", "ポート 'x' なし。既知: a か b"),
        ("a.rate: is one of 1, 2", "a.rate は 1, 2 の一つ"),
    ],
)
def test_the_least_of_a_text_stays_english(english: str, japanese: str) -> None:
    """Of the ways to read a text, that is taken which has the shortest values."""
    sample = Catalogue(
        {
            "{0} or {1}": "{0} か {1}",
            "{0} of {1}": "{1} の {0}",
            "{0} is {1}": "{0} は {1}",
            "a {0}": "{0}",
            "{0}: {1}": "{0}: {1}",
            "{0}; {1}": "{0}。{1}",
            "No such file or directory": "ないファイルかフォルダ",
            "is a keyword or a name of Python": "は Python の語か名前",
            "no port '{0}'": "ポート '{0}' なし",
            "no {0}; known: {1}": "{0} がない。既知: {1}",
            "known: {0}": "既知: {0}",
            "{0}: is one of {1}": "{0} は {1} の一つ",
            "is one of {0}": "は {0} の一つ",
        }
    )
    assert sample.translated(english) == japanese


@pytest.mark.parametrize(
    ("english", "japanese"),
    [
        ("plain", "文"),
        ("no 'x' in a", "a に 'x' がない"),
        ("no 'no 'y' in b' in a", "a に 'b に 'y' がない' がない"),
        ("wrong: plain", "誤り: 文"),
        ("wrong: wrong: plain", "誤り: 誤り: 文"),
        ("wrong: {0}", "誤り: {0}"),
        ("a {brace}", "括弧 {brace}"),
        ("another", "another"),
        ("'a b' is too long", "'a b' は長すぎる"),
        ("'a b' is another", "'a b' is another"),
        ("a sample is {'x': 0, 'y': 1}", "見本は {'x': 0, 'y': 1}"),
        ("a sample is {'x': {'y': 1, ...", "見本は {'x': {'y': 1, ..."),
        ("first, second", "最初、第二"),
        ("", ""),
    ],
)
def test_insertions_are_found_and_inserted(english: str, japanese: str) -> None:
    sample = Catalogue(
        {
            "plain": "文",
            "is too long": "は長すぎる",
            "no '{0}' in {1}": "{1} に '{0}' がない",
            "wrong: {0}": "誤り: {0}",
            "a {{brace}}": "括弧 {{brace}}",
            "{0}{1}": "never {0}{1}",
            "a sample is {0}": "見本は {0}",
            "{0} is {1}, {2}": "{0} は {1}、{2}",
            "first": "最初",
            "second": "第二",
            "{0}, {1}": "{0}、{1}",
        }
    )
    assert sample.translated(english) == japanese


def test_a_hostile_text_takes_time_in_proportion_to_its_length() -> None:
    """A template is compared from left to right once, whatever the insertions contain."""
    sample = Catalogue({"{0} a {1} a {2} a {3} a {4} b": "{0}{1}{2}{3}{4}"})
    text = " a " * 2000
    assert sample.translated(text) == text
