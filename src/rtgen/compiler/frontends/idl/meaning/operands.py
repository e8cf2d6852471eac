"""Operands of constant expressions: classes, ranges, conversions (OMG IDL 4.2, 7.4.1.4.3)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from decimal import ROUND_DOWN, Context, Decimal
from enum import StrEnum

from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.model import (
    FixedType,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    StringType,
    Type,
)
from rtgen.facts.primitives import INTEGER_RANGES

FLOATS = frozenset((Primitive.FLOAT, Primitive.DOUBLE, Primitive.LONG_DOUBLE))

_CHARACTERS = {Primitive.CHAR: False, Primitive.WCHAR: True}

NARROW = {
    Primitive.OCTET: 8,
    Primitive.UINT8: 8,
    Primitive.UNSIGNED_SHORT: 16,
}
"""Unsigned types narrower than the arithmetic, whose complement is masked."""

WIDE = (Primitive.LONG_LONG, Primitive.UNSIGNED_LONG_LONG)

_BY_SIZE = (
    Primitive.SHORT,
    Primitive.UNSIGNED_SHORT,
    Primitive.LONG,
    Primitive.UNSIGNED_LONG,
    Primitive.LONG_LONG,
    Primitive.UNSIGNED_LONG_LONG,
)

EXACT = Context(prec=62, rounding=ROUND_DOWN)


DIGITS_31 = Context(prec=31, rounding=ROUND_DOWN)

LARGEST_FLOAT = 3.4028234663852886e38

LARGEST_DOUBLE = sys.float_info.max


class OperandClass(StrEnum):
    """Operand classes, which must not be mixed in an expression.

    The value is their name in messages.
    """

    INTEGER = "an integer"
    FLOAT = "a floating-point number"
    FIXED = "a fixed-point number"
    CHARACTER = "a character"
    WIDE_CHARACTER = "a wide character"
    TEXT = "a string"
    WIDE_TEXT = "a wide string"
    BOOLEAN = "a boolean"
    ENUM = "an enumerator"


EXAMPLES = {
    OperandClass.INTEGER: "write a number without point and quotes, such as 10",
    OperandClass.FLOAT: "write a number with a point, such as 1.5",
    OperandClass.FIXED: "write a number that ends with d, such as 1.5d",
    OperandClass.CHARACTER: "write one character in single quotes, such as 'x'",
    OperandClass.WIDE_CHARACTER: "write one character in single quotes after L, such as L'x'",
    OperandClass.TEXT: 'write text in double quotes, such as "text"',
    OperandClass.WIDE_TEXT: 'write text in double quotes after L, such as L"text"',
    OperandClass.BOOLEAN: "write TRUE or FALSE",
    OperandClass.ENUM: "write the name of an enumerator",
}

BOUND_HINT = (
    "a bound is positive; without a bound, sequences and strings hold any number"
)

_WIDE_HINT = "wide literals begin with L, others do not"

CONVERSIONS = {
    (OperandClass.TEXT, OperandClass.WIDE_TEXT): _WIDE_HINT,
    (OperandClass.WIDE_TEXT, OperandClass.TEXT): _WIDE_HINT,
    (OperandClass.CHARACTER, OperandClass.WIDE_CHARACTER): _WIDE_HINT,
    (OperandClass.WIDE_CHARACTER, OperandClass.CHARACTER): _WIDE_HINT,
    (
        OperandClass.INTEGER,
        OperandClass.FLOAT,
    ): ("write a number without point, or make the type double"),
    (
        OperandClass.INTEGER,
        OperandClass.ENUM,
    ): "an enumerator is not a number: write its number, or use the enum",
}


def operand_class_of(
    type_: Type | None, is_enum: Callable[[ScopedName], bool]
) -> OperandClass | None:
    """Return the operand class of a type's constants, through aliases; None without constants."""
    match type_:
        case PrimitiveType(kind):
            if kind in INTEGER_RANGES:
                return OperandClass.INTEGER
            if kind in FLOATS:
                return OperandClass.FLOAT
            if kind is Primitive.BOOLEAN:
                return OperandClass.BOOLEAN
            if kind in _CHARACTERS:
                return (
                    OperandClass.WIDE_CHARACTER
                    if _CHARACTERS[kind]
                    else OperandClass.CHARACTER
                )
        case StringType(wide):
            return OperandClass.WIDE_TEXT if wide else OperandClass.TEXT
        case FixedType():
            return OperandClass.FIXED
        case NamedType(name) if is_enum(name):
            return OperandClass.ENUM
    return None


def string_size(type_: StringType, text: str) -> int:
    """Return the length that the bound of a string limits: octets of UTF-8, units of UTF-16."""
    if type_.wide:
        return len(text.encode("utf-16-le", "surrogatepass")) // 2
    return len(text.encode(errors="surrogatepass"))


def is_literal(node: tree.Expression) -> bool:
    """Return whether the expression is a single number, possibly signed or in parentheses."""
    match node:
        case tree.Unary(operand=inner) | tree.Group(inner=inner):
            return is_literal(inner)
    return isinstance(node, tree.Number)


def fixed_type_of(value: Decimal) -> FixedType:
    """Return the smallest fixed-point type for a value (CORBA 2.6, 3.10.2)."""
    _, digits, exponent = without_zeros(value).as_tuple()
    assert isinstance(exponent, int)
    scale = max(-exponent, 0)
    return FixedType(max(len(digits) + max(exponent, 0), scale), scale)


def without_zeros(value: Decimal) -> Decimal:
    """Return the value without trailing zeros in its fraction."""
    return (
        value.quantize(Decimal(1), context=EXACT)
        if value == value.to_integral_value()
        else value.normalize(EXACT)
    )


def wider(value: int) -> str:
    """Return a hint with the smallest type for a value."""
    for kind in _BY_SIZE:
        low, high = INTEGER_RANGES[kind]
        if low <= value <= high:
            return f"{kind} holds it"
    return "no integer type holds it; write a smaller number"


def brief(value: int) -> str:
    return str(value) if value.bit_length() < 200 else "a number of more than 200 bits"
