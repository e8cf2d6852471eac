"""Checks of unions: switch, labels, default."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Related, Span
from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.rules import types as rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.model import (
    ConstantValue,
    NamedType,
    Primitive,
    PrimitiveType,
    Type,
)

_CHARACTERS = 256


def branches(entity: Entity, context: Context) -> None:
    """Check that the switch type is valid, and that there are branches, all with data types."""
    node = entity.node
    assert isinstance(node, tree.Union)
    cases = [item.node for item in node.body.items if isinstance(item.node, tree.Case)]
    if not cases and not any(isinstance(i.node, tree.Skipped) for i in node.body.items):
        context.report(
            rules.EMPTY_UNION.at(
                entity.span,
                f"{entity.name} has no branch",
                hint="write 'case VALUE: TYPE NAME;' between { and }",
            )
        )
    for case in cases:
        context.is_data(case.type, entity.unit)
    type_ = context.types.of_node(node.switch, entity.unit)
    if type_ is not None and not context.types.can_switch(type_):
        message = f"a union cannot switch on {type_}"
        hint = "it switches on an integer, a character, a boolean or an enum"
        context.report_at(
            rules.BAD_SWITCH, entity.unit, node.switch, message, hint=hint
        )


def labels(entity: Entity, context: Context) -> None:
    """Check that labels are unique, and a default is given once, and only if values remain."""
    node = entity.node
    assert isinstance(node, tree.Union)
    unit = entity.unit
    switch = context.types.of_node(node.switch, unit)
    if switch is None or not context.types.can_switch(switch):
        return
    seen: dict[ConstantValue, Span] = {}
    default: tree.Label | None = None
    whole = True
    for item in node.body.items:
        for label in item.node.labels if isinstance(item.node, tree.Case) else ():
            span = unit.span(label.start, label.end)
            if label.value is None:
                if default is not None:
                    related = [
                        Related(unit.span(default.start, default.end), "the first one")
                    ]
                    message = "this union has a default already"
                    context.report(
                        rules.SECOND_DEFAULT.at(
                            span, message, related=related, hint="keep one of them"
                        )
                    )
                default = default or label
                continue
            value = context.types.constants.evaluate(
                label.value, switch, unit, "switch"
            )
            if value is None:
                whole = False
            elif value in seen:
                related = [Related(seen[value], "the first one")]
                message = "this label is given twice"
                hint = "remove one, or correct its value"
                context.report(
                    rules.DUPLICATE_LABEL.at(span, message, related=related, hint=hint)
                )
            else:
                seen[value] = span
    if default is not None and whole and len(seen) == _values(switch, context):
        message = "the labels name every value, so nothing is left for default"
        hint = "remove the default"
        context.report_at(rules.SUPERFLUOUS_DEFAULT, unit, default, message, hint=hint)


def _values(switch: Type, context: Context) -> int | None:
    """Return the number of values of the switch; None if there are too many to list."""
    match context.types.unaliased(switch):
        case PrimitiveType(Primitive.BOOLEAN):
            return 2
        case PrimitiveType(
            Primitive.CHAR | Primitive.OCTET | Primitive.INT8 | Primitive.UINT8
        ):
            return _CHARACTERS
        case NamedType(name):
            entity = context.types.entity(name)
            if entity is not None and isinstance(entity.node, tree.Enum):
                return len(entity.node.members)
    return None
