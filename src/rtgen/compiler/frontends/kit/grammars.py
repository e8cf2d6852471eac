"""Loads grammars by name, with the tables made of them when the package was built."""

from __future__ import annotations

import json

from rtgen.compiler.frontends.kit.lalr import Grammar, key
from rtgen.compiler.kit.resources import grammar_file


def load(name: str, builder: object, reserved: frozenset[str]) -> Grammar:
    """Load the grammar of that name (`idl`); uses the tables beside it if they match its text."""
    path = grammar_file(f"{name}.lark")
    text = path.read_text(encoding="utf-8")
    try:
        tables = json.loads(path.with_suffix(".json").read_bytes())
    except (OSError, ValueError):
        tables = None
    if not isinstance(tables, dict) or tables.get("key") != key(text):
        from rtgen.compiler.frontends.kit.lalr_tables import make

        tables = make(text)
    return Grammar(tables, builder, reserved)
