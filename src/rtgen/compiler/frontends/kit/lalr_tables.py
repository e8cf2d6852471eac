"""Makes the tables of a grammar, with lark."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from rtgen.compiler.frontends.kit.lalr import END, WORD, key
from rtgen.facts.files import write_atomically

_GUARDED = re.compile(r"(\w+)(\(\?=.*\))", re.DOTALL)
_FREQUENT = (WORD, "LPAR", "RPAR", "SEMI")
"""Terminals that are tried first: no other one can match where one of them does."""


def make(text: str) -> dict[str, Any]:
    """Return the tables of a grammar as plain data, in the form of `lalr.Grammar`.

    `terminals` are in the order in which they are tried. Words are not terminals of the lexer, but
    take precedence over identifiers: `words` always, `guarded` if the text after them matches.
    """
    from lark import Lark
    from lark.lexer import PatternStr

    parser: Any = Lark(text, parser="lalr", start=_START, maybe_placeholders=False)
    table = parser.parser.parser._parse_table
    terminals = {terminal.name: terminal for terminal in parser.terminals}
    ordered = sorted(
        parser.terminals,
        key=lambda t: (
            t.name not in _FREQUENT,
            -t.priority,
            -t.pattern.max_width,
            -len(t.pattern.value),
            t.name,
        ),
    )
    word = re.compile(terminals[WORD].pattern.to_regexp())
    tables: dict[str, Any] = {"words": {}, "guarded": {}, "terminals": {}}
    for terminal in ordered:
        pattern = terminal.pattern
        guarded = _GUARDED.fullmatch(pattern.value)
        if terminal.name in parser.ignore_tokens:
            continue
        if isinstance(pattern, PatternStr) and word.fullmatch(pattern.value):
            tables["words"][pattern.value] = terminal.name
        elif guarded is not None and word.fullmatch(guarded[1]):
            tables["guarded"][guarded[1]] = [terminal.name, guarded[2]]
        else:
            tables["terminals"][terminal.name] = pattern.to_regexp()
    ignored = [terminals[name].pattern.to_regexp() for name in parser.ignore_tokens]
    rules = {rule: number for number, rule in enumerate(parser.rules)}
    numbers = _numbers(table)
    actions = [_row(table.states[state], rules, numbers) for state in numbers]
    actions[numbers[table.end_states[_START]]][END] = len(actions)
    return tables | {
        "key": key(text),
        "ignored": f"(?:{'|'.join(ignored)})?",
        "rules": [_rule(rule) for rule in parser.rules],
        "actions": [*actions, {}],
        "start": numbers[table.start_states[_START]],
    }


_START = "specification"


def _numbers(table: Any) -> dict[int, int]:
    """Number the states in the order of a traversal: lark's own numbers depend on hashes."""
    numbers = {table.start_states[_START]: 0}
    for state in (waiting := [*numbers]):
        for _, (_, arg) in sorted(table.states[state].items()):
            if isinstance(arg, int) and arg not in numbers:
                numbers[arg] = len(numbers)
                waiting.append(arg)
    return numbers


def _row(
    row: dict[str, Any], rules: dict[Any, int], numbers: dict[int, int]
) -> dict[str, int]:
    """Return the actions of a state: the next state, or the complement of a rule's number."""
    return {
        symbol: numbers[arg] if isinstance(arg, int) else ~rules[arg]
        for symbol, (_, arg) in sorted(row.items())
    }


def _rule(rule: Any) -> list[Any]:
    """Return a rule in the form of `lalr`; the value of a rule `_name` is spread."""
    name = str(rule.alias or rule.origin.name)
    indices = [
        (index, not part.is_term and part.name.startswith("_"))
        for index, part in enumerate(rule.expansion)
        if not (part.is_term and part.filter_out)
    ]
    whole = len(indices) == len(rule.expansion) and not any(s for _, s in indices)
    return [
        str(rule.origin.name),
        len(rule.expansion),
        None if name.startswith("_") else name,
        None if whole else indices,
        bool(rule.options.expand1 and not rule.alias),
    ]


def write(grammar: Path) -> None:
    """Write the tables of a grammar beside it, atomically: other processes may read them."""
    tables = make(grammar.read_text(encoding="utf-8"))
    text = json.dumps(tables, separators=(",", ":"))
    write_atomically(grammar.with_suffix(".json"), text.encode())
