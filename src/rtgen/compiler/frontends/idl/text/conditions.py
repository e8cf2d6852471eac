"""Conditions of `#if` and `#elif`: macros, `defined`, and the value of the expression."""

from __future__ import annotations

from collections.abc import Mapping

from rtgen.compiler.frontends.idl.text.macros import (
    Expander,
    ExpansionError,
    Macro,
    Token,
    tokenize,
)
from rtgen.compiler.frontends.kit.conditions import ConditionError, Operand, value_of


def evaluate(text: str, macros: Mapping[str, Macro]) -> bool:
    """Return whether the expression is not 0. Raises ExpansionError for a malformed one."""
    tokens = _defined([t for t in tokenize(text) if t.kind != "space"], macros)
    tokens = [t for t in Expander(macros).expand(tokens) if t.kind != "space"]
    tokens = _defined(tokens, macros)
    if not tokens:
        raise ExpansionError("the expression is missing")
    try:
        return bool(value_of(Operand(token.kind, token.text) for token in tokens))
    except ConditionError as error:
        raise ExpansionError(str(error)) from None


def _defined(tokens: list[Token], macros: Mapping[str, Macro]) -> list[Token]:
    result = []
    index = 0
    while index < len(tokens):
        token = tokens[index]
        if token.text == "defined":
            match [t.text for t in tokens[index + 1 : index + 4]]:
                case ["(", name, ")"]:
                    index += 3
                case [name, *_] if tokens[index + 1].kind == "name":
                    index += 1
                case _:
                    raise ExpansionError("'defined' needs the name of a macro")
            token = Token("number", str(int(name in macros)))
        result.append(token)
        index += 1
    return result
