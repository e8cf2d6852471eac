"""The preprocessor alone: texts, conditions, macros, and positions in the source."""

from pathlib import Path

import pytest

from rtgen.compiler.frontends.idl.text import conditions
from rtgen.compiler.frontends.idl.text.macros import (
    Expander,
    ExpansionError,
    define,
    tokenize,
)
from rtgen.compiler.frontends.idl.text.predefined import predefined
from rtgen.compiler.frontends.idl.text.preprocessor import Preprocessor
from rtgen.compiler.frontends.idl.text.source import Library
from rtgen.compiler.frontends.idl.text.unit import Unit


def unit_of(folder: Path, text: str) -> Unit:
    path = folder / "input.idl"
    path.write_text(text, encoding="utf-8")
    library = Library(folder, [])
    source = library.open(path)
    assert source is not None
    unit = Preprocessor(library).translation_unit(source, predefined({}))
    assert unit.findings.diagnostics == ()
    return unit


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1", True),
        ("0", False),
        ("1 + 2 * 3 == 7", True),
        ("(1 || 0) && !(2 > 3)", True),
        ("defined A && defined(B) == 0", True),
        ("A == 5", True),
        ("UNKNOWN", False),
        ("0 && 1 / 0", False),
        ("-7 / 2 == -3", True),
        ("0x10 == 16 && 010 == 8 && 10L == 10", True),
        ("1 ? 0 : 1", False),
        ("'a' == 97", True),
        ("~0 == -1", True),
        ("-1 > 0u", True),
        ("1 ? -1 > 0 : 0u", False),
        ("(1 ? -1 : 0u) > 0", True),
        ("-1 >> 1u < 0", True),
        ("-7 % 4u == 1", True),
        ("0x8000000000000000 > 0 && 18446744073709551615 + 1 == 0", True),
        ("1 << 4 >> 2 == 4", True),
    ],
)
def test_conditions(expression: str, expected: bool) -> None:
    assert conditions.evaluate(expression, {"A": define("A 5")}) is expected


@pytest.mark.parametrize(
    "expression", ["", "1 +", "(1", "1 / 0", '"a"', "1 2", "defined", "1 ? 2"]
)
def test_bad_conditions(expression: str) -> None:
    with pytest.raises(ExpansionError):
        conditions.evaluate(expression, {})


@pytest.mark.parametrize(
    ("definitions", "text", "expected"),
    [
        (["A B", "B 1"], "A", "1"),
        (["A A B", "B A"], "A", "A A"),
        (["F(x) [x]"], "F((1, 2)) F", "[(1, 2)] F"),
        (["F(x, y) y x"], "F(1, F(2, 3))", "3 2 1"),
        (["Q(x) #x"], 'Q(a  "b")', '"a \\"b\\""'),
        (["J(a, b) a##b", "X 1"], "J(X, 2)", "X2"),
        (["J(a) a ## 1 ## 2"], "J(b)", "b12"),
        (["F() 1"], "F()", "1"),
        (["F(x) x", "G F"], "G(2)", "2"),
    ],
)
def test_macros(definitions: list[str], text: str, expected: str) -> None:
    macros = {macro.name: macro for macro in map(define, definitions)}
    tokens = Expander(macros).expand(tokenize(text))
    assert "".join(token.text for token in tokens) == expected


@pytest.mark.parametrize(
    "text", ["", "3", "F(", "F(a, a) 1", "F(1) 2", "A ## b", "A b ##"]
)
def test_bad_definitions(text: str) -> None:
    with pytest.raises(ExpansionError):
        define(text)


def test_positions_lead_back_to_the_source(tmp_path: Path) -> None:
    unit = unit_of(
        tmp_path, "#define N 12345\nconst \\\n  long A = N;\nconst long B = 2;"
    )
    expansion = unit.text.index("12345")
    span = unit.span(expansion, expansion + 5)
    assert (span.line, span.column, span.end_column) == (3, 12, 13)
    name = unit.text.index("A")
    assert (unit.span(name, name + 1).line, unit.span(name, name + 1).column) == (3, 8)
    last = unit.text.index("B")
    assert (unit.span(last, last + 1).line, unit.span(last, last + 1).column) == (4, 12)


def test_comments_are_blank_and_kept(tmp_path: Path) -> None:
    unit = unit_of(tmp_path, 'a /* one\ntwo */ b // three\n"/* text */" c')
    assert unit.text.split() == ["a", "b", '"/*', "text", '*/"', "c"]
    assert [comment.text for comment in unit.comments] == ["/* one\ntwo */", "// three"]


def test_line_and_file(tmp_path: Path) -> None:
    unit = unit_of(tmp_path, "\n__LINE__ __FILE__")
    assert unit.text.split()[0] == "2"
    assert unit.text.split()[1].endswith('input.idl"')


def test_pragmas_are_handed_on(tmp_path: Path) -> None:
    unit = unit_of(tmp_path, "a\n#pragma DCPS_DATA_TYPE x\nb")
    (pragma,) = unit.events
    assert getattr(pragma, "text", "") == "DCPS_DATA_TYPE x"
    assert unit.text[: pragma.offset].split() == ["a"]
