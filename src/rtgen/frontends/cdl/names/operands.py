"""Typed operands of expressions: operand class, value and type."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rtgen.facts.tdr import Scalar
from rtgen.model.c_types import (
    CArrayType,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    Expression,
    resolve,
)


class Sort(StrEnum):
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
        return f"an {self}" if self is Sort.INTEGER else f"a {self}"


@dataclass(frozen=True, slots=True)
class Operand:
    """A typed expression. `value` is None if the expression is not constant.

    `type` is what a name or what `*`, `[]` and `.` make of it has as its type.
    """

    sort: Sort
    value: bool | int | float | str | None
    model: Expression
    type: CType | None = None


NUMBERS = (Sort.BOOL, Sort.INTEGER, Sort.FLOAT)


class BadError(Exception):
    """An expression has an error, which is already reported."""


def sort_of(type_: CType) -> Sort:
    """The operand class of values of a type."""
    found = resolve(type_)
    if isinstance(found, CPointerType | CArrayType):
        return Sort.POINTER
    if isinstance(found, CStructType):
        return Sort.STRUCT
    if not isinstance(found, CScalarType):
        return Sort.UNKNOWN
    if found.kind is Scalar.BOOL:
        return Sort.BOOL
    if found.kind in (Scalar.FLOAT32, Scalar.DOUBLE64):
        return Sort.FLOAT
    return Sort.UNKNOWN if found.kind is Scalar.VOID else Sort.INTEGER
