"""Arithmetic of constant expressions: ranges and widths of scalar types, operators, literals."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from rtgen.compiler.frontends.cdl.names.operands import Operand, OperandClass
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.model.c_types import (
    CScalarType,
    CType,
    Expression,
    Literal,
    resolve,
)
from rtgen.facts import tdr
from rtgen.facts.tdr import Scalar

ARITHMETIC = (OperandClass.INTEGER, OperandClass.FLOAT)

OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "%": operator.mod,
    "<<": operator.lshift,
    ">>": operator.rshift,
    "&": operator.and_,
    "|": operator.or_,
    "^": operator.xor,
}

COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


def number_literal(node: tree.Number) -> Operand:
    """Return the operand of a literal: decimal, octal, hexadecimal or floating-point."""
    text = node.text
    value: int | float
    if "." in text:
        value = float(text)
        return Operand(OperandClass.FLOAT, value, Literal(value))
    if text.startswith("0x"):
        value = int(text, 16)
    elif text.startswith("0") and text.strip("01234567") == "":
        value = int(text, 8)
    else:
        value = int(text)
    return Operand(OperandClass.INTEGER, value, Literal(value))


def operand_of(
    operand_class: OperandClass,
    value: bool | int | float | None,
    model: Expression,
    type_: CType | None = None,
) -> Operand:
    """Return the operand; its model is a literal if the value is constant."""
    if value is None:
        return Operand(operand_class, None, model, type_)
    return Operand(operand_class, value, Literal(value), type_)


def as_float(value: bool | int | float) -> float:
    """Return the nearest floating-point number; infinity for too large an integer."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


_WITHOUT_RANGE = (Scalar.LONG_LONG, Scalar.ULONG_LONG)

_BITS = {
    scalar: tdr.BITS[letter.lower()]
    for scalar, letter in tdr.LETTERS.items()
    if letter.lower() in tdr.BITS and scalar not in _WITHOUT_RANGE
}
"""The types whose values are checked for their range."""


def width(kind: Scalar) -> str:
    """Return the width of a basic type as a pointer's target; as in tecsgen, without the sign."""
    if kind in (Scalar.CHAR, Scalar.SCHAR, Scalar.UCHAR):
        return Scalar.CHAR
    return kind.removeprefix("unsigned ").removeprefix("u")


def wrapped(value: int, type_: CType) -> int:
    """Return an integer after a cast to a sized type."""
    found = resolve(type_)
    if not isinstance(found, CScalarType) or found.kind not in _BITS:
        return value
    bits = _BITS[found.kind]
    value &= (1 << bits) - 1
    if found.kind not in tdr.UNSIGNED and value >> (bits - 1):
        value -= 1 << bits
    return value


def limits(type_: CType) -> tuple[int | None, int | None]:
    """Return the minimum and the maximum of an integer type, if known."""
    found = resolve(type_)
    assert isinstance(found, CScalarType)
    bits, unsigned = _BITS.get(found.kind), found.kind in tdr.UNSIGNED
    if bits is None:
        return (0 if unsigned else None), None
    # Whether a plain char is signed is not known.
    full = unsigned or found.kind is Scalar.CHAR
    return (0 if unsigned else -(1 << (bits - 1))), (1 << (bits - (not full))) - 1


def clipped(value: float, type_: CType) -> int:
    """Cast a floating-point number to an integer type: to the nearest value in range."""
    low, high = limits(type_)
    if not math.isfinite(value):
        return (high or 0) if value > 0 else (low or 0)
    whole = int(value)
    whole = whole if low is None else max(whole, low)
    return whole if high is None else min(whole, high)


def whole_number(found: Operand) -> Operand:
    """Return the integer of a constant in tecsgen's arithmetic: true is 1, 2.0 is 2."""
    value = found.value
    if isinstance(value, bool) or (isinstance(value, float) and value.is_integer()):
        return Operand(OperandClass.INTEGER, int(value), Literal(int(value)))
    return found
