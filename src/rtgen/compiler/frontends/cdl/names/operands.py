"""Typed operands of expressions: operand class, value and type."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rtgen.compiler.model.c_types import (
    CArrayType,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    Expression,
    resolve,
)
from rtgen.facts.tdr import Scalar


class OperandClass(StrEnum):
    """The class of an operand, for checking operators."""

    BOOL = "truth value"
    INTEGER = "integer"
    FLOAT = "floating-point number"
    STRING = "string"
    POINTER = "pointer"
    STRUCT = "struct"
    UNKNOWN = "value"

    @property
    def with_article(self) -> str:
        """The name of the operand class with its article, for messages."""
        return f"an {self}" if self is OperandClass.INTEGER else f"a {self}"


@dataclass(frozen=True, slots=True)
class Operand:
    """A typed expression. `value` is None if the expression is not constant.

    `type` is the type of a name, or of the result of `*`, `[]` and `.` applied to one.
    """

    operand_class: OperandClass
    value: bool | int | float | str | None
    model: Expression
    type: CType | None = None


NUMBERS = (OperandClass.BOOL, OperandClass.INTEGER, OperandClass.FLOAT)


class ExpressionError(Exception):
    """Raised for an expression with an error, which is already reported."""


def operand_class_of(type_: CType) -> OperandClass:
    """Return the operand class of values of a type."""
    resolved = resolve(type_)
    if isinstance(resolved, CPointerType | CArrayType):
        return OperandClass.POINTER
    if isinstance(resolved, CStructType):
        return OperandClass.STRUCT
    if not isinstance(resolved, CScalarType):
        return OperandClass.UNKNOWN
    if resolved.kind is Scalar.BOOL:
        return OperandClass.BOOL
    if resolved.kind in (Scalar.FLOAT32, Scalar.DOUBLE64):
        return OperandClass.FLOAT
    return (
        OperandClass.UNKNOWN if resolved.kind is Scalar.VOID else OperandClass.INTEGER
    )
