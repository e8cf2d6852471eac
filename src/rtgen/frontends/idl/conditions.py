"""The expressions of `#if` and `#elif` (ISO C 1998, 16.1): integers, `defined`, operators."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from rtgen.frontends.idl.macros import Expander, ExpansionError, Macro, Token, tokenize

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
_OPERATIONS: dict[str, Callable[[int, int], int]] = {
    "||": lambda a, b: int(bool(a) or bool(b)),
    "&&": lambda a, b: int(bool(a) and bool(b)),
    "|": lambda a, b: a | b,
    "^": lambda a, b: a ^ b,
    "&": lambda a, b: a & b,
    "==": lambda a, b: int(a == b),
    "!=": lambda a, b: int(a != b),
    "<": lambda a, b: int(a < b),
    ">": lambda a, b: int(a > b),
    "<=": lambda a, b: int(a <= b),
    ">=": lambda a, b: int(a >= b),
    "<<": lambda a, b: a << b,
    ">>": lambda a, b: a >> b,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
}
_INTEGER = re.compile(r"(?:0[xX][0-9a-fA-F]+|0[0-7]*|[1-9]\d*)[uUlL]{0,3}")
_ESCAPES = {"n": 10, "t": 9, "0": 0, "r": 13, "a": 7, "b": 8, "f": 12, "v": 11}
_DEEPEST = 64


def evaluate(text: str, macros: Mapping[str, Macro]) -> bool:
    """Whether the expression is not 0; raises ExpansionError for one that is none."""
    tokens = _defined([t for t in tokenize(text) if t.kind != "space"], macros)
    tokens = [t for t in Expander(macros).expand(tokens) if t.kind != "space"]
    tokens = _defined(tokens, macros)
    if not tokens:
        raise ExpansionError("the expression is missing")
    parser = _Parser(tokens)
    value = parser.expression()
    if parser.tokens:
        raise ExpansionError(f"'{parser.tokens[-1].text}' cannot stand here")
    return bool(value)


def _defined(tokens: list[Token], macros: Mapping[str, Macro]) -> list[Token]:
    result = []
    index = 0
    while index < len(tokens):
        token = tokens[index]
        if token.text == "defined":
            match [t.text for t in tokens[index + 1 : index + 4]]:
                case ["(", name, ")"]:
                    index += 3
                case [name, *_] if tokens[index + 1].kind == "name":
                    index += 1
                case _:
                    raise ExpansionError("'defined' needs the name of a macro")
            token = Token("number", str(int(name in macros)))
        result.append(token)
        index += 1
    return result


class _Parser:
    """Precedence climbing; values stay in the 64 bits of C's intmax_t."""

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens = tokens[::-1]
        self._depth = 0
        self._dead = 0

    def expression(self, lowest: int = 0) -> int:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ExpansionError("the expression is nested too deeply")
        value = self._unary()
        while self.tokens and _LEVEL.get(self.tokens[-1].text, -1) >= lowest:
            operator = self.tokens.pop().text
            decided = (operator == "&&" and not value) or (operator == "||" and value)
            right = self._operand(not decided, _LEVEL[operator] + 1)
            value = self._apply(operator, value, right)
        if lowest == 0 and self.tokens and self.tokens[-1].text == "?":
            value = self._choice(value)
        self._depth -= 1
        return value

    def _choice(self, condition: int) -> int:
        self.tokens.pop()
        chosen = self._operand(bool(condition))
        if not self.tokens or self.tokens.pop().text != ":":
            raise ExpansionError("'?' needs a ':'")
        other = self._operand(not condition)
        return chosen if condition else other

    def _operand(self, matters: bool, lowest: int = 0) -> int:
        """An operand; one that does not matter is read, but cannot be wrong."""
        self._dead += not matters
        value = self.expression(lowest)
        self._dead -= not matters
        return value

    def _apply(self, operator: str, left: int, right: int) -> int:
        if operator in ("/", "%"):
            if right == 0:
                if self._dead:
                    return 0
                raise ExpansionError("division by zero")
            quotient = (
                abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1)
            )
            return quotient if operator == "/" else left - quotient * right
        if operator in ("<<", ">>") and not 0 <= right < 64:
            if self._dead:
                return 0
            raise ExpansionError(f"a shift by {right} is not between 0 and 63")
        value = _OPERATIONS[operator](left, right) & (2**64 - 1)
        return value - 2**64 if value >= 2**63 else value

    def _unary(self) -> int:
        operators = []
        while self.tokens and self.tokens[-1].text in ("!", "~", "-", "+"):
            operators.append(self.tokens.pop().text)
        value = self._primary()
        for operator in reversed(operators):
            match operator:
                case "!":
                    value = int(not value)
                case "~":
                    value = ~value
                case "-":
                    value = -value
        return value

    def _primary(self) -> int:
        if not self.tokens:
            raise ExpansionError("an operand is missing at the end")
        token = self.tokens.pop()
        if token.text == "(":
            value = self.expression()
            if not self.tokens or self.tokens.pop().text != ")":
                raise ExpansionError("a ')' is missing")
            return value
        if token.kind == "name":
            return 0
        if token.kind == "number" and _INTEGER.fullmatch(token.text):
            digits = token.text.rstrip("uUlL")
            if len(digits) > 24:
                raise ExpansionError("the number is too large")
            octal = digits.startswith("0") and digits.isdigit()
            return int(digits, 8 if octal else 0)
        if token.kind == "text" and token.text.startswith("'"):
            character = token.text[1:-1]
            if len(character) == 1:
                return ord(character)
            if len(character) == 2 and character[0] == "\\":
                return _ESCAPES.get(character[1], ord(character[1]))
        raise ExpansionError(f"'{token.text}' cannot stand in this expression")
