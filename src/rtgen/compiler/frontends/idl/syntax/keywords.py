"""Keywords of IDL (OMG IDL 4.2, 7.2.4): reserved words, and contextual keywords."""

from __future__ import annotations

from rtgen.compiler.typemap.idl_keywords import CORBA_3, FOLDED, RESERVED

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
"""The text of terminals that recovery supplies."""

SHOWN = {
    "IDENT": "a name",
    "NUMBER": "a number",
    "STRING": "a string",
    "CHARACTER": "a character",
    "ANNOTATION": "an annotation",
    "ANNOTATION_DCL": "an annotation",
    **{terminal: f"'{word}'" for terminal, word in WORDS.items()},
    "LSQB": "'['",
    "SCOPE": "'::'",
    "ADDITIVE": "'+'",
    "MULTIPLICATIVE": "'*'",
    "SHIFT": "'<<'",
    "TILDE": "'~'",
    "VBAR": "'|'",
    "CIRCUMFLEX": "'^'",
    "AMPERSAND": "'&'",
    "$END": "the end of the file",
}
"""Names of terminals in messages; other terminals are keywords, shown in lower case and quotes."""


def shown(terminal: str) -> str:
    """Return a terminal as shown in messages."""
    return SHOWN.get(terminal) or f"'{terminal.lower()}'"
