"""Signs in place of those that an encoding of terminals, such as cp932, lacks."""

from __future__ import annotations

import codecs
from unicodedata import category, normalize

NAME = "rtgen.substitute"
"""The name of the error handler, once `registered`."""

_UNKNOWN = "?"
_SIMILAR = (
    *("\N{MICRO SIGN}μu", "\N{MIDDLE DOT}・.", "\N{DOT OPERATOR}・.", "\N{BULLET}・*"),
    *("\N{EN DASH}-", "\N{EM DASH}―-", "\N{MINUS SIGN}-", "\N{HYPHEN}-", "―-"),
    *("╭┌+", "╮┐+", "╰└+", "╯┘+", "╔┏+", "╗┓+", "╚┗+", "╝┛+", "═━-", "║┃|"),
    *("╠┣+", "╣┫+", "╦┳+", "╩┻+", "╬╋+", "─-", "│|", "━-", "┃|"),
    *("↔⇔", "⇄⇔", "⟶→>", "➜→>", "→>", "←<"),
    *("≤≦", "≥≧", "≈≒~", "✓○", "✔○", "✗x", "✘x"),
)
"""A sign, and those that replace it, the most similar one first."""
_SUBSTITUTES = {signs[0]: signs[1:] for signs in _SIMILAR}


def registered() -> str:
    """Register the error handler for `str.encode`, and return its name.

    Signs are replaced by similar ones; letters, which belong to names, by question marks.
    """
    codecs.register_error(NAME, _substituted)
    return NAME


def _substituted(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_substitute(each, error.encoding) for each in lacking), error.end


def _substitute(character: str, encoding: str) -> str:
    choices: list[str] = [*_SUBSTITUTES.get(character, "")]
    if not category(character).startswith("L"):
        choices.append(normalize("NFKD", character))
    return next((each for each in choices if _has(encoding, each)), _UNKNOWN)


def _has(encoding: str, text: str) -> bool:
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True
