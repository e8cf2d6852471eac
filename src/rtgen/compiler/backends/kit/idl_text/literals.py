"""Values of constants as IDL literals (OMG IDL 4.2, 7.2.6)."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal

from rtgen.compiler.backends.kit.quoting.idl import characters, readable_string
from rtgen.compiler.model import (
    ArrayType,
    ConstantValue,
    EnumeratorName,
    InitialValue,
    Model,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from rtgen.compiler.typemap.idl_keywords import escaped


def literal(
    model: Model,
    type_: Type,
    value: ConstantValue,
    escape: Callable[[str], str] = escaped,
) -> str:
    """Return a constant's value as an IDL literal of the type; enumerators as `escape` says."""
    type_ = model.unalias(type_)
    wide = type_ == PrimitiveType(Primitive.WCHAR)
    wide |= isinstance(type_, StringType) and type_.wide
    match value:
        case bool():
            return "TRUE" if value else "FALSE"
        case EnumeratorName(name):
            return "::".join(map(escape, name))
        case str():
            is_text = isinstance(type_, StringType)
            quote = '"' if is_text else "'"
            return f"{'L' if wide else ''}{quote}{characters(value, wide)}{quote}"
        case float():
            return _float(value)
        case Decimal():
            return f"{value:f}d"
        case int() if _is_floating(type_):
            return _float(float(value))
    return str(value)


def default_text(value: InitialValue) -> str:
    """Return the value of `@default` for readers, on one line: of a list its items."""
    match value:
        case tuple():
            return f"({', '.join(map(default_text, value))})"
        case bool():
            return "TRUE" if value else "FALSE"
        case EnumeratorName(name):
            return name[-1]
        case str():
            return readable_string(value)
    return str(value)


def readable(model: Model, type_: Type, value: InitialValue) -> str:
    """Return a value of a type for readers, on one line: a literal, or those of a list."""
    type_ = model.unalias(type_)
    match value:
        case tuple():
            while isinstance(type_, SequenceType | ArrayType):
                type_ = model.unalias(type_.element)
            return f"({', '.join(readable(model, type_, each) for each in value)})"
        case EnumeratorName(name):
            return "::".join(name)
        case str():
            if isinstance(type_, StringType):
                return readable_string(value, wide=type_.wide)
            wide = type_ == PrimitiveType(Primitive.WCHAR)
            return readable_string(value, "'", wide)
        case Decimal():
            return f"{value:f}"
    return default_text(value)


def _is_floating(type_: Type) -> bool:
    floating = (Primitive.FLOAT, Primitive.DOUBLE, Primitive.LONG_DOUBLE)
    return isinstance(type_, PrimitiveType) and type_.kind in floating


def _float(value: float) -> str:
    if value in (float("inf"), float("-inf")):
        return "1e999" if value > 0 else "-1e999"
    return repr(value)
