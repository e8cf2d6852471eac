"""Checks of valuetypes and value boxes (CORBA 2.6, 3.8)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.rules import interfaces as rules
from rtgen.compiler.frontends.idl.rules import types as type_rules
from rtgen.compiler.frontends.idl.syntax import tree


def bases(entity: Entity, context: Context) -> None:
    """Check that there is at most one concrete base, in the first place.

    Also that abstract, custom and truncatable are compatible.
    """
    node = entity.node
    assert isinstance(node, tree.Valuetype)
    _concrete_first(entity, node.bases, "base", context)
    _concrete_first(entity, node.supports, "supported interface", context)
    for name in node.bases:
        base = context.target(name)
        if base is None:
            continue
        if node.modifier == "abstract" and base.modifier != "abstract":
            message = (
                f"the abstract valuetype {entity.name} cannot inherit from {base.name}"
            )
            hint = f"make {base.name} abstract"
            context.report_base(rules.ABSTRACT_BASE, entity, name, message, hint)
        if base.modifier == "custom" and node.modifier != "custom":
            message = (
                f"{entity.name} is not custom, so it cannot inherit from {base.name}"
            )
            hint = f"make {entity.name} custom"
            context.report_base(rules.CUSTOM, entity, name, message, hint)
    if node.truncatable and node.modifier == "custom":
        message = f"{entity.name} is custom, so it cannot be truncatable"
        hint = "remove custom or truncatable"
        context.report(rules.CUSTOM.at(entity.span, message, hint=hint))
    elif node.truncatable and node.bases:
        first = context.target(node.bases[0])
        if first is not None and first.modifier == "abstract":
            message = f"{entity.name} is truncatable, but has no concrete base"
            context.report(
                rules.NOTHING_TO_TRUNCATE.at(
                    entity.span,
                    message,
                    related=[Related(first.span, f"{first.name} is abstract")],
                    hint="remove truncatable",
                )
            )


def _concrete_first(
    entity: Entity, names: tuple[tree.ScopedName, ...], what: str, context: Context
) -> None:
    seen: dict[Entity, tree.ScopedName] = {}
    for index, name in enumerate(names):
        base = context.target(name)
        if base is None:
            continue
        if base in seen:
            context.report_repeated_base(entity, base, name, seen[base])
        elif index and base.modifier != "abstract":
            message = f"{base.name} is not abstract, so it can only be the first {what}"
            hint = f"put {base.name} first, and make the others abstract"
            context.report_base(rules.CONCRETE_BASES, entity, name, message, hint)
        seen.setdefault(base, name)


def members(entity: Entity, context: Context) -> None:
    """Check that state members are data, not local, and not in an abstract valuetype."""
    node = entity.node
    assert isinstance(node, tree.Valuetype)
    for item in node.body.items:
        match item.node:
            case tree.State(member=member):
                if node.modifier == "abstract":
                    message = f"the abstract valuetype {entity.name} has no state"
                    name = member.declarators[0].name
                    hint = f"remove abstract from {entity.name}, or the member"
                    context.report_at(
                        rules.ABSTRACT_STATE, entity.unit, name, message, hint=hint
                    )
                if context.is_data(member.type, entity.unit) and context.is_local(
                    context.types.of_node(member.type, entity.unit)
                ):
                    message = "state cannot be of a local type"
                    context.report_at(
                        type_rules.LOCAL_TYPE,
                        entity.unit,
                        member.type,
                        message,
                        hint="use a type that is not local",
                    )
            case tree.Operation(factory="factory") as operation if (
                node.modifier == "abstract"
            ):
                message = f"the abstract valuetype {entity.name} has no factories"
                hint = f"remove abstract from {entity.name}, or the factory"
                context.report_at(
                    rules.ABSTRACT_STATE,
                    entity.unit,
                    operation.name,
                    message,
                    hint=hint,
                )


def box(entity: Entity, context: Context) -> None:
    """Check that a box contains data other than a value."""
    node = entity.node
    assert isinstance(node, tree.ValueBox)
    if not context.is_data(node.type, entity.unit):
        return
    plain = context.types.unaliased(context.types.of_node(node.type, entity.unit))
    if plain is not None and context.types.kind_of(plain) in (
        Kind.VALUETYPE,
        Kind.VALUE_BOX,
    ):
        context.report_at(
            rules.BOXED_VALUE,
            entity.unit,
            node.type,
            f"{node.name.text} boxes a value",
            hint="use the valuetype itself: it can be null already",
        )
