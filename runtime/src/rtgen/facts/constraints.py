"""Constraints of configuration parameters: tree as in an RtcProfile, text form, evaluation."""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import Decimal
from enum import IntEnum, StrEnum
from math import isfinite
from typing import TypeAlias

import msgspec

Value: TypeAlias = bool | int | float | Decimal | str
"""A parameter, or an item of one; an enumerator is an `IntEnum`."""


class Operator(StrEnum):
    """How a value is compared with a literal."""

    EQUAL = "=="
    LESS = "<"
    GREATER = ">"
    LESS_OR_EQUAL = "<="
    GREATER_OR_EQUAL = ">="


class Comparison(msgspec.Struct, frozen=True, gc=False):
    """`x < 5`; equality also compares texts, other operators only numbers."""

    operator: Operator
    literal: str


class Between(msgspec.Struct, frozen=True, gc=False):
    """`lower <= x <= upper`."""

    lower: str
    upper: str


class AllOf(msgspec.Struct, frozen=True, gc=False):
    """Both bounds of an interval that is open at one or both ends."""

    items: tuple[Comparison, ...]


class AnyOf(msgspec.Struct, frozen=True, gc=False):
    """An enumeration: two or more values."""

    items: tuple[Comparison, ...]


Unit: TypeAlias = Comparison | Between | AllOf | AnyOf
"""A constraint on one value."""


class ItemConstraints(msgspec.Struct, frozen=True, gc=False):
    """One constraint for each item of a list value."""

    items: tuple[Unit, ...]


class KeyConstraints(msgspec.Struct, frozen=True, gc=False):
    """One constraint for each key of a hash value."""

    items: tuple[tuple[str, Unit], ...]


Constraint: TypeAlias = Unit | ItemConstraints | KeyConstraints


class ConstraintError(ValueError):
    """A constraint text that is not valid."""


_MIRRORED = {
    "<": Operator.GREATER,
    ">": Operator.LESS,
    "<=": Operator.GREATER_OR_EQUAL,
    ">=": Operator.LESS_OR_EQUAL,
}
_SPACE = re.compile(r"\s+")
_RELATION = re.compile(r"(<=|>=|<|>)")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_INTEGER = re.compile(r"[+-]?[0-9]+")
_NOT_IN_LITERALS = re.compile(r"[<>(){}]")
_LOWER_BOUNDS = (Operator.GREATER, Operator.GREATER_OR_EQUAL)
_INCLUSIVE = (Operator.GREATER_OR_EQUAL, Operator.LESS_OR_EQUAL)


def parse(text: str) -> Constraint | None:
    """Parse a constraint text; None for an empty one. Raises ConstraintError."""
    text = _SPACE.sub("", text)
    if not text:
        return None
    if text.startswith("{"):
        if not text.endswith("}"):
            raise ConstraintError("the brace is not closed")
        return KeyConstraints(tuple(_keyed(item) for item in _split(text[1:-1])))
    items = [_unit(item) for item in _split(text)]
    return items[0] if len(items) == 1 else ItemConstraints(tuple(items))


def interval(lower: str | None, upper: str | None) -> Unit | None:
    """Return the inclusive interval between two numbers, either of which may be missing."""
    if lower is not None and upper is not None:
        return Between(lower, upper)
    if lower is not None:
        return Comparison(Operator.GREATER_OR_EQUAL, lower)
    if upper is not None:
        return Comparison(Operator.LESS_OR_EQUAL, upper)
    return None


def enumeration(values: Sequence[str]) -> Unit:
    """Return the constraint that allows only these values."""
    items = tuple(Comparison(Operator.EQUAL, value) for value in values)
    return items[0] if len(items) == 1 else AnyOf(items)


def text_of(constraint: Constraint) -> str:
    """Return the text form, from which `parse` makes the same tree."""
    match constraint:
        case Comparison(Operator.EQUAL, literal):
            return literal
        case Comparison(operator, literal):
            return f"x{operator}{literal}"
        case Between(lower, upper):
            return f"{lower}<=x<={upper}"
        case AllOf((low, high)):
            mirrored = str(low.operator).replace(">", "<")
            return f"{low.literal}{mirrored}x{high.operator}{high.literal}"
        case AnyOf(items) | AllOf(items):
            return f"({','.join(item.literal for item in items)})"
        case ItemConstraints(units):
            return ",".join(map(text_of, units))
        case KeyConstraints(pairs):
            return "{" + ",".join(f"{key}:{text_of(unit)}" for key, unit in pairs) + "}"


def is_enumeration(constraint: Constraint | None) -> bool:
    """Return whether the constraint lists the allowed values."""
    match constraint:
        case AnyOf() | Comparison(Operator.EQUAL):
            return True
        case ItemConstraints(units):
            return all(map(is_enumeration, units))
        case _:
            return False


def is_range(constraint: Constraint | None) -> bool:
    """Return whether the constraint bounds a value at both ends."""
    match constraint:
        case Between() | AllOf():
            return True
        case ItemConstraints(units):
            return all(map(is_range, units))
        case _:
            return False


def literals(constraint: Constraint) -> list[tuple[Operator | None, str]]:
    """Return every literal with its operator, in order; None for the bounds of a closed
    interval.
    """
    match constraint:
        case Comparison(operator, literal):
            return [(operator, literal)]
        case Between(lower, upper):
            return [(None, lower), (None, upper)]
        case AllOf(comparisons) | AnyOf(comparisons):
            return [(item.operator, item.literal) for item in comparisons]
        case ItemConstraints(units):
            return [pair for unit in units for pair in literals(unit)]
        case KeyConstraints(pairs):
            return [pair for _, unit in pairs for pair in literals(unit)]


def check_literals(constraint: Constraint, type_: str, *, numeric: bool) -> None:
    """Check that the literals fit values of the type: numbers, or a type without an order.

    Keyed constraints are not checked, because the values of keys have types of their own. Raises
    ConstraintError.
    """
    if isinstance(constraint, KeyConstraints):
        return
    for operator, literal in literals(constraint):
        if numeric:
            _number(literal)
        elif operator is not Operator.EQUAL:
            raise ConstraintError(f"{type_} has no order")


def allows(constraint: Constraint, values: Sequence[Value]) -> bool:
    """Return whether a parameter meets the constraint; `values` are its items, one for a scalar.

    A constraint on one value applies to each item; in a list of constraints, each applies to the
    item at its position. Keyed constraints are for structured values, which no parameter has here:
    they count as met.
    """
    match constraint:
        case KeyConstraints():
            return True
        case ItemConstraints(units):
            return all(
                _meets(unit, value) for unit, value in zip(units, values, strict=False)
            )
        case _:
            return all(_meets(constraint, value) for value in values)


def _meets(unit: Unit, value: Value) -> bool:
    match unit:
        case Between(lower, upper):
            return _meets(
                Comparison(Operator.GREATER_OR_EQUAL, lower), value
            ) and _meets(Comparison(Operator.LESS_OR_EQUAL, upper), value)
        case AllOf(items):
            return all(_meets(each, value) for each in items)
        case AnyOf(items):
            return any(_meets(each, value) for each in items)
        case Comparison(Operator.EQUAL, literal):
            return _equals(literal, value)
        case Comparison(operator, literal):
            return _is_ordered(operator, value, literal)


def _is_ordered(operator: Operator, value: Value, literal: str) -> bool:
    if isinstance(value, str) or not isinstance(value, int | float | Decimal):
        return False
    bound = _comparable(literal, value)
    match operator:
        case Operator.LESS:
            return value < bound
        case Operator.GREATER:
            return value > bound
        case Operator.LESS_OR_EQUAL:
            return value <= bound
    return value >= bound


def _equals(literal: str, value: Value) -> bool:
    if isinstance(value, bool):
        return literal.lower() in (("true", "1") if value else ("false", "0"))
    if isinstance(value, int | float | Decimal) and _NUMBER.fullmatch(literal):
        return value == _comparable(literal, value)
    text = value.name if isinstance(value, IntEnum) else str(value)
    return _SPACE.sub("", text) == literal


def _comparable(literal: str, value: int | float | Decimal) -> int | float | Decimal:
    """Return the number of a literal in a type that compares exactly with the value."""
    number = float(literal)
    if isfinite(number) and _INTEGER.fullmatch(literal):
        return int(literal)
    return Decimal(str(number)) if isinstance(value, Decimal) else number


def _split(text: str) -> list[str]:
    """Split at commas outside of brackets."""
    parts = [""]
    depth = 0
    for character in text:
        depth += {"(": 1, ")": -1}.get(character, 0)
        if depth not in (0, 1):
            raise ConstraintError("the brackets do not match")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    if depth:
        raise ConstraintError("the bracket is not closed")
    return parts


def _keyed(item: str) -> tuple[str, Unit]:
    key, colon, unit = item.partition(":")
    if not colon or not key:
        raise ConstraintError(f"{item!r} is not `key:constraint`")
    return key, _unit(unit)


def _unit(text: str) -> Unit:
    if text.startswith("(") and text.endswith(")"):
        return enumeration([_literal(value) for value in text[1:-1].split(",")])
    parts = _RELATION.split(text)
    match parts:
        case [literal]:
            return Comparison(Operator.EQUAL, _literal(literal))
        case ["x", operator, literal]:
            return Comparison(Operator(operator), _number(literal))
        case [literal, operator, "x"]:
            return Comparison(_MIRRORED[operator], _number(literal))
        case [first, one, "x", other, second] if one[0] == other[0]:
            bounds = (
                Comparison(_MIRRORED[one], _number(first)),
                Comparison(Operator(other), _number(second)),
            )
            low, high = (
                bounds if bounds[0].operator in _LOWER_BOUNDS else reversed(bounds)
            )
            if float(low.literal) > float(high.literal):
                raise ConstraintError(f"no value lies in {text!r}")
            if low.operator in _INCLUSIVE and high.operator in _INCLUSIVE:
                return Between(low.literal, high.literal)
            return AllOf((low, high))
        case _:
            raise ConstraintError(
                f"{text!r} is neither a comparison with x nor a value"
            )


def _literal(text: str) -> str:
    if not text or _NOT_IN_LITERALS.search(text):
        raise ConstraintError(
            f"{text!r} is not a value" if text else "a value is missing"
        )
    return text


def _number(text: str) -> str:
    if not _NUMBER.fullmatch(text) or not isfinite(float(text)):
        raise ConstraintError(f"{text!r} is not a number")
    return text
