"""Recognizes characters that start no token."""

from __future__ import annotations

import re
from unicodedata import category, name

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.rules import lexical, syntax
from rtgen.compiler.frontends.idl.text.unit import Unit

_REPLACEMENTS = {
    "\N{LEFT DOUBLE QUOTATION MARK}": '"',
    "\N{RIGHT DOUBLE QUOTATION MARK}": '"',
    "\N{LEFT SINGLE QUOTATION MARK}": "'",
    "\N{RIGHT SINGLE QUOTATION MARK}": "'",
    "\N{FULLWIDTH SEMICOLON}": ";",
    "\N{FULLWIDTH COLON}": ":",
    "\N{FULLWIDTH COMMA}": ",",
    "\N{FULLWIDTH LEFT PARENTHESIS}": "(",
    "\N{FULLWIDTH RIGHT PARENTHESIS}": ")",
    "\N{FULLWIDTH LEFT CURLY BRACKET}": "{",
    "\N{FULLWIDTH RIGHT CURLY BRACKET}": "}",
    "\N{FULLWIDTH LESS-THAN SIGN}": "<",
    "\N{FULLWIDTH GREATER-THAN SIGN}": ">",
    "\N{FULLWIDTH EQUALS SIGN}": "=",
    "\N{IDEOGRAPHIC COMMA}": ",",
    "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-",
    "\N{EM DASH}": "-",
    "\N{MULTIPLICATION SIGN}": "*",
}
_TERMINALS = {
    ";": "SEMI",
    ":": "COLON",
    ",": "COMMA",
    "(": "LPAR",
    ")": "RPAR",
    "{": "LBRACE",
    "}": "RBRACE",
    "<": "LESS",
    ">": "GREATER",
    "=": "EQUALS",
    "-": "ADDITIVE",
    "*": "MULTIPLICATIVE",
}
_HINTS = {
    "#": "a directive begins its line; a comment begins with //",
    "?": "IDL has no conditional expressions; an optional member is marked @optional",
    "!": "IDL has no logical operators; complement is ~",
    "$": "names hold ASCII letters, digits and underscores",
    "`": "strings are written as \"...\", characters as '...'",
    "\\": "a backslash is allowed in strings, or at the end of a continued line",
    ".": "parts of a name are joined by ::",
}
_QUOTED = re.compile("[\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}]")
_INVISIBLE = ("Zs", "Zl", "Zp", "Cf", "Cc")


def is_blank(character: str) -> bool:
    """Return whether a character is invisible, so that it can be skipped."""
    return category(character) in _INVISIBLE


def bad_character(unit: Unit, text: str, start: int) -> Diagnostic:
    """Return the diagnostic for a character that starts no token."""
    character = text[start]
    span = unit.span(start, start + 1)
    if character == "'" or text.startswith("L'", start):
        return syntax.BAD_LITERAL.at(
            span,
            "this character literal is not closed",
            hint="a character literal is enclosed in ', as in 'x'",
        )
    if is_blank(character):
        called = (
            f"{name(character, 'control character').lower()}, U+{ord(character):04X},"
        )
        hint = (
            "write a plain space"
            if category(character)[0] == "Z"
            else "remove it; nothing is seen of it"
        )
        number = text.count(character)
        more = f" (it occurs in this file {number} times)" if number > 1 else ""
        message = f"the {called} is not allowed here{more}"
        return lexical.BAD_CHARACTER.at(span, message, hint=hint)
    replacement = _REPLACEMENTS.get(character)
    ascii_ = "IDL is written in ASCII, but for comments and strings"
    hint = f"write {replacement}" if replacement else _HINTS.get(character, ascii_)
    called = f"'{character}'" if character.isprintable() else f"U+{ord(character):04X}"
    return lexical.BAD_CHARACTER.at(
        span,
        f"the character {called} is not allowed here",
        hint=hint,
    )


def meant(text: str, start: int) -> tuple[str | None, int]:
    """Return the terminal that a wrong character likely means, and its length."""
    if _QUOTED.match(text, start):
        closing = _QUOTED.search(text, start + 1)
        if closing and "\n" not in text[start : closing.end()]:
            return "STRING", closing.end() - start
    if text[start] == ".":
        return "SCOPE", 1
    return _TERMINALS.get(_REPLACEMENTS.get(text[start], "")), 1
