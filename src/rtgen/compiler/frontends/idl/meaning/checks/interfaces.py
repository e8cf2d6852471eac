"""Checks of interfaces: bases and inherited members."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.rules import interfaces as rules
from rtgen.compiler.frontends.idl.syntax import tree

_FEATURES = (Kind.OPERATION, Kind.ATTRIBUTE)


def bases(entity: Entity, context: Context) -> None:
    """Check that bases are named once, and are compatible with abstract and local."""
    node = entity.node
    assert isinstance(node, tree.Interface)
    seen: dict[Entity, tree.ScopedName] = {}
    for name in node.bases:
        base = context.target(name)
        if base is None:
            continue
        if base in seen:
            context.report_repeated_base(entity, base, name, seen[base])
        seen[base] = name
        if node.modifier == "abstract" and base.modifier != "abstract":
            message = (
                f"the abstract interface {entity.name} cannot inherit from {base.name}"
            )
            hint = f"make {base.name} abstract"
            context.report_base(rules.ABSTRACT_BASE, entity, name, message, hint)
        if node.modifier != "local" and base.modifier == "local":
            message = (
                f"{entity.name} is not local, so it cannot inherit from {base.name}"
            )
            hint = f"make {entity.name} local"
            context.report_base(rules.LOCAL_BASE, entity, name, message, hint)


def inherited(entity: Entity, context: Context) -> None:
    """Check that operations and attributes are neither redeclared nor inherited twice."""
    scope = entity.inner
    if scope is None or not scope.bases:
        return
    members: dict[str, Entity] = {}
    for base in scope.all_bases():
        for key, feature in base.names.items():
            if feature.kind not in _FEATURES and feature.kind is not Kind.MEMBER:
                continue
            other = members.setdefault(key, feature)
            if other is not feature:
                context.report(
                    rules.INHERITED_CLASH.at(
                        entity.span,
                        f"{entity.name} inherits {feature.name} twice",
                        related=[
                            Related(other.span, f"from {'::'.join(other.path[:-1])}"),
                            Related(
                                feature.span, f"from {'::'.join(feature.path[:-1])}"
                            ),
                        ],
                        hint="rename one, or move it to a base that both inherit from",
                    )
                )
    for key, own in scope.names.items():
        above = members.get(key)
        if above is not None:
            context.report(
                rules.REDEFINED.at(
                    own.span,
                    f"{own.name} is inherited from {'::'.join(above.path[:-1])} already",
                    related=[Related(above.span, "declared here")],
                    hint="leave it out: it is inherited",
                )
            )
