"""Converts constraint elements of a profile to the text form."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.frontends.profiles.rtc_profile.names import RTC
from rtgen.facts.constraints import (
    AllOf,
    AnyOf,
    Between,
    Comparison,
    Constraint,
    ItemConstraints,
    KeyConstraints,
    Operator,
    Unit,
)

_OPERATORS = {
    "propertyIsEqualTo": Operator.EQUAL,
    "propertyIsLessThan": Operator.LESS,
    "propertyIsGreaterThan": Operator.GREATER,
    "propertyIsLessThanOrEqualTo": Operator.LESS_OR_EQUAL,
    "propertyIsGreaterThanOrEqualTo": Operator.GREATER_OR_EQUAL,
}
_LOWER = (Operator.GREATER, Operator.GREATER_OR_EQUAL)
_UPPER = (Operator.LESS, Operator.LESS_OR_EQUAL)


class NoTextFormError(ValueError):
    """A constraint without a text form in OpenRTM; the message names the part."""


def constraint(element: Element) -> Constraint:
    """Convert the content of `rtc:Constraint`. Raises NoTextFormError."""
    kind, inner = _only(element)
    if kind == "ConstraintListType":
        return ItemConstraints(tuple(_unit(item) for item in _constraints(inner)))
    if kind == "ConstraintHashType":
        pairs = [(_key(item), _unit(item)) for item in _constraints(inner)]
        return KeyConstraints(tuple(pairs))
    return _unit(element)


def _constraints(element: Element) -> Iterator[Element]:
    return element.all(RTC, "Constraint")


def _key(element: Element) -> str:
    _, inner = _only(element)
    key = inner.get(RTC, "key")
    if not key:
        raise NoTextFormError("a constraint of a hash has no `rtc:key`")
    return key


def _only(element: Element) -> tuple[str, Element]:
    """Return the only child element, and its name."""
    inside = [child for child in element.children if child.name[0] == RTC]
    if len(inside) != 1:
        names = ", ".join(child.name[1] for child in inside) or "nothing"
        raise NoTextFormError(f"`{element.name[1]}` holds {names}, not one constraint")
    return inside[0].name[1], inside[0]


def _unit(element: Element) -> Unit:
    kind, inner = _only(element)
    if kind != "ConstraintUnitType":
        raise NoTextFormError(f"`{kind}` inside of a list or hash")
    kind, inner = _only(inner)
    if kind in _OPERATORS:
        return Comparison(_OPERATORS[kind], _literal(inner))
    if kind == "propertyIsBetween":
        ends = [inner.first(RTC, name) for name in ("LowerBoundary", "UpperBoundary")]
        low, high = (_text(end) for end in ends)
        return Between(low, high)
    if kind == "Or":
        items = _comparisons(inner)
        if all(item.operator is Operator.EQUAL for item in items):
            return AnyOf(items) if len(items) > 1 else items[0]
    if kind == "And":
        items = _comparisons(inner)
        lower = [item for item in items if item.operator in _LOWER]
        upper = [item for item in items if item.operator in _UPPER]
        if len(items) == 2 and len(lower) == len(upper) == 1:
            return AllOf((lower[0], upper[0]))
    raise NoTextFormError(
        f"the text form of constraints has no words for this `{kind}`"
    )


def _comparisons(element: Element) -> tuple[Comparison, ...]:
    units = [_unit(item) for item in _constraints(element)]
    comparisons = tuple(unit for unit in units if isinstance(unit, Comparison))
    if not comparisons or len(comparisons) != len(units):
        raise NoTextFormError(f"`{element.name[1]}` of what is not a comparison")
    return comparisons


def _literal(element: Element) -> str:
    return _text(element.first(RTC, "Literal"))


def _text(element: Element | None) -> str:
    text = "" if element is None else element.text.strip()
    if not text:
        raise NoTextFormError("a comparison with nothing")
    return text
