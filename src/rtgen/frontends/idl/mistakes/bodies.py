"""Braces that are missing or too many."""

from __future__ import annotations

from rtgen.diagnostics import Related
from rtgen.frontends.idl.mistakes.situation import (
    DEFINERS,
    Mistake,
    Situation,
    header,
    partner,
)
from rtgen.frontends.idl.rules import syntax

_DATA = ("struct", "exception", "union", "enum", "bitset", "bitmask")
_NEVER_IN_DATA = frozenset(
    ("module", "interface", "typedef", "exception", "const", "valuetype", "native")
)
_NEVER_IN_INTERFACES = frozenset(("module", "interface", "valuetype", "component"))
_TYPES = ("struct", "union", "enum")


def unclosed(s: Situation) -> Mistake | None:
    """A declaration begins that cannot stand in the open body, and a `}` is missing somewhere."""
    if s.surplus <= 0 or s.opening is None or s.kind == "$END":
        return None
    if s.construct in _DATA:
        never = _NEVER_IN_DATA
        if s.construct in ("enum", "bitmask"):
            never |= {"struct", "union", "enum"}
    elif s.construct in ("interface", "valuetype", "component"):
        never = _NEVER_IN_INTERFACES
    else:
        return None
    if s.text in never and (not s.before or "RBRACE" in s.accepted):
        return _unclosed(s, s.start, s.text, back=bool(s.before) is False)
    if s.construct in ("struct", "exception") and s.text == ";" and not s.before:
        brace = (
            partner(s.unit.text, s.last - 1) if s.unit.text[s.last - 1] == "}" else None
        )
        inner = header(s.unit.text, brace) if brace is not None else []
        if inner and inner[0].text in _TYPES:
            return _unclosed(s, inner[0].start, inner[0].text, back=True)
    return None


def _unclosed(s: Situation, start: int, word: str, *, back: bool) -> Mistake:
    assert s.opening is not None
    return s.mistake(
        syntax.UNCLOSED_BRACE,
        f"this '{{' of {s.called} is not closed",
        f"put '}};' before '{word}'",
        at=(s.opening, s.opening + 1),
        related=[
            Related(s.unit.span(start, start + len(word)), f"{word} begins inside it")
        ],
        feed=("RBRACE", "SEMI"),
        back=back,
        resume=start,
    )


def unopened(s: Situation) -> Mistake | None:
    """The body of `struct S` begins without `{`, and there is a `}` for which none is open."""
    if s.surplus >= 0 or "LBRACE" not in s.accepted or s.text in ("{", ";"):
        return None
    if s.first not in (*DEFINERS, "abstract", "local", "custom"):
        return None
    return s.missing("{", f"put '{{' behind '{s.previous}'", feed="LBRACE")


def stray(s: Situation) -> Mistake | None:
    """A `}` where no brace is open."""
    if s.text != "}" or s.opening is not None:
        return None
    return s.mistake(
        syntax.STRAY_BRACE,
        "this '}' closes nothing",
        "remove it, or look for a '{' that is missing before it",
    )
