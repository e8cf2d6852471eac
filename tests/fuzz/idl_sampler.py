"""Texts drawn from the grammar: valid syntax, arbitrary meaning."""

from __future__ import annotations

from collections import defaultdict
from functools import cache
from random import Random
from typing import TYPE_CHECKING

import idl_words as words
from fuzzing import log_uniform

from rtgen.compiler.kit.resources import grammar_file

if TYPE_CHECKING:
    from lark.lexer import TerminalDef

_CHOICES = {
    "IDENT": [*words.NAMES, *words.CONTEXTUAL],
    "NUMBER": words.NUMBERS,
    "STRING": ['"text"', 'L"wide"', '"a\\n" "b"', '""', '"\\xff"'],
    "CHARACTER": ["'c'", "L'c'", "'\\n'", "'\\377'", "L'\\u3042'"],
    "ANNOTATION": [
        "@key",
        "@id",
        "@final",
        "@default",
        "@range",
        "@a::b",
        "@value",
        "@rtc",
    ],
    "ANNOTATION_DCL": ["@annotation"],
    "ADDITIVE": ["+", "-"],
    "MULTIPLICATIVE": ["*", "/", "%"],
    "SHIFT": ["<<", ">>"],
    "GREATER": [">"],
    "TRAILING": [","],
}
_SKIPPED = "ERROR"
_EXPRESSIONS = frozenset(
    "expression xor_expr and_expr shift_expr add_expr mult_expr unary primary".split()
)


class _Grammar:
    """The rules of the grammar by their names, each alternative with its least depth."""

    def __init__(self) -> None:
        from lark import Lark

        parser = Lark(
            grammar_file("idl.lark").read_text(encoding="utf-8"),
            parser="lalr",
            start="specification",
            maybe_placeholders=False,
        )
        self._terminals = {t.name: t for t in parser.terminals}
        self.ways: defaultdict[str, list[tuple[str, ...]]] = defaultdict(list)
        for rule in parser.rules:
            way = tuple(symbol.name for symbol in rule.expansion)
            if _SKIPPED not in way:
                self.ways[rule.origin.name].append(way)
        self.depths: dict[str, int] = {}
        self._measure()
        self.shortest = {
            name: [way for way in ways if self.depth(way) == self.depths[name]]
            for name, ways in self.ways.items()
        }

    def _measure(self) -> None:
        changed = True
        while changed:
            changed = False
            for name, ways in self.ways.items():
                depth = min(map(self.depth, ways))
                if depth < self.depths.get(name, 10**6):
                    self.depths[name] = depth
                    changed = True

    def depth(self, way: tuple[str, ...]) -> int:
        """Return the nesting depth of the shortest text of an alternative."""
        inner = (self.depths.get(n, 10**6) for n in way if n in self.ways)
        return 1 + max(inner, default=0)

    def text(self, terminal: str, chance: Random) -> str:
        """Return a text of a terminal."""
        if terminal in _CHOICES:
            return chance.choice(_CHOICES[terminal])
        definition: TerminalDef = self._terminals[terminal]
        value = definition.pattern.value
        # A word that is a keyword only in its place: its pattern ends in a look-ahead.
        return value.partition("(?")[0] if definition.pattern.type == "re" else value


@cache
def _grammar() -> _Grammar:
    return _Grammar()


def sample(chance: Random) -> list[str]:
    """Return the tokens of a text."""
    found = _grammar()
    tokens: list[str] = []
    pending = [("definition", 0)] * log_uniform(1, 12, chance.random())
    most = log_uniform(30, 1500, chance.random())
    while pending:
        name, level = pending.pop()
        if name not in found.ways:
            tokens.append(found.text(name, chance))
            continue
        ways = found.ways[name]
        plain = name in _EXPRESSIONS and chance.random() < 0.9
        if plain or level > 30 or len(tokens) > most:
            ways = found.shortest[name]
        pending += [(n, level + 1) for n in reversed(chance.choice(ways))]
    return tokens
