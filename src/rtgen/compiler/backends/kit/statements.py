"""Statements of templates over several lines, as they are in the generated file."""

from __future__ import annotations

import msgspec

from rtgen.compiler.backends.kit.quoting.python import Python

_OPENING = ("(", "[", "{")
_CLOSING = (")", "]", "}")


class _Bracket(msgspec.Struct):
    """An open bracket; `items` are the lines with a comma directly in it."""

    is_tuple: bool
    items: int = 0


def statements(text: str) -> Python:
    """Return lines of Python with each statement on one line, for `fit` to split where it is long.

    A bracket that ends a line is closed by the one that begins a line, after items that end with a
    comma; the last comma stays in a tuple of one item. Blank lines in brackets are dropped, lines
    outside are left as they are.
    """
    parts: list[str] = []
    open_: list[_Bracket] = []
    for line in text.split("\n"):
        bare = line.strip()
        if not open_:
            parts += ("\n", line)
        elif bare.startswith(_CLOSING):
            bracket = open_.pop()
            if not (bracket.is_tuple and bracket.items == 1):
                parts[-1] = parts[-1].removesuffix(",")
            parts.append(bare)
        elif bare:
            parts += (bare,) if parts[-1].endswith(_OPENING) else (" ", bare)
        if bare.endswith(_OPENING):
            before = bare[-2:-1]
            is_call = before.isalnum() or before in ("_", *_CLOSING)
            open_.append(_Bracket(bare[-1] == "(" and not (before and is_call)))
        elif bare.endswith(",") and open_:
            open_[-1].items += 1
    return Python("".join(parts[1:]))
