"""Recognizes missing and superfluous braces."""

from __future__ import annotations

import re

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.syntax.syntax_errors.context import (
    DEFINERS,
    ErrorContext,
    header,
    partner,
)
from rtgen.compiler.frontends.kit.syntax_errors import Recovery

_LONE = re.compile(r"[;{}][ \t\r]*\n\s*;")
_DATA = ("struct", "exception", "union", "enum", "bitset", "bitmask")
_NEVER_IN_DATA = frozenset(
    ("module", "interface", "typedef", "exception", "const", "valuetype", "native")
)
_NEVER_IN_INTERFACES = frozenset(("module", "interface", "valuetype", "component"))
_TYPES = ("struct", "union", "enum")


def unclosed(s: ErrorContext) -> Recovery | None:
    """Recognize a declaration that the open body does not allow: a `}` is missing before it."""
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


def _unclosed(s: ErrorContext, start: int, word: str, *, back: bool) -> Recovery:
    assert s.opening is not None
    lone = _LONE.search(s.unit.text, s.opening, start)
    if lone is not None:
        s.unit.excused.add(lone.end() - 1)
    return s.recover(
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


def unopened(s: ErrorContext) -> Recovery | None:
    """Recognize the body of `struct S` without `{`, when a `}` has no partner."""
    if s.surplus >= 0 or "LBRACE" not in s.accepted or s.text in ("{", ";"):
        return None
    if not any(word.text in DEFINERS for word in s.before):
        return None
    return s.missing("{", f"put '{{' after '{s.previous}'", feed="LBRACE")


def doubled(s: ErrorContext) -> Recovery | None:
    """Recognize a duplicated brace."""
    twice = s.last > 0 and s.unit.text[s.last - 1] == s.text
    if twice and (
        (s.text == "{" and s.surplus > 0) or (s.text == "}" and s.surplus < 0)
    ):
        message = f"this '{s.text}' is one too many"
        return s.recover(syntax.UNEXPECTED, message, "remove it", instead=True)
    return None


def end_without_brace(s: ErrorContext) -> Recovery | None:
    """Recognize a `;` that ends a body whose `}` is missing."""
    if s.surplus <= 0:
        return None
    if s.text == ";" and s.construct in ("enum", "bitmask") and "RBRACE" in s.accepted:
        assert s.opening is not None
        return s.recover(
            syntax.MISSING_MARK,
            "a '}' is missing before this ';'",
            "write '};'",
            related=[_opened(s, s.opening)],
            feed=("RBRACE",),
            resume=s.start,
        )
    if s.kind != "$END" or s.opening is None:
        return None
    match = _LONE.search(s.unit.text, s.opening)
    if match is None:
        return None
    place = match.end() - 1
    s.unit.excused.add(place)
    brace = _innermost(s.unit.text, s.opening, place)
    return s.recover(
        syntax.MISSING_MARK,
        "a '}' is missing before this ';'",
        "write '};'",
        at=(place, place + 1),
        related=[_opened(s, brace)],
    )


def _opened(s: ErrorContext, brace: int) -> Related:
    names = [w.text for w in header(s.unit.text, brace) if w.is_word][:2]
    return Related(
        s.unit.span(brace, brace + 1), f"the body of {' '.join(names)} begins here"
    )


def _innermost(text: str, start: int, end: int) -> int:
    """Return the innermost open brace at `end`, starting from the one at `start`."""
    opened = [start]
    for place in range(start + 1, end):
        if text[place] == "{":
            opened.append(place)
        elif text[place] == "}" and len(opened) > 1:
            opened.pop()
    return opened[-1]


def stray(s: ErrorContext) -> Recovery | None:
    """Recognize a `}` without an open brace."""
    if s.text != "}" or s.opening is not None:
        return None
    return s.recover(
        syntax.STRAY_BRACE,
        "this '}' closes nothing",
        "remove it, or add the '{' that is missing before it",
    )
