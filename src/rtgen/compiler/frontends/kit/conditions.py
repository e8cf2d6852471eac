"""Expressions of `#if` and `#elif` (ISO C 1998, 16.1) in integers of 64 bits.

The macros of an expression are expanded before, and `defined` is replaced by 0 or 1.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

import msgspec

from rtgen.compiler.kit.limits import MAX_NESTING

_LEVELS: tuple[tuple[str, ...], ...] = (
    ("||",),
    ("&&",),
    ("|",),
    ("^",),
    ("&",),
    ("==", "!="),
    ("<", ">", "<=", ">="),
    ("<<", ">>"),
    ("+", "-"),
    ("*", "/", "%"),
)
_LEVEL = {operator: level for level, group in enumerate(_LEVELS) for operator in group}
_COMPARISONS: dict[str, Callable[[int, int], bool]] = {
    "||": lambda a, b: bool(a or b),
    "&&": lambda a, b: bool(a and b),
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}
_SHIFTS: dict[str, Callable[[int, int], int]] = {
    "<<": operator.lshift,
    ">>": operator.rshift,
}
_OPERATIONS: dict[str, Callable[[int, int], int]] = {
    "|": operator.or_,
    "^": operator.xor,
    "&": operator.and_,
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
}
_INTEGER = re.compile(r"(?:0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)[uUlL]{0,3}")
_CHARACTER = re.compile(
    r"L?'(?:\\(?:(?P<digits>x[0-9a-fA-F]{1,16}|[0-7]{1,3})|(?P<escaped>.))|(?P<plain>[^\\]))'"
)
_ESCAPES = {"n": 10, "t": 9, "r": 13, "a": 7, "b": 8, "f": 12, "v": 11}


class Operand(NamedTuple):
    """A token of an expression: its kind ("number", "name", "text" or another) and its text."""

    kind: str
    text: str


class ConditionError(Exception):
    """A malformed expression, or one without a value; the message says why."""


def value_of(tokens: Iterable[Operand]) -> int:
    """Return the value of an expression. Raises ConditionError."""
    parser = _Parser([*tokens])
    value = parser.expression()
    if parser.tokens:
        raise ConditionError(f"'{parser.tokens[-1].text}' is not allowed here")
    return value.value


class _Number(msgspec.Struct, frozen=True):
    """A value of C's intmax_t, or uintmax_t if `unsigned`: 64 bits, with overflow."""

    value: int
    unsigned: bool = False

    @classmethod
    def of(cls, value: int, unsigned: bool = False) -> _Number:
        value &= 2**64 - 1
        if not unsigned and value >= 2**63:
            value -= 2**64
        return cls(value, unsigned)


class _Parser:
    """Precedence climbing parser."""

    def __init__(self, tokens: list[Operand]) -> None:
        self.tokens = tokens[::-1]
        self._depth = 0
        self._dead = 0

    def expression(self, lowest: int = 0) -> _Number:
        self._depth += 1
        if self._depth > MAX_NESTING:
            raise ConditionError("the expression is nested too deeply")
        left = self._unary()
        while self.tokens and _LEVEL.get(self.tokens[-1].text, -1) >= lowest:
            mark = self.tokens.pop().text
            decided = mark == ("||" if left.value else "&&")
            right = self._operand(not decided, _LEVEL[mark] + 1)
            left = self._apply(mark, left, right)
        if lowest == 0 and self.tokens and self.tokens[-1].text == "?":
            left = self._choice(bool(left.value))
        self._depth -= 1
        return left

    def _choice(self, condition: bool) -> _Number:
        self.tokens.pop()
        chosen = self._operand(condition)
        if not self.tokens or self.tokens.pop().text != ":":
            raise ConditionError("'?' needs a ':'")
        other = self._operand(not condition)
        value = chosen.value if condition else other.value
        return _Number.of(value, chosen.unsigned or other.unsigned)

    def _operand(self, matters: bool, lowest: int = 0) -> _Number:
        """Evaluate an operand; an unevaluated one (`matters` is False) causes no error."""
        self._dead += not matters
        value = self.expression(lowest)
        self._dead -= not matters
        return value

    def _apply(self, mark: str, left: _Number, right: _Number) -> _Number:
        if mark in _SHIFTS:
            if not 0 <= right.value < 64:
                if self._dead:
                    return _Number(0)
                message = f"a shift by {right.value} is not between 0 and 63"
                raise ConditionError(message)
            return _Number.of(_SHIFTS[mark](left.value, right.value), left.unsigned)
        if mark in ("||", "&&"):
            return _Number(int(_COMPARISONS[mark](left.value, right.value)))
        unsigned = left.unsigned or right.unsigned
        a = _Number.of(left.value, unsigned).value
        b = _Number.of(right.value, unsigned).value
        if mark in _COMPARISONS:
            return _Number(int(_COMPARISONS[mark](a, b)))
        if mark in _OPERATIONS:
            return _Number.of(_OPERATIONS[mark](a, b), unsigned)
        if b == 0:
            if self._dead:
                return _Number(0)
            raise ConditionError("division by zero")
        quotient = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
        return _Number.of(quotient if mark == "/" else a - quotient * b, unsigned)

    def _unary(self) -> _Number:
        marks = []
        while self.tokens and self.tokens[-1].text in ("!", "~", "-", "+"):
            marks.append(self.tokens.pop().text)
        number = self._primary()
        for mark in reversed(marks):
            match mark:
                case "!":
                    number = _Number(int(not number.value))
                case "~":
                    number = _Number.of(~number.value, number.unsigned)
                case "-":
                    number = _Number.of(-number.value, number.unsigned)
        return number

    def _primary(self) -> _Number:
        if not self.tokens:
            raise ConditionError("an operand is missing at the end")
        token = self.tokens.pop()
        if token.text == "(":
            number = self.expression()
            if not self.tokens or self.tokens.pop().text != ")":
                raise ConditionError("a ')' is missing")
            return number
        if token.kind == "name":
            return _Number(0)
        if token.kind == "number" and _INTEGER.fullmatch(token.text):
            digits = token.text.rstrip("uUlL")
            if len(digits) > 24:
                raise ConditionError("the number is too large")
            octal = digits.startswith("0") and digits.isdigit()
            value = int(digits, 8 if octal else 0)
            suffix = token.text[len(digits) :].lower()
            return _Number.of(value, "u" in suffix or value >= 2**63)
        character = _CHARACTER.fullmatch(token.text)
        if token.kind == "text" and character is not None:
            if character["digits"] is not None:
                base = 16 if character["digits"][0] == "x" else 8
                return _Number.of(int(character["digits"].lstrip("x"), base))
            escaped = character["escaped"]
            return _Number(_ESCAPES.get(escaped, ord(escaped or character["plain"])))
        raise ConditionError(f"'{token.text}' is not allowed in this expression")
