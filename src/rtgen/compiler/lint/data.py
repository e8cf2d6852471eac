"""Lint checks of transmitted data: types of ports, bounds, unions."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context, fields
from rtgen.compiler.model import (
    ArrayType,
    Case,
    Component,
    Enum,
    EnumeratorName,
    MapType,
    Member,
    NamedType,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
)
from rtgen.facts.ros import is_interface

_DATA = (PortKind.INPORT, PortKind.OUTPORT)
_MAX_NAMED = 4
_SMALL = "small"


def _ports(context: Context) -> Iterator[tuple[Component, Port]]:
    for declaration in context.declarations:
        if isinstance(declaration, Component):
            for port in declaration.ports:
                if port.kind in _DATA and context.is_given(port.span.file):
                    yield declaration, port


def any_in_ports(context: Context) -> Iterator[Diagnostic]:
    """Report data ports whose type contains an `any`, so that the transmitted type is unknown."""
    for _, port in _ports(context):
        _, field = _first_field(context, port.type, _any, set())
        if field is not None:
            yield rules.ANY_IN_PORT.at(
                port.span,
                f"the data of {port.name} holds an any",
                related=[Related(field.span, f"{field.name} is it")],
                hint="write the type, or a union of those that are possible",
            )


def _any(context: Context, type_: Type) -> str | None:
    return "any" if _element(context, type_) == PrimitiveType(Primitive.ANY) else None


def _element(context: Context, type_: Type) -> Type:
    """Return the type of the elements of arrays and sequences, without aliases."""
    plain = context.model.unalias(type_)
    while isinstance(plain, SequenceType | ArrayType):
        plain = context.model.unalias(plain.element)
    return plain


def _first_field(
    context: Context,
    type_: Type,
    judge: Callable[[Context, Type], str | None],
    seen: set[ScopedName],
) -> tuple[str | None, Member | Case | None]:
    """Return what is found in a type, and the innermost field that is it.

    The field is None for the type itself, the first item if there is nothing.
    """
    what = judge(context, type_)
    plain = _element(context, type_)
    if what is not None or not isinstance(plain, NamedType) or plain.name in seen:
        return what, None
    seen.add(plain.name)
    for field in fields(context.model.find(plain.name)):
        what, inner = _first_field(context, field.type, judge, seen)
        if what is not None:
            return what, inner or field
    return None, None


def times_of_ports(context: Context) -> Iterator[Diagnostic]:
    """Report data ports of RT components without a time stamp."""
    for _, port in _ports(context):
        struct = context.model.declared(port.type)
        if not isinstance(struct, Struct) or _has_time(context, struct):
            continue
        if is_interface(struct.name):
            continue
        yield rules.NO_TIME.at(
            port.span,
            f"{struct.scoped}, the data of {port.name}, has no member 'Time tm'",
            related=[Related(struct.span, "declared here")],
            hint="put 'RTC::Time tm;' first, so that receivers know the age of the data",
        )


def _has_time(context: Context, struct: Struct) -> bool:
    stamps = (m.type for m in context.model.members(struct) if m.name == "tm")
    declared = map(context.model.declared, stamps)
    return any(each is not None and each.name[-1] == "Time" for each in declared)


def unbounded(context: Context) -> Iterator[Diagnostic]:
    """Report members with an unbounded number of elements."""
    for declaration in context.declarations:
        for field in fields(declaration):
            what = _unbounded(context, field.type)
            if what is not None:
                yield rules.UNBOUNDED.at(
                    field.span,
                    f"{field.name} holds a {what} without a bound",
                    hint=f"write {what}<{'8' if what == 'string' else 'T, 8'}>",
                )


def _unbounded(context: Context, type_: Type) -> str | None:
    match context.model.unalias(type_):
        case SequenceType(element, bound):
            return "sequence" if bound is None else _unbounded(context, element)
        case StringType(wide, None):
            return "wstring" if wide else "string"
        case ArrayType(element):
            return _unbounded(context, element)
        case MapType(key, value, bound):
            if bound is None:
                return "map"
            return _unbounded(context, key) or _unbounded(context, value)
    return None


def unbounded_on_boards(context: Context) -> Iterator[Diagnostic]:
    """Report data ports without a bound where memory is preallocated: the target small."""
    if context.target != _SMALL:
        return
    for _, port in _ports(context):
        what, field = _first_field(context, port.type, _unbounded, set())
        if what is not None:
            inside = "" if field is None else f" in {field.name}"
            yield rules.UNBOUNDED_ON_BOARD.at(
                port.span,
                f"the data of {port.name} holds a {what} without a bound{inside}",
                related=[] if field is None else [Related(field.span, "here")],
                hint="a board reserves the number of elements given by [small]; declare a bound",
            )


def missing_enumerators(context: Context) -> Iterator[Diagnostic]:
    """Report unions over an enum with neither a default nor a branch for each enumerator."""
    for declaration in context.declarations:
        if not isinstance(declaration, Union):
            continue
        enum = context.model.declared(declaration.switch)
        if not isinstance(enum, Enum) or any(c.default for c in declaration.cases):
            continue
        listed = {
            label.name[-1]
            for case in declaration.cases
            for label in case.labels
            if isinstance(label, EnumeratorName)
        }
        missing = [m for m in enum.members if m.name not in listed]
        if missing:
            names = ", ".join(m.name for m in missing[:_MAX_NAMED])
            more = (
                f" and {len(missing) - _MAX_NAMED} more"
                if len(missing) > _MAX_NAMED
                else ""
            )
            yield rules.MISSING_ENUMERATORS.at(
                declaration.span,
                f"{declaration.scoped} has no branch for {names}{more}",
                related=[
                    Related(missing[0].span, f"{missing[0].name} is declared here")
                ],
                hint="write a branch for each, or a default",
            )
