"""Compares C types of CDL: whether TDR transfers them in the same octets (tecsgen, OpaqueRPC)."""

from __future__ import annotations

from collections.abc import Mapping

from rtgen.facts.tdr import LETTERS, Scalar
from rtgen.layouts.tdr import OCTETS
from rtgen.model.c_types import (
    BinaryExpression,
    CArrayType,
    CastExpression,
    CEnumType,
    ConditionalExpression,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    DescriptorType,
    Expression,
    Reference,
    UnaryExpression,
    resolve,
)
from rtgen.model.types import ScopedName


def c_shape(type_: CType, structs: Mapping[ScopedName, ScopedName]) -> str:
    """Return what determines the octets of a value; structs by their names in the new version."""
    match resolve(type_):
        case CScalarType(kind=Scalar.VOID):
            return "void"
        case CScalarType(kind=kind):
            return LETTERS.get(kind, kind.value) + ("o" if kind in OCTETS else "")
        case CPointerType(target=target):
            return f"*{c_shape(target, structs)}"
        case CArrayType(element=element, size=size):
            return f"[{'' if size is None else size}]{c_shape(element, structs)}"
        case CStructType(tag=tag):
            return f"struct {'::'.join(structs.get(tag, tag))}"
        case CEnumType(tag=tag, bits=bits):
            return f"enum{bits or ''} {'::'.join(tag)}"
        case DescriptorType(signature=signature):
            return f"descriptor {'::'.join(signature)}"
        case other:
            return str(other)


def c_text(type_: CType) -> str:
    """Return a type as shown in messages."""
    return str(type_)


def length_text(expression: Expression | None, names: Mapping[str, str]) -> str:
    """Return an expression with the parameter names of the new version."""
    match expression:
        case None:
            return "none"
        case Reference(name):
            return names.get(name, name)
        case UnaryExpression(operator, operand):
            return f"{operator}{length_text(operand, names)}"
        case BinaryExpression(operator, left, right):
            ends = length_text(left, names), length_text(right, names)
            return f"({ends[0]} {operator} {ends[1]})"
        case CastExpression(type_, operand):
            return f"({type_}){length_text(operand, names)}"
        case ConditionalExpression(condition, yes, no):
            parts = (length_text(part, names) for part in (condition, yes, no))
            return " ? ".join(parts)
    return str(expression)
