"""The commonest errors: one message each, at the right place, with a useful hint."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random

import pytest
from mistakes import GROUPS, MISTAKES

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl import load

Found = tuple[int, int, str, str]

ALONE = frozenset(
    name
    for name, (text, _, _) in MISTAKES.items()
    if any(word in text for word in ("#", "module", "import", "include", "/*"))
    or text.count("{") != text.count("}")
    or "file scope" in MISTAKES[name][1]
)
"""Errors that affect the rest of the file: directives, braces, comments, file scope."""

TOGETHER = [name for name in MISTAKES if name not in ALONE]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "wheel.idl").write_text("struct Wheel { double radius; };\n")
    (tmp_path / "axle.idl").write_text("struct Axle { double radius; }\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def found(folder: Path, text: str) -> list[Diagnostic]:
    path = Path("input.idl")
    path.write_text(text, encoding="utf-8")
    return list(load([path], root=folder).diagnostics)


def found_as(diagnostic: Diagnostic, folder: Path) -> Found:
    assert diagnostic.span is not None
    hint = (diagnostic.hint or "").replace(folder.as_posix(), "FOLDER")
    return (
        diagnostic.span.line,
        diagnostic.span.column,
        f"{diagnostic.code}: {diagnostic.message}",
        hint.replace("input.idl:", ":"),
    )


def expected(name: str, line: int = 1) -> Found:
    """Return the expected diagnostics of an error whose text starts at a line."""
    text, message, hint = MISTAKES[name]
    before = text.partition("§")[0]
    column = len(before.rpartition("\n")[2]) + 1
    return line + before.count("\n"), column, message, hint.replace("a.idl:", ":")


def test_there_are_enough() -> None:
    assert len(MISTAKES) == sum(map(len, GROUPS)) > 300
    assert len(TOGETHER) > 200


@pytest.mark.parametrize("name", MISTAKES)
def test_one_message(name: str, folder: Path) -> None:
    text, _, hint = MISTAKES[name]
    [diagnostic] = found(folder, text.replace("§", ""))
    assert hint
    assert found_as(diagnostic, folder) == expected(name)


def test_the_last_semicolon_of_an_included_file(folder: Path) -> None:
    [diagnostic] = found(folder, '#include "axle.idl"\nstruct S { Axle a_; };')
    span = diagnostic.span
    assert diagnostic.code == "IDL0101"
    assert span is not None
    assert (span.file, span.line, span.column) == ("axle.idl", 1, 31)


@pytest.mark.parametrize("seed", range(60))
def test_independent_mistakes_are_all_told_and_nothing_else(
    seed: int, folder: Path
) -> None:
    """Several errors, each in a module of its own, with valid declarations between them."""
    names = Random(seed).sample(TOGETHER, 6)
    lines: list[str] = []
    wanted: list[Found] = []
    for number, name in enumerate(names):
        lines.append(f"module M{number} {{")
        wanted.append(expected(name, len(lines) + 1))
        lines += MISTAKES[name][0].replace("§", "").split("\n")
        lines += ["};", f"struct Sound{number} {{ long whole; }};"]
    diagnostics = found(folder, "\n".join(lines))
    places = [found_as(d, folder) for d in diagnostics]
    plain = [(line, column, re.sub(r"\bM\d::", "", m)) for line, column, m, _ in places]
    assert plain == [place[:3] for place in wanted], names


LANGUAGE = Path(__file__).parents[2] / "golden" / "idl" / "language.idl"
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|#[^\n]*|"[^"\n]*"|\w+|::|[^\s\w]', re.DOTALL)


def test_a_changed_token_gives_one_message_or_none(folder: Path) -> None:
    """In a file with every construct: a token left out, doubled, or with two letters swapped."""
    text = LANGUAGE.read_text(encoding="utf-8")
    tokens = [m for m in TOKEN.finditer(text) if m[0][:2] not in ("//", "/*")]
    tokens = [m for m in tokens if m[0][0] != "#"]
    random = Random(3)
    counts = []
    for _ in range(40):
        token = random.choice(tokens)
        word = token[0]
        changed = random.choice(
            ("", f"{word} {word}", word[:1] + word[2:3] + word[1:2] + word[3:])
        )
        mutant = text[: token.start()] + changed + text[token.end() :]
        counts.append(len(found(folder, mutant)))
    assert max(counts) <= 4
    assert sum(count > 1 for count in counts) <= 2
