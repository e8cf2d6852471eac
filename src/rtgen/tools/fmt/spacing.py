"""Determines spaces between two tokens of a statement, and the nesting of brackets."""

from __future__ import annotations

from copy import copy
from typing import NamedTuple

from rtgen.tools.fmt.tokens import COMMENTS, Kind, Language, Token

_TEMPLATES = frozenset(
    ("sequence", "string", "wstring", "fixed", "map", "bitfield", "module")
)
_LISTED = frozenset(("raises", "getraises", "setraises", "context", "switch"))
"""Words with a space before their parenthesis, as in the standard."""
_BEFORE_TYPES = frozenset(
    (
        *("in", "out", "inout", "attribute", "readonly", "const", "typedef", "public"),
        *("private", "oneway", "case", "uses", "provides", "publishes", "consumes"),
        *("emits", "supports", "manages", "primarykey", "truncatable", "multiple"),
        *("port", "mirrorport", "alias", "typeid", "typeprefix", "import", "valuetype"),
        *("cell", "call", "entry", "require", "union", "switch"),
    )
)
"""Words that can precede a name with a leading `::`."""
_NO_OPERAND = frozenset(("case", "const", "default", "in", "out", "inout", "return"))
BINARY = frozenset(
    (
        *("|", "^", "&", "<<", ">>", "+", "-", "*", "/", "%"),
        *("==", "!=", ">=", "&&", "||", "?"),
    )
)
"""Operators between operands, before which a line can be broken."""
_SIGNS = frozenset(("+", "-", "~", "!", "*", "&"))
_OPENERS = {"(": ")", "[": "]", "{": "}"}
_CLOSERS = frozenset(_OPENERS.values())


SPECIFIERS = "specifiers"
BLOCK = "block"
LABELS = ("case", "default")
"""First words of union labels."""


class Bracket(NamedTuple):
    """An open bracket: its character, SPECIFIERS of CDL, or BLOCK; `values`: it has expressions.

    `outer` is the bracket around it. `depth`, `braces` and `templates` are the numbers of brackets
    up to this one: of all, of `{` and of `<`. The stack is immutable, so that a state can be kept
    without a copy.
    """

    mark: str
    values: bool = False
    outer: Bracket | None = None
    depth: int = 0
    braces: int = 0
    templates: int = 0


class Spacing:
    """State of a statement's tokens; `space` must be called for each, in order."""

    def __init__(self, language: Language) -> None:
        self._idl = language is Language.IDL
        self.inside = Bracket("")
        """The innermost open bracket; outside of all, one without a character."""
        self._last: Token | None = None
        self._after_sign = False
        self._module = False
        self._label = False

    def copy(self) -> Spacing:
        """Return a copy of the state, for lookahead."""
        return copy(self)

    @property
    def depth(self) -> int:
        """Number of open brackets."""
        return self.inside.depth

    @property
    def innermost(self) -> str:
        """The innermost open bracket, or an empty text."""
        return self.inside.mark

    def close_all(self) -> None:
        """Close all brackets, as the end of a statement does."""
        while self.inside.outer is not None:
            self.inside = self.inside.outer

    def space(
        self, token: Token, *, closes_templates: bool = False, is_block: bool = False
    ) -> bool:
        """Return whether a space precedes the token, and advance the state.

        `closes_templates`: it is a `>>` that does; `is_block`: it opens a block of statements.
        """
        last = self._last
        spaced = last is not None and self._between(last, token, closes_templates)
        is_mark = token.kind is Kind.MARK
        sign = is_mark and token.text in _SIGNS and not self._is_operand(last)
        if is_mark:
            self._enter(token.text, closes_templates, is_block)
        elif token.kind is Kind.WORD and not self.depth:
            self._module = self._module or token.text == "module"
            self._label = self._label or token.text in LABELS
        self._after_sign = sign
        self._last = token
        return spaced

    def _enter(self, text: str, closes_templates: bool, is_block: bool) -> None:
        if is_block:
            self._open(BLOCK)
        elif text in _OPENERS:
            mark = text
            if text == "[" and not self._idl and not self._is_operand(self._last):
                mark = SPECIFIERS
            values = mark in ("[", "{") or (
                mark == "(" and (self.innermost == SPECIFIERS or self.inside.values)
            )
            self._open(mark, values)
        elif text in _CLOSERS:
            while self.innermost == "<":
                self._close()
            self._close()
        elif text == "<" and self._opens_template():
            self._open("<", values=True)
        elif text == ">" and self.innermost == "<":
            self._close()
        elif text == ">>" and closes_templates:
            self._close()
            self._close()
        elif text in ("=", ",", ";") and self.innermost in ("", BLOCK):
            self.inside = self.inside._replace(values=text == "=")
        elif text == ":":
            self._label = False

    def _open(self, mark: str, values: bool = False) -> None:
        outer = self.inside
        braces = outer.braces + (mark == "{")
        templates = outer.templates + (mark == "<")
        self.inside = Bracket(mark, values, outer, outer.depth + 1, braces, templates)

    def _close(self) -> None:
        if self.inside.outer is not None:
            self.inside = self.inside.outer

    def _opens_template(self) -> bool:
        if not self._idl:
            return False
        last = self._last
        return last is not None and (
            last.text in _TEMPLATES or (self._module and last.kind is Kind.WORD)
        )

    def _is_operand(self, token: Token | None) -> bool:
        if token is None:
            return False
        if token.kind is Kind.WORD:
            return token.text not in _NO_OPERAND
        if token.kind in (Kind.NUMBER, Kind.STRING):
            return True
        return token.text in (")", "]")

    def _between(self, last: Token, token: Token, closes: bool) -> bool:
        old, new = last.text, token.text
        if last.kind is Kind.MARK and old in ("(", "["):
            return False
        if token.kind is Kind.MARK and new in (")", "]", ",", ";"):
            return new == ";" and old == ";"
        if last.kind in COMMENTS or token.kind in COMMENTS:
            return True
        if token.kind is Kind.MARK:
            return self._before_mark(last, token, closes)
        if last.kind is Kind.MARK:
            return self._after_mark(old)
        return True

    def _before_mark(self, last: Token, token: Token, closes: bool) -> bool:
        old, new = last.text, token.text
        mark = last.kind is Kind.MARK
        if new == "{":
            return True
        if new == "}":
            return not (mark and old == "{")
        if new == "::":
            gap = token.start > last.end
            return gap and (
                last.kind is not Kind.WORD or old in _BEFORE_TYPES or not self._idl
            )
        if mark and old in ("::", "."):
            return False
        if new == ".":
            return False
        if new == "(":
            if last.kind is Kind.WORD:
                return self._idl and old in _LISTED
            return mark and self._after_mark(old)
        if new == "[":
            return not self._is_operand(last) and (not mark or self._after_mark(old))
        if new == "<" and self._opens_template():
            return False
        if new == "<" and mark and old == "<" and self.innermost == "<":
            return False
        if new == ">" and self.innermost == "<":
            return mark and old == ">"  # `>> >` and `>>>` are the same tokens
        if new == ">>" and closes:
            return mark and old == ">"  # `>> >` and `>>>` are the same tokens
        if new == ":":
            return not self._label
        if new == "=" and self._idl and self.innermost == "(":
            return False
        if new in _SIGNS and not self._is_operand(last):
            return self._after_mark(old) if mark else True
        if new in ("*", "&") and not self._idl and not self.inside.values:
            return not (mark and old == "*")
        return True

    def _after_mark(self, old: str) -> bool:
        if old in ("(", "[", "::", ".", "~", "!", "@"):
            return False
        if old == "<" and self.innermost == "<":
            return False
        if old == "=" and self._idl and self.innermost == "(":
            return False
        if old in _SIGNS and self._after_sign:
            return False
        return old != "*" or self._idl or self.inside.values
