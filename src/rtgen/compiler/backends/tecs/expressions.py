"""Sizes as Python expressions, with C's meaning."""

from __future__ import annotations

from collections.abc import Callable

from rtgen.compiler.layouts.tdr import Counted, FixedArray, Item, Octets
from rtgen.compiler.model.c_types import (
    BinaryExpression,
    CastExpression,
    ConditionalExpression,
    CScalarType,
    Expression,
    Literal,
    Reference,
    UnaryExpression,
    resolve,
)
from rtgen.compiler.typemap.tecs.python import member_name
from rtgen.facts.tdr import BITS, LETTERS, WIDTH_NAMES, Scalar

Names = Callable[[str], tuple[str, Item]]
"""The meaning of a name in a size: an expression, and the parameter or member."""

_HELPERS = {
    "/": "quotient",
    "%": "remainder",
    "<<": "shifted_left",
    ">>": "shifted_right",
}
_COMPARISONS = ("<", ">", "<=", ">=", "==", "!=")
_LOGICAL = {"&&": "and", "||": "or"}
_WIDTHS = {
    **{letter: f"self.tdr.{name}" for letter, name in WIDTH_NAMES.items()},
    **{letter: str(bits) for letter, bits in BITS.items()},
}


def expression_text(expression: Expression, names: Names) -> str:
    """Return the expression in Python, an int, without enclosing parentheses."""
    text = _text(expression, names)
    if isinstance(expression, BinaryExpression | ConditionalExpression):
        return text[1:-1] if text[0] == "(" else text
    return text


def is_simple(expression: Expression, names: Names) -> bool:
    """Return whether evaluating it cannot fail: a number, or a parameter's value."""
    match expression:
        case Literal():
            return True
        case Reference(name) | UnaryExpression("*", Reference(name)):
            item = names(name)[1]
            return not item.nullable and not _is_array(item)
    return False


def _text(expression: Expression, names: Names) -> str:
    match expression:
        case Literal(value):
            return str(int(value))
        case Reference(name):
            text, item = names(name)
            return f"present({text})" if item.nullable else text
        case UnaryExpression("*", Reference(name)) if _is_array(names(name)[1]):
            return f"{names(name)[0]}[0]"
        case UnaryExpression(operator, operand):
            inner = _text(operand, names)
            match operator:
                case "*" | "&" | "+":
                    return inner
                case "!":
                    return f"int(not {inner})"
            return f"{operator}{inner}"
        case BinaryExpression(".", left, Reference(member)):
            return f"{_text(left, names)}.{member_name(member)}"
        case BinaryExpression("[]", left, right):
            index = expression_text(right, names)
            return f"element({_text(left, names)}, {index})"
        case BinaryExpression(operator, left, right):
            return _binary(operator, left, right, names)
        case ConditionalExpression(condition, yes, no):
            parts = (_text(yes, names), _text(condition, names), _text(no, names))
            return "({} if {} else {})".format(*parts)
        case CastExpression(type_, operand):
            scalar = resolve(type_)
            assert isinstance(scalar, CScalarType)
            kind = "b" if scalar.kind is Scalar.CHAR else LETTERS[scalar.kind]
            inner = expression_text(operand, names)
            return f"cast({inner}, {_WIDTHS[kind.lower()]}, {kind.islower()})"
    raise AssertionError(expression)


def _binary(operator: str, left: Expression, right: Expression, names: Names) -> str:
    if operator in _HELPERS:
        first, second = expression_text(left, names), expression_text(right, names)
        return f"{_HELPERS[operator]}({first}, {second})"
    first, second = _text(left, names), _text(right, names)
    if operator in _COMPARISONS:
        return f"int({first} {operator} {second})"
    if operator in _LOGICAL:
        return f"int(bool({first} {_LOGICAL[operator]} {second}))"
    return f"({first} {operator} {second})"


def _is_array(item: Item) -> bool:
    return isinstance(item.node, Counted | FixedArray | Octets)
