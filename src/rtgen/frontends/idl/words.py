"""The words of IDL: reserved ones, and those that are keywords only in their place."""

from __future__ import annotations


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


RESERVED = _words("""
    abstract any attribute boolean case char const context custom default double enum exception
    factory FALSE fixed float in inout interface local long module native Object octet oneway
    out private public raises readonly sequence short string struct supports switch TRUE
    truncatable typedef union unsigned ValueBase valuetype void wchar wstring
    """)
"""CORBA 2.6, 3.2.4, table 3-6."""

FOLDED = {word.lower(): word for word in RESERVED}
"""Reserved words by their lower-case form: no identifier may differ from one in case only."""

CORBA_3 = _words("""
    component consumes emits eventtype finder getraises home import manages multiple primarykey
    provides publishes setraises typeid typeprefix uses
    """)
"""CORBA 3.0, 3.2.4: usable as identifiers here, though not in a CORBA 3 compiler."""

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
