"""Limits of the formatter: the nesting that the front ends allow, linear work, bounded results."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends import cdl, idl
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.tools.fmt import edits, format_text
from rtgen.tools.fmt.layout import MAX_CHARACTERS
from rtgen.tools.fmt.tokens import MAX_TOKENS, Language, LexicalError

IDL, CDL = Language.IDL, Language.CDL
INNER = "const int32_t A = 1;\n"
Text = Callable[[int], str]

NESTED: dict[str, tuple[Language, Text]] = {
    "modules": (IDL, lambda n: "module M {\n" * n + "const long A = 1;\n" + "};\n" * n),
    "sequences": (IDL, lambda n: f"typedef {'sequence<' * n}long{'> ' * n} T;\n"),
    "parentheses": (IDL, lambda n: f"const long X = {'(' * n}1{')' * n};\n"),
    "conditions": (
        IDL,
        lambda n: "#if 1\n" * n + "const long A = 1;\n" + "#endif\n" * n,
    ),
    "namespaces": (CDL, lambda n: "namespace nN {\n" * n + INNER + "};\n" * n),
    "parentheses of CDL": (
        CDL,
        lambda n: f"const int32_t X = {'(' * n}1{')' * n};\n",
    ),
    "initializers": (
        CDL,
        lambda n: f"const int32_t X = {'{' * n}1{'}' * n};\n",
    ),
    "composites": (
        CDL,
        lambda n: "composite tC {\n" * n + INNER + "};\n" * n,
    ),
}


@pytest.mark.sampled(1)
@pytest.mark.parametrize("kind", NESTED)
def test_what_the_front_ends_take_is_formatted(kind: str, tmp_path: Path) -> None:
    language, text = NESTED[kind]
    load: Any = idl.load if language is IDL else cdl.load
    for depth in (50, *range(MAX_NESTING - 3, MAX_NESTING + 4), 3 * MAX_NESTING):
        file = tmp_path / f"a.{language.value}"
        file.write_text(text(depth))
        found = load([file], root=tmp_path).diagnostics
        if depth <= MAX_NESTING or kind == "conditions":
            new = format_text(text(depth), language)
            assert format_text(new, language) == new
        else:
            with pytest.raises(LexicalError, match=f"more than {MAX_NESTING} levels"):
                format_text(text(depth), language)
            assert has_errors(found)


def test_the_place_of_a_bracket_too_many() -> None:
    with pytest.raises(LexicalError) as raised:
        format_text(NESTED["parentheses"][1](100_000), IDL)
    assert raised.value.start == len("const long X = ") + MAX_NESTING


REPEATED: dict[str, tuple[Language, Text]] = {
    "open parentheses": (
        IDL,
        lambda n: f"const long X = {'(' * (MAX_NESTING - 1)}{'1+' * n}",
    ),
    "pairs of parentheses": (IDL, lambda n: "a " + "() " * n),
    "blocks": (IDL, lambda n: "a " + "{} " * n),
    "blocks with words": (
        IDL,
        lambda n: "".join(f"a{i} " for i in range(n)) + "{a} " * n,
    ),
    "deep blocks": (IDL, lambda n: "struct S { " * (MAX_NESTING - 1) + "} " * n),
    "comments": (IDL, lambda n: f"a {'/**/ ' * n};"),
    "comments after a block": (IDL, lambda n: "a }" + "/**/ " * n + ";"),
    "comments of several lines": (IDL, lambda n: "a " + "/* \n */ " * n + ";"),
    "comments after a line": (IDL, lambda n: "a; " + "/*\n*/" * n),
    "numbers": (IDL, lambda n: "5 " * n),
    "strings": (IDL, lambda n: '"a" ' * n),
    "labels": (IDL, lambda n: "union U switch (long) {" + "case 1: " * n),
    "annotations": (IDL, lambda n: "@a() " * n),
    "templates": (
        IDL,
        lambda n: "typedef " + "sequence<" * (MAX_NESTING - 1) + ">>" * n,
    ),
    "angle brackets": (CDL, lambda n: "a < " * n),
    "angle brackets in lines": (CDL, lambda n: "a <\n" * n),
    "continued strings": (CDL, lambda n: '"\\\n" ' * n),
    "specifiers": (CDL, lambda n: "[a] " * n),
    "conditions": (
        IDL,
        lambda n: "#if 1\na\n#else\nb\n#endif\n" * n,
    ),
    "deep conditions": (IDL, lambda n: "#if 1\na\n#else\n" * n),
    "skipped conditions": (IDL, lambda n: "#if 0\n#endif\n" * n),
}


def lines_of_code(language: Language, text: str) -> int:
    """Return the number of lines of the formatter that are executed."""
    number = 0

    def count(frame: FrameType, event: str, argument: object) -> Any:
        nonlocal number
        number += event == "line"
        return count

    before = sys.gettrace()
    sys.settrace(count)
    try:
        edits(text, language)
    finally:
        sys.settrace(before)
    return number


@pytest.mark.sampled(3)
@pytest.mark.parametrize("kind", REPEATED)
def test_the_work_is_linear(kind: str) -> None:
    language, text = REPEATED[kind]
    once = lines_of_code(language, text(250))
    assert lines_of_code(language, text(500)) < 2.2 * once


@pytest.mark.nightly
@pytest.mark.parametrize("kind", REPEATED)
def test_long_texts_are_formatted(kind: str) -> None:
    """Work that no line of Python shows, such as searches in the rest of a text."""
    language, text = REPEATED[kind]
    # The stars of comments that follow each other are aligned, each further to the right.
    with suppress(LexicalError):
        edits(text(20_000), language)


@pytest.mark.nightly
def test_results_are_bounded() -> None:
    with pytest.raises(LexicalError, match="the file has more than 1,000,000 tokens"):
        format_text(";" * (MAX_TOKENS + 1), IDL)
    lines = MAX_CHARACTERS // (4 * MAX_NESTING) + 1
    with pytest.raises(LexicalError, match="formatted text has more than 33,554,432"):
        format_text("module M {\n" * MAX_NESTING + ";\n" * lines, IDL)


def test_formatting_can_be_ended() -> None:
    checks = 0

    def check() -> None:
        nonlocal checks
        checks += 1
        if checks == 100:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        edits("a;\n" * 100_000, IDL, check=check)
