"""The parser on lark's tables returns the results of lark itself."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from lark import Lark, Token, Tree

from rtgen.compiler.frontends.idl.syntax.keywords import RESERVED, TERMINALS
from rtgen.compiler.frontends.idl.text.predefined import predefined
from rtgen.compiler.frontends.idl.text.preprocessor import Preprocessor
from rtgen.compiler.frontends.idl.text.source import Library
from rtgen.compiler.frontends.kit import grammars, lalr, lalr_tables
from rtgen.compiler.kit.resources import grammar_file

ROOT = Path(__file__).parents[2]
FILES = [*ROOT.glob("specs/**/*.idl"), *ROOT.glob("tests/golden/idl/*.idl")]

SMALL = r"""
specification: statement*
statement: "let" IDENT "=" _values ";"     -> let
         | PRINT IDENT ";"                 -> show
_values: value ("," value)*
?value: IDENT | NUMBER | "(" value ")"
PRINT: "print"
OPTION.2: /option(?=\s*;)/
last: OPTION
IDENT: /[^\W\d]\w*/
NUMBER: /\d+/
%ignore /\s+/
"""


class Plain:
    """A builder whose values show the shape of the tree."""

    def __getattr__(self, name: str) -> Callable[[list[Any]], Any]:
        return lambda children: (name, *children)


def plain(tree: Tree[Token] | Token) -> Any:
    if isinstance(tree, Token):
        return str(tree)
    return (str(tree.data), *map(plain, tree.children))


@pytest.fixture(scope="module")
def tables() -> dict[str, Any]:
    return lalr_tables.make(SMALL)


def parse(tables: dict[str, Any], text: str) -> Any:
    return lalr.Parser(lalr.Grammar(tables, Plain(), frozenset({"let"})), text).run()


def test_keywords_are_names_where_only_a_name_can_stand(tables: dict[str, Any]) -> None:
    assert parse(tables, "let print = option, (2); print print;") == (
        "specification",
        ("let", "print", "option", "2"),
        ("show", "print", "print"),
    )


def test_reserved_words_never_are(tables: dict[str, Any]) -> None:
    with pytest.raises(lalr.UnexpectedTokenError) as error:
        parse(tables, "let let = 1;")
    assert (error.value.token.type, error.value.token.start_pos) == ("LET", 4)


def test_a_character_of_no_terminal(tables: dict[str, Any]) -> None:
    parser = lalr.Parser(lalr.Grammar(tables, Plain(), frozenset()), "let a = $1;")
    with pytest.raises(lalr.UnexpectedCharacterError):
        parser.run()
    assert parser.position == 8
    assert parser.accepts() == {"IDENT", "NUMBER", "LPAR"}
    parser.position += 1
    assert parser.run() == ("specification", ("let", "a", "1"))


def test_a_missing_token_can_be_fed(tables: dict[str, Any]) -> None:
    parser = lalr.Parser(lalr.Grammar(tables, Plain(), frozenset()), "let a = 1")
    with pytest.raises(lalr.UnexpectedTokenError):
        parser.run()
    assert parser.accepts() == {"COMMA", "SEMICOLON"}
    parser.feed(lalr.token("SEMICOLON", 9, ";"))
    assert parser.run() == ("specification", ("let", "a", "1"))


@pytest.mark.parametrize("damage", ["", "[]", '{"key": "another"}', "{"])
def test_tables_of_another_grammar_are_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    grammar = tmp_path / "small.lark"
    grammar.write_text(SMALL)
    grammar.with_suffix(".json").write_text(damage)
    monkeypatch.setattr(grammars, "grammar_file", lambda name: tmp_path / name)
    made = grammars.load("small", Plain(), frozenset())
    assert lalr.Parser(made, "print x;").run() == (
        "specification",
        ("show", "print", "x"),
    )


def test_tables_are_the_same_from_the_file(
    tmp_path: Path, tables: dict[str, Any]
) -> None:
    grammar = tmp_path / "small.lark"
    grammar.write_text(SMALL)
    lalr_tables.write(grammar)
    read = json.loads(grammar.with_suffix(".json").read_text())
    assert parse(read, "let a = b;") == parse(tables, "let a = b;")


@pytest.fixture(scope="module")
def peer() -> Lark:
    """Return lark's own parser and contextual lexer."""

    def reserve(token: Token) -> Token:
        if token in RESERVED:
            token.type = TERMINALS[token]
        return token

    class Names:
        always_accept = ("IDENT",)

        def process(self, stream: Any) -> Any:
            return stream

    return Lark(
        grammar_file("idl.lark").read_text(encoding="utf-8"),
        parser="lalr",
        start="specification",
        postlex=Names(),
        lexer_callbacks={"IDENT": reserve},
        maybe_placeholders=False,
    )


@pytest.fixture(scope="module")
def ours() -> lalr.Grammar:
    return grammars.load("idl", Plain(), RESERVED)


@pytest.mark.sampled(20)
@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.name))
def test_every_definition_file_has_the_tree_that_lark_gives(
    path: Path, peer: Lark, ours: lalr.Grammar
) -> None:
    library = Library(ROOT, [])
    source = library.open(path)
    assert source is not None
    unit = Preprocessor(library).translation_unit(source, predefined({}))
    assert lalr.Parser(ours, unit.text).run() == plain(peer.parse(unit.text))


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["idl", "cdl"])
def test_tables_do_not_depend_on_hashes(name: str) -> None:
    """States are numbered in the order of a traversal; lark's numbers follow the order of a set."""
    tables = lalr_tables.make(grammar_file(f"{name}.lark").read_text("utf-8"))
    met = [tables["start"]]
    for state in met:
        for _, arg in sorted(tables["actions"][state].items()):
            if arg >= 0 and arg not in met:
                met.append(arg)
    final = len(tables["actions"]) - 1
    assert [state for state in met if state != final] == list(range(final))
