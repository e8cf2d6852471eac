"""Checks of `@default` against the limits of members, and of the typedefs that are their types."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtgen.compiler.frontends.idl.meaning.annotations import contradictions
from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.meaning.operands import string_size
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.rules import annotations as rules
from rtgen.compiler.model import (
    Annotation,
    Bitfield,
    Bitset,
    Case,
    Declaration,
    ExceptionDecl,
    InitialValue,
    Member,
    NamedType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
    Valuetype,
    limits,
)
from rtgen.facts.primitives import INTEGER_RANGES

_Entry = Member | Case | Typedef | Bitfield


def defaults(entity: Entity, context: Context) -> None:
    """Check the defaults and the limits of a declaration's members."""
    declaration = context.made.get(entity.path)
    for entry in () if declaration is None else _entries(declaration):
        annotations, initial = _inherited(entry, context)
        if not annotations:
            continue
        for message in contradictions(limits(annotations), initial):
            hint = "correct @default, @min or @max"
            context.report(rules.DEFAULT_RANGE.at(entry.span, message, hint=hint))
        if isinstance(entry, Bitfield):
            _fits(entry, context)
        elif isinstance(entry.initial, str):
            _is_within_bound(entry, entry.initial, context)
        if isinstance(entry, Member) and entry.optional and entry.initial is not None:
            message = f"@default means nothing for {entry.name}, which is optional"
            hint = "it starts absent: remove @default, or @optional"
            context.report(rules.MISPLACED.at(entry.span, message, hint=hint))


def _entries(declaration: Declaration) -> Iterable[_Entry]:
    match declaration:
        case Struct() | ExceptionDecl() | Bitset():
            return declaration.members
        case Union():
            return declaration.cases
        case Valuetype():
            return declaration.state
        case Typedef():
            return (declaration,)
    return ()


def _inherited(
    entry: _Entry, context: Context
) -> tuple[list[Annotation], InitialValue | None]:
    """Return the annotations and the default of an entry, its own first, then its typedefs'."""
    annotations, initial = [*entry.annotations], entry.initial
    for typedef in _typedefs(entry.type, context):
        annotations += typedef.annotations
        initial = typedef.initial if initial is None else initial
    return annotations, initial


def _typedefs(type_: Type | None, context: Context) -> Iterator[Typedef]:
    while isinstance(type_, NamedType):
        declaration = context.made.get(type_.name)
        if not isinstance(declaration, Typedef):
            return
        yield declaration
        type_ = declaration.type


def _is_within_bound(
    entry: Member | Case | Typedef, text: str, context: Context
) -> None:
    """Check a text in octets or units of UTF-16, as codecs do; its characters are checked."""
    type_ = context.types.unaliased(entry.type)
    if not isinstance(type_, StringType) or type_.bound is None:
        return
    size = string_size(type_, text)
    if len(text) <= type_.bound < size:
        what = "units of UTF-16" if type_.wide else "octets of UTF-8"
        message = (
            f"the default has {size} {what}, and {type_} has room for {type_.bound}"
        )
        hint = "shorten it, or raise the bound"
        context.report(rules.DEFAULT_RANGE.at(entry.span, message, hint=hint))


def _fits(field: Bitfield, context: Context) -> None:
    """Check that the default of a bit field has at most its bits."""
    value = field.initial
    if not isinstance(value, int):
        return
    kind = getattr(context.types.unaliased(field.type), "kind", "")
    is_signed = INTEGER_RANGES.get(kind, (0, 0))[0] < 0
    least = -(1 << field.bits - 1) if is_signed else 0
    if not least <= value < least + (1 << field.bits):
        message = f"the default {value} does not fit into {field.bits} bits"
        hint = "write a smaller one"
        context.report(rules.DEFAULT_RANGE.at(field.span, message, hint=hint))
