"""Compares the units of two data ports that a connector joins (codes RTC0593 to RTC0596)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from rtgen.diagnostics import Diagnostic, Related, Rule, Severity
from rtgen.model import (
    ArrayType,
    Connection,
    Model,
    NamedType,
    Port,
    Primitive,
    PrimitiveType,
    SequenceType,
    Struct,
)

DIMENSIONS_DIFFER = Rule("RTC0593", "ports of different dimensions", Severity.ERROR)
UNIT_MISSING = Rule("RTC0594", "unit at one end of a connector only", Severity.NOTE)
SCALES_DIFFER = Rule("RTC0595", "ports of different scales", Severity.WARNING)
MAY_DIFFER = Rule("RTC0596", "units that may not fit", Severity.WARNING)

RULES = (DIMENSIONS_DIFFER, UNIT_MISSING, SCALES_DIFFER, MAY_DIFFER)

_REAL = (Primitive.FLOAT, Primitive.DOUBLE, Primitive.LONG_DOUBLE)


def check(
    connection: Connection, source: Port, target: Port, model: Model
) -> Iterator[Diagnostic]:
    """Yield diagnostics about the units of two ports of one type; `model` has that type."""
    sent, wanted = ("".join(port.unit.split()) for port in (source, target))
    if sent == wanted:
        return
    related = [
        Related(port.span, f"{end}: {port.unit or 'no unit'}")
        for end, port in ((connection.source, source), (connection.target, target))
    ]
    if not sent or not wanted:
        end = connection.target if sent else connection.source
        message = f"{end} does not say its unit, the other end has {source.unit or target.unit}"
        hint = f'write @unit("{source.unit or target.unit}") at the port'
        yield UNIT_MISSING.at(connection.span, message, related=related, hint=hint)
        return
    rule, hint = _compared(source, target, model)
    if rule is not None:
        message = (
            f"{connection.source} gives {source.unit}, "
            f"{connection.target} takes {target.unit}"
        )
        yield rule.at(connection.span, message, related=related, hint=hint)


def _compared(source: Port, target: Port, model: Model) -> tuple[Rule | None, str]:
    """Return the rule violated by two different texts of units, if any, with a hint."""
    from rtgen.units import Relation, UnitError, parse_list, relation

    texts = [[part.strip() for part in p.unit.split(",")] for p in (source, target)]
    try:
        units = [parse_list(port.unit) for port in (source, target)]
    except UnitError as error:
        return MAY_DIFFER, f"correct @unit: {error}"
    if len(units[0]) != len(units[1]):
        return MAY_DIFFER, "name one unit for each member at both ports"
    related = [relation(*pair) for pair in zip(*units, strict=True)]
    if Relation.DIFFERENT in related:
        return DIMENSIONS_DIFFER, "connect another port, or correct @unit"
    if Relation.ANGLE in related:
        return MAY_DIFFER, "say at both ports whether it is an angle: rad/s, or Hz"
    scaled = [
        pair
        for pair, each in zip(zip(*texts, strict=True), related, strict=True)
        if each is Relation.SCALED
    ]
    return (SCALES_DIFFER, _adapter(source, model, scaled)) if scaled else (None, "")


def _adapter(source: Port, model: Model, scaled: list[tuple[str, str]]) -> str:
    """Return a hint with an adapter that converts."""
    type_ = model.unalias(source.type)
    name = "::".join(type_.name) if isinstance(type_, NamedType) else str(type_)
    leaves = list(_numbers(model, type_, ()))
    paths = [
        ".".join(leaves[0]) if len(leaves) == 1 else f"MEMBER{place or ''}"
        for place in range(len(scaled))
    ]
    units = ", ".join(
        f'"{path}" = ["{sent}", "{wanted}"]'
        for path, (sent, wanted) in zip(paths, scaled, strict=True)
    )
    return (
        f'connect through an adapter of rtgen.toml, [adapter.NAME] with from = "{name}", '
        f'to = "{name}", units = {{ {units} }}; or correct @unit'
    )


def _numbers(
    model: Model, type_: object, path: tuple[str, ...]
) -> Iterator[tuple[str, ...]]:
    """Yield the paths of all members that are real numbers, or sequences and arrays of them."""
    match type_:
        case NamedType(name):
            declaration = model.find(name)
            if isinstance(declaration, Struct):
                inherited = NamedType(declaration.base) if declaration.base else None
                yield from chain(
                    _numbers(model, inherited, path),
                    *(
                        _numbers(model, model.unalias(m.type), (*path, m.name))
                        for m in declaration.members
                    ),
                )
        case SequenceType(element=element) | ArrayType(element=element):
            inner = model.unalias(element)
            if isinstance(inner, PrimitiveType) and inner.kind in _REAL:
                yield path
        case PrimitiveType(kind) if kind in _REAL:
            yield path
