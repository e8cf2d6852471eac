"""Lint checks of constructs that CORBA 2 and 3 compilers, such as omniidl, reject."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context, fields
from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Component,
    Declaration,
    Interface,
    MapType,
    Primitive,
    PrimitiveType,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
)

_NEW = (Primitive.INT8, Primitive.UINT8)
_NO_SWITCH = (Primitive.OCTET, Primitive.WCHAR, *_NEW)


def constructs(context: Context) -> Iterator[Diagnostic]:
    """Report constructs of IDL 4 in files without components, which other compilers could read."""
    own = {d.file for d in context.declarations if isinstance(d, Component)}
    for declaration in context.declarations:
        if declaration.file not in own:
            what = _construct(context, declaration)
            if what is not None:
                yield rules.NOT_PORTABLE.at(
                    declaration.span,
                    f"{declaration.scoped} {what}, which compilers of CORBA refuse",
                    hint="keep to IDL 3 in files that others read",
                )


def _construct(context: Context, declaration: Declaration) -> str | None:
    match declaration:
        case Struct(base=base) if base is not None:
            return "has a base"
        case Struct(members=()):
            return "has no members"
        case Bitset() | Bitmask():
            return f"is a {type(declaration).__name__.lower()}"
        case Union(switch=switch) if context.model.unalias(switch) in [
            PrimitiveType(kind) for kind in _NO_SWITCH
        ]:
            return f"switches by {switch}"
    for type_ in _types(declaration):
        what = _type(type_)
        if what is not None:
            return f"uses {what}"
    return None


def _types(declaration: Declaration) -> Iterator[Type]:
    for field in fields(declaration):
        yield field.type
    match declaration:
        case Typedef(type=type_):
            yield type_
        case Interface(operations=operations, attributes=attributes):
            for operation in operations:
                yield operation.returns
                yield from (parameter.type for parameter in operation.parameters)
            yield from (attribute.type for attribute in attributes)


def _type(type_: Type) -> str | None:
    match type_:
        case MapType():
            return "a map"
        case PrimitiveType(kind) if kind in _NEW:
            return str(kind.value)
        case SequenceType(element) | ArrayType(element):
            return _type(element)
    return None
