"""Compares the units of two data ports that a connector joins (codes RTC0593 to RTC0596)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule
from rtgen.compiler.model import Connection, Model, NamedType, Port, Struct
from rtgen.compiler.systems.connection_rules import (
    DIMENSIONS_DIFFER,
    MAY_DIFFER,
    SCALES_DIFFER,
    UNIT_MISSING,
)
from rtgen.compiler.typemap.member_units import Leaf, is_real, leaves
from rtgen.facts.connector_properties import ALLOW

_OTHERWISE = (
    "connect another port, correct @unit, or allow it by a reason in the property"
    f" {ALLOW}{DIMENSIONS_DIFFER.code} of the connector"
)


def check(
    connection: Connection,
    source: Port,
    target: Port,
    model: Model,
    target_model: Model,
) -> Iterator[Diagnostic]:
    """Yield diagnostics about the units of two ports of one type, each with its model.

    The members of the type may have other units in another model.
    """
    sent, received = (" ".join(port.unit.split()) for port in (source, target))
    if sent == received and (sent or model is target_model):
        return
    silent = (not sent, not received)
    known = _of_type(source, model), _of_type(target, target_model)
    if any(silent) and _are_equal(sent or known[0].text, received or known[1].text):
        return
    sent = sent or known[0].whole
    received = received or known[1].whole
    related = [
        Related(port.span, f"{end}: {_shown(text, is_silent)}")
        for end, port, text, is_silent in (
            (connection.source, source, sent, silent[0]),
            (connection.target, target, received, silent[1]),
        )
    ]
    is_vague = any(silent) and sent.count(",") != received.count(",")
    if not sent or not received or (is_vague and not _is_strange(sent, received)):
        end = connection.source if silent[0] else connection.target
        unit = received if silent[0] else sent
        message = f"{end} does not say its unit, the other end has {unit}"
        hint = f'write @unit("{unit}") at the port'
        yield UNIT_MISSING.at(connection.span, message, related=related, hint=hint)
        return
    rule, hint = _compared(sent, received, source, model)
    if rule is not None:
        message = (
            f"{connection.source} gives {sent}, {connection.target} takes {received}"
        )
        yield rule.at(connection.span, message, related=related, hint=hint)


def _shown(unit: str, is_silent: bool) -> str:
    if not unit:
        return "no unit"
    return f"{unit}, by its type" if is_silent else unit


class _OfType(NamedTuple):
    """The units of the numbers in a type, each once; `is_whole` if each number has one."""

    text: str
    is_whole: bool

    @property
    def whole(self) -> str:
        """The units, if they are all."""
        return self.text if self.is_whole else ""


def _of_type(port: Port, model: Model) -> _OfType:
    """Return the units by the type of a port.

    Integers count only in a type without real numbers, since many are no quantities.
    """
    members = _reals(port, model) or _integers(port, model)
    units = [leaf.unit for leaf in members]
    valid = [unit for unit in units if unit and _is_unit(unit)]
    return _OfType(", ".join(dict.fromkeys(valid)), len(valid) == len(units))


def _are_equal(sent: str, received: str) -> bool:
    """Return whether two lists denote the same units."""
    from rtgen.compiler.kit.units import Relation, UnitError, parse_list, relation

    if not sent or sent == received:
        return sent == received
    try:
        units = parse_list(sent), parse_list(received)
    except UnitError:
        return False
    return len(units[0]) == len(units[1]) and all(
        relation(*pair) is Relation.EQUAL for pair in zip(*units, strict=True)
    )


def _is_strange(sent: str, received: str) -> bool:
    """Return whether one of two lists has a unit of another dimension than all of the other's."""
    from rtgen.compiler.kit.units import Relation, UnitError, parse_list, relation

    try:
        units = parse_list(sent), parse_list(received)
    except UnitError:
        return False
    return any(
        all(relation(unit, other) is Relation.DIFFERENT for other in others)
        for those, others in (units, units[::-1])
        for unit in (those if len(those) < len(others) else ())
    )


def _is_unit(text: str) -> bool:
    from rtgen.compiler.kit.units import UnitError, parse

    try:
        parse(text)
    except UnitError:
        return False
    return True


def _compared(
    sent: str, received: str, source: Port, model: Model
) -> tuple[Rule | None, str]:
    """Return the rule violated by two different texts of units, if any, with a hint."""
    from rtgen.compiler.kit.units import Relation, UnitError, parse_list, relation

    texts = [[part.strip() for part in text.split(",")] for text in (sent, received)]
    try:
        units = [parse_list(text) for text in (sent, received)]
    except UnitError as error:
        return MAY_DIFFER, f"correct @unit: {error}"
    if len(units[0]) != len(units[1]):
        if _is_strange(sent, received):
            return DIMENSIONS_DIFFER, _OTHERWISE
        return MAY_DIFFER, "name one unit for each member at both ports"
    related = [relation(*pair) for pair in zip(*units, strict=True)]
    if Relation.DIFFERENT in related:
        return DIMENSIONS_DIFFER, _OTHERWISE
    if Relation.ANGLE in related:
        return MAY_DIFFER, "say at both ports whether it is an angle: rad/s, or Hz"
    scaled = [
        pair
        for pair, each in zip(zip(*texts, strict=True), related, strict=True)
        if each is Relation.SCALED
    ]
    return (SCALES_DIFFER, _adapter(source, model, scaled)) if scaled else (None, "")


def _adapter(source: Port, model: Model, scaled: list[tuple[str, str]]) -> str:
    """Return a hint with an adapter that converts, if there can be one."""
    reals = [leaf for leaf in _reals(source, model) if not leaf.optional]
    if not reals:
        return "correct @unit, or convert in a component: an adapter converts no such member"
    type_ = model.unalias(source.type)
    name = "::".join(type_.name) if isinstance(type_, NamedType) else str(type_)
    units = ", ".join(
        f'"{path}" = ["{sent}", "{received}"]'
        for place, (sent, received) in enumerate(scaled)
        for path in _paths(reals, sent) or (f"MEMBER{place or ''}",)
    )
    return (
        f'connect through an adapter of rtgen.toml, [adapter.NAME] with from = "{name}", '
        f'to = "{name}", units = {{ {units} }}; or correct @unit'
    )


def _reals(port: Port, model: Model) -> list[Leaf]:
    """Return the real numbers of a port's type."""
    return [leaf for leaf in _members(port, model) if is_real(model, leaf.type)]


def _integers(port: Port, model: Model) -> list[Leaf]:
    """Return the other members of a port's type that have a unit."""
    return [leaf for leaf in _members(port, model) if leaf.unit]


def _members(port: Port, model: Model) -> Iterator[Leaf]:
    struct = model.declared(port.type)
    return leaves(model, struct) if isinstance(struct, Struct) else iter(())


def _paths(reals: list[Leaf], unit: str) -> list[str]:
    """Return the paths of the members in a unit: those of its dimension, or the only one."""
    from rtgen.compiler.kit.units import Relation, parse, relation

    paths = []
    for leaf in reals:
        if not leaf.unit or not _is_unit(leaf.unit):
            continue
        if relation(parse(leaf.unit), parse(unit)) in (Relation.EQUAL, Relation.SCALED):
            paths.append(leaf)
    return [".".join(leaf.path) for leaf in paths or (reals if len(reals) == 1 else ())]
