"""The words of IDL: reserved ones, and those that are keywords only in their place."""

from __future__ import annotations

from rtgen.typemap.idl_words import CORBA_3, FOLDED, RESERVED

__all__ = ["CORBA_3", "FOLDED", "RESERVED", "SHOWN", "TERMINALS", "WORDS", "shown"]


TERMINALS = {
    **{word: word.upper() for word in RESERVED},
    "string": "TEXT",
    "wstring": "WTEXT",
}
"""The terminal of the grammar for each reserved word."""

WORDS = {
    **{terminal: word for word, terminal in TERMINALS.items()},
    "COLON": ":",
    "COMMA": ",",
    "EQUALS": "=",
    "GREATER": ">",
    "LBRACE": "{",
    "LESS": "<",
    "LPAR": "(",
    "RBRACE": "}",
    "RPAR": ")",
    "RSQB": "]",
    "SEMI": ";",
}
"""The text of the terminals that recovery supplies."""

SHOWN = {
    "IDENT": "a name",
    "NUMBER": "a number",
    "STRING": "a string",
    "CHARACTER": "a character",
    "ANNOTATION": "an annotation",
    "ANNOTATION_DCL": "an annotation",
    "COLON": "':'",
    "COMMA": "','",
    "EQUALS": "'='",
    "GREATER": "'>'",
    "LBRACE": "'{'",
    "LESS": "'<'",
    "LPAR": "'('",
    "LSQB": "'['",
    "RBRACE": "'}'",
    "RPAR": "')'",
    "RSQB": "']'",
    "SCOPE": "'::'",
    "SEMI": "';'",
    "TEXT": "'string'",
    "WTEXT": "'wstring'",
    "OBJECT": "'Object'",
    "VALUEBASE": "'ValueBase'",
    "TRUE": "'TRUE'",
    "FALSE": "'FALSE'",
    "ADDITIVE": "'+'",
    "MULTIPLICATIVE": "'*'",
    "SHIFT": "'<<'",
    "TILDE": "'~'",
    "VBAR": "'|'",
    "CIRCUMFLEX": "'^'",
    "AMPERSAND": "'&'",
    "$END": "the end of the file",
}
"""How messages call a terminal; the others are keywords: their own lower-case name in quotes."""


def shown(terminal: str) -> str:
    """How messages call a terminal of the grammar."""
    return SHOWN.get(terminal) or f"'{terminal.lower()}'"
