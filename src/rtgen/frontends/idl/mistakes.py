"""Syntax errors in a user's words: what the parser found, told as the mistake that it likely is."""

from __future__ import annotations

import re
from collections.abc import Set
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rtgen.diagnostics import Diagnostic, Related
from rtgen.frontends.idl.rules import lexical, syntax
from rtgen.frontends.idl.suggestions import nearest
from rtgen.frontends.idl.unit import Unit
from rtgen.frontends.idl.words import RESERVED, shown

if TYPE_CHECKING:
    from rtgen.frontends.lalr import Token

_WORDS_BY_TERMINAL = {"TEXT": "string", "WTEXT": "wstring"}
_FEW = 6
_CONSTRUCTS = (
    "STRUCT",
    "UNION",
    "ENUM",
    "INTERFACE",
    "MODULE",
    "EXCEPTION",
    "VALUETYPE",
)
_PUNCTUATION = {
    "\N{LEFT DOUBLE QUOTATION MARK}": '"',
    "\N{RIGHT DOUBLE QUOTATION MARK}": '"',
    "\N{LEFT SINGLE QUOTATION MARK}": "'",
    "\N{RIGHT SINGLE QUOTATION MARK}": "'",
    "\N{FULLWIDTH SEMICOLON}": ";",
    "\N{FULLWIDTH COLON}": ":",
    "\N{FULLWIDTH COMMA}": ",",
}
_LAST_WORD = re.compile(r"(\w+)\s*\Z")


_TERMINALS = {";": "SEMI", ":": "COLON", ",": "COMMA"}
_QUOTED = re.compile("[\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}]")


@dataclass(frozen=True, slots=True)
class Mistake:
    """A finding; `semicolon` says that all is well once a `;` is put behind the last token."""

    diagnostic: Diagnostic
    semicolon: bool = False


def bad_character(unit: Unit, text: str, start: int) -> Diagnostic:
    """The finding for a character that no token begins with."""
    character = text[start]
    span = unit.span(start, start + 1)
    if character == "'":
        return syntax.BAD_LITERAL.at(span, "this character literal is not closed")
    if character == "#":
        return lexical.BAD_CHARACTER.at(
            span, "'#' cannot stand here", hint="a directive begins its line"
        )
    replacement = _PUNCTUATION.get(character)
    name = f"'{character}'" if character.isprintable() else f"U+{ord(character):04X}"
    hint = f"write {replacement}" if replacement else None
    if character == "\u3000":
        hint = "this is an ideographic space; use a plain one"
    return lexical.BAD_CHARACTER.at(
        span, f"the character {name} cannot stand here", hint=hint
    )


def meant(text: str, start: int) -> tuple[str | None, int]:
    """The terminal that was probably meant by a wrong character, and how long it is."""
    if _QUOTED.match(text, start):
        closing = _QUOTED.search(text, start + 1)
        if closing and "\n" not in text[start : closing.end()]:
            return "STRING", closing.end() - start
    return _TERMINALS.get(_PUNCTUATION.get(text[start], "")), 1


def explain(
    unit: Unit, token: Token, accepted: Set[str], last: int, opening: int | None
) -> Mistake:
    """What is wrong where `token` came and only `accepted` terminals fit.

    `last` is where the token before it ends, `opening` the innermost open brace.
    """
    start = token.start_pos or 0
    end = max(token.end_pos or start, start + 1)
    previous = _LAST_WORD.search(unit.text[max(last - 200, 0) : last])
    before = previous[1] if previous else ""
    if token.type == "$END":
        if "SEMI" in accepted:
            return _semicolon(unit, last)
        return _at_end(unit, last, opening)
    span = unit.span(start, end)
    if "SEMI" in accepted and _begins_anew(unit, token, last):
        return _semicolon(unit, last)
    if token.type == "RBRACE" and opening is None:
        return Mistake(syntax.STRAY_BRACE.at(span, "this '}' closes nothing"))
    if token.type == "LBRACE" and before.upper() in _CONSTRUCTS:
        return Mistake(
            syntax.MISSING_NAME.at(
                span,
                f"the {before} has no name",
                hint=f"write '{before} Name {{ ... }}'",
            )
        )
    if "IDENT" in accepted and token in RESERVED:
        return Mistake(
            syntax.KEYWORD_AS_NAME.at(
                span,
                f"'{token}' is a keyword and cannot be a name",
                hint=f"'_{token}' stands for the name {token}",
            )
        )
    words = {
        _WORDS_BY_TERMINAL.get(t, t.lower()): t for t in accepted if t not in ("IDENT",)
    }
    if token.type == "IDENT":
        meant = nearest(str(token), [w for w in words if w.isalpha()])
        if meant is not None:
            return Mistake(
                syntax.MISSPELT_KEYWORD.at(
                    span,
                    f"'{token}' is not known here",
                    hint=f"did you mean '{meant}'?",
                )
            )
    return Mistake(
        syntax.UNEXPECTED.at(
            span, f"{_named(token)} cannot stand here{_expectation(accepted)}"
        )
    )


def _named(token: Token) -> str:
    text = " ".join(token.split())
    text = text if len(text) <= 40 else text[:37] + "..."
    return f"'{text}'"


def _expectation(accepted: Set[str]) -> str:
    names = sorted(
        {shown(terminal) for terminal in accepted - {"ERROR", "ANNOTATION_DCL"}}
    )
    if not names or len(names) > _FEW:
        return ""
    if len(names) == 1:
        return f": {names[0]} was expected"
    return f": {', '.join(names[:-1])} or {names[-1]} was expected"


def _begins_anew(unit: Unit, token: Token, last: int) -> bool:
    """Whether a token that cannot continue a declaration begins a line, or closes a body."""
    between = unit.text[last : token.start_pos]
    return "\n" in between or token.type == "RBRACE" or token in RESERVED


def _semicolon(unit: Unit, last: int) -> Mistake:
    diagnostic = syntax.MISSING_SEMICOLON.at(
        unit.after(last),
        "a ';' is missing here",
        hint="put ';' at the end of the declaration",
    )
    return Mistake(diagnostic, semicolon=True)


def _at_end(unit: Unit, last: int, opening: int | None) -> Mistake:
    if opening is None:
        return Mistake(
            syntax.UNEXPECTED_END.at(
                unit.after(last), "the file ends within a declaration"
            )
        )
    return Mistake(
        syntax.UNCLOSED_BRACE.at(
            unit.span(opening, opening + 1),
            "this '{' is never closed",
            related=[Related(unit.after(last), "the file ends here")],
            hint="add '};'",
        )
    )
