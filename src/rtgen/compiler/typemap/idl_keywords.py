"""Reserved words of IDL."""

from __future__ import annotations

from rtgen.compiler.kit.words import words

RESERVED = words("""
    abstract any attribute boolean case char const context custom default double enum exception
    factory FALSE fixed float in inout interface local long module native Object octet oneway
    out private public raises readonly sequence short string struct supports switch TRUE
    truncatable typedef union unsigned ValueBase valuetype void wchar wstring
    """)
"""Reserved words of CORBA 2.6, 3.2.4, table 3-6."""

CORBA_3 = words("""
    component consumes emits eventtype finder getraises home import manages multiple primarykey
    provides publishes setraises typeid typeprefix uses
    """)
"""Reserved words added by CORBA 3.0, 3.2.4: valid identifiers in CORBA 2.6, invalid in CORBA 3."""

FOLDED = {word.lower(): word for word in RESERVED}
"""Reserved words by lower-case form: identifiers must differ from them in more than case."""

_ESCAPED = frozenset(FOLDED).union(CORBA_3)


def escaped(name: str) -> str:
    """Return the identifier as written in IDL, with a leading `_` if it is a keyword."""
    return f"_{name}" if name.lower() in _ESCAPED else name
