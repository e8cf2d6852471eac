"""The nesting depth of expressions of the model."""

from __future__ import annotations

from rtgen.compiler.model.c_types import (
    BinaryExpression,
    CastExpression,
    ConditionalExpression,
    Expression,
    UnaryExpression,
)


def nesting_depth(expression: Expression) -> int:
    """Return the nesting depth of operators."""
    deepest = 0
    left = [(expression, 1)]
    while left:
        part, depth = left.pop()
        deepest = max(deepest, depth)
        match part:
            case BinaryExpression(_, one, two):
                left += (one, depth + 1), (two, depth + 1)
            case UnaryExpression(_, operand) | CastExpression(_, operand):
                left.append((operand, depth + 1))
            case ConditionalExpression(condition, yes, no):
                left += ((part, depth + 1) for part in (condition, yes, no))
    return deepest
