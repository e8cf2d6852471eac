"""Compares the units of two data ports that a connector joins (codes RTC0593 to RTC0596)."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.diagnostics import Diagnostic, Related, Rule, Severity
from rtgen.model import Connection, Model, NamedType, Port, Struct
from rtgen.typemap.member_units import Leaf, is_real, leaves

DIMENSIONS_DIFFER = Rule("RTC0593", "ports of different dimensions", Severity.ERROR)
UNIT_MISSING = Rule("RTC0594", "unit at one end of a connector only", Severity.NOTE)
SCALES_DIFFER = Rule("RTC0595", "ports of different scales", Severity.WARNING)
MAY_DIFFER = Rule("RTC0596", "units that may not fit", Severity.WARNING)

RULES = (DIMENSIONS_DIFFER, UNIT_MISSING, SCALES_DIFFER, MAY_DIFFER)


def check(
    connection: Connection, source: Port, target: Port, model: Model
) -> Iterator[Diagnostic]:
    """Yield diagnostics about the units of two ports of one type; `model` has that type."""
    sent, wanted = (" ".join(port.unit.split()) for port in (source, target))
    if sent == wanted:
        return
    related = [
        Related(port.span, f"{end}: {port.unit.strip() or 'no unit'}")
        for end, port in ((connection.source, source), (connection.target, target))
    ]
    if not sent or not wanted:
        end = connection.target if sent else connection.source
        message = f"{end} does not say its unit, the other end has {sent or wanted}"
        hint = f'write @unit("{sent or wanted}") at the port'
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
    struct = model.find(type_.name) if isinstance(type_, NamedType) else None
    members = list(leaves(model, struct)) if isinstance(struct, Struct) else []
    reals = [leaf for leaf in members if is_real(model, leaf.type)]
    units = ", ".join(
        f'"{path}" = ["{sent}", "{wanted}"]'
        for place, (sent, wanted) in enumerate(scaled)
        for path in _paths(reals, sent) or (f"MEMBER{place or ''}",)
    )
    return (
        f'connect through an adapter of rtgen.toml, [adapter.NAME] with from = "{name}", '
        f'to = "{name}", units = {{ {units} }}; or correct @unit'
    )


def _paths(reals: list[Leaf], unit: str) -> list[str]:
    """Return the paths of the members in a unit: those of its dimension, or the only one."""
    from rtgen.units import Relation, UnitError, parse, relation

    found = []
    for leaf in reals:
        try:
            stated = relation(parse(leaf.unit or ""), parse(unit))
        except UnitError:
            continue
        if stated in (Relation.EQUAL, Relation.SCALED):
            found.append(leaf)
    return [".".join(leaf.path) for leaf in found or (reals if len(reals) == 1 else ())]
