"""Traversals of expressions of the model: nesting depth, and the names used."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.model.c_types import (
    BinaryExpression,
    CastExpression,
    ConditionalExpression,
    Expression,
    Reference,
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


def references(expression: Expression) -> Iterator[str]:
    """Yield the names that an expression uses."""
    match expression:
        case Reference(name):
            yield name
        case BinaryExpression(".", left, _):
            yield from references(left)
        case BinaryExpression(_, left, right):
            yield from references(left)
            yield from references(right)
        case UnaryExpression(_, operand) | CastExpression(_, operand):
            yield from references(operand)
        case ConditionalExpression(condition, yes, no):
            for part in (condition, yes, no):
                yield from references(part)
        case _:
            return
