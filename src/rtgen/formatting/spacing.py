"""Determines spaces between two tokens of a statement, and the nesting of brackets."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

from rtgen.formatting.tokens import COMMENTS, Kind, Language, Token

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


@dataclass(slots=True)
class Bracket:
    """An open bracket: its character, SPECIFIERS of CDL, or BLOCK; `values`: it has expressions."""

    mark: str
    values: bool = False


class Spacing:
    """State of a statement's tokens; `space` must be called for each, in order."""

    def __init__(self, language: Language) -> None:
        self._idl = language is Language.IDL
        self._base = Bracket("")
        self.brackets: list[Bracket] = []
        self._last: Token | None = None
        self._after_sign = False
        self._module = False
        self._label = False

    def copy(self) -> Spacing:
        """Return a copy of the state, for lookahead."""
        other = copy(self)
        other._base = copy(self._base)
        other.brackets = [copy(each) for each in self.brackets]
        return other

    @property
    def depth(self) -> int:
        """Number of open brackets."""
        return len(self.brackets)

    @property
    def innermost(self) -> str:
        """The innermost open bracket, or an empty text."""
        return self._inside.mark

    @property
    def _inside(self) -> Bracket:
        return self.brackets[-1] if self.brackets else self._base

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
        elif token.kind is Kind.WORD and not self.brackets:
            self._module = self._module or token.text == "module"
            self._label = self._label or token.text in LABELS
        self._after_sign = sign
        self._last = token
        return spaced

    def _enter(self, text: str, closes_templates: bool, is_block: bool) -> None:
        if is_block:
            self.brackets.append(Bracket(BLOCK))
        elif text in _OPENERS:
            mark = text
            if text == "[" and not self._idl and not self._is_operand(self._last):
                mark = SPECIFIERS
            values = mark in ("[", "{") or (
                mark == "(" and (self.innermost == SPECIFIERS or self._inside.values)
            )
            self.brackets.append(Bracket(mark, values))
        elif text in _CLOSERS:
            while self.innermost == "<":
                self.brackets.pop()
            if self.brackets:
                self.brackets.pop()
        elif text == "<" and self._opens_template():
            self.brackets.append(Bracket("<", True))
        elif text == ">" and self.innermost == "<":
            self.brackets.pop()
        elif text == ">>" and closes_templates:
            del self.brackets[-2:]
        elif text in ("=", ",", ";") and self.innermost in ("", BLOCK):
            self._inside.values = text == "="
        elif text == ":":
            self._label = False

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
            return mark and old in (">", ">>")
        if new == ">>" and closes:
            return mark and old in (">", ">>")
        if new == ":":
            return not self._label
        if new == "=" and self._idl and self.innermost == "(":
            return False
        if new in _SIGNS and not self._is_operand(last):
            return self._after_mark(old) if mark else True
        if new in ("*", "&") and not self._idl and not self._inside.values:
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
        return old != "*" or self._idl or self._inside.values
