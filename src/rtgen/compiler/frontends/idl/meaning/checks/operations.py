"""Checks of operations and attributes: directions, results, exceptions, oneway, context."""

from __future__ import annotations

import re

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.rules import interfaces as rules
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.rules import types as type_rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.model import Direction, Primitive

_CONTEXT = re.compile(r"[A-Za-z][A-Za-z0-9._]*\*?")
_CLAUSES = {
    (False, "raises"): "write getraises, setraises, or both",
    (True, "setraises"): "write raises, or leave readonly out",
}
"""Clauses that an attribute must not have, with their replacement, by whether it is readonly."""
_NAMELESS = (
    tree.Sequence,
    tree.Map,
    tree.Fixed,
    tree.Struct,
    tree.Union,
    tree.Enum,
    tree.Bitset,
)


def all_of(entity: Entity, context: Context) -> None:
    """Check each operation and attribute of an interface or valuetype."""
    node = entity.node
    assert isinstance(node, tree.Interface | tree.Valuetype)
    remote = isinstance(node, tree.Interface) and node.modifier != "local"
    for item in node.body.items:
        match item.node:
            case tree.Operation():
                _operation(item.node, entity, context, remote)
            case tree.Attribute():
                _attribute(item.node, entity, context, remote)


def _operation(
    node: tree.Operation, entity: Entity, context: Context, remote: bool
) -> None:
    unit = entity.unit
    if node.type is not None and not _is_void(node.type):
        _type(node.type, entity, context, remote)
        if node.oneway:
            message = f"{node.name.text} is oneway, so it returns void"
            hint = "write void, or leave oneway out"
            context.report_at(rules.ONEWAY, unit, node.type, message, hint=hint)
    for parameter in node.parameters:
        _parameter(parameter, node, entity, context, remote)
    if node.raises is not None:
        _raises(node.raises, entity, context, remote)
        if node.oneway:
            message = f"{node.name.text} is oneway, so it raises nothing"
            hint = "leave raises or oneway out"
            context.report_at(rules.ONEWAY, unit, node.raises, message, hint=hint)
    for text in node.context:
        name = "".join(part[1:-1] for part in text.parts)
        if not _CONTEXT.fullmatch(name):
            hint = "letters, digits, '.' and '_'; one '*' at the end"
            message = f'"{name}" is not a context name'
            context.report_at(rules.BAD_CONTEXT, unit, text, message, hint=hint)


def _parameter(
    parameter: tree.Parameter,
    node: tree.Operation,
    entity: Entity,
    context: Context,
    remote: bool,
) -> None:
    unit = entity.unit
    name = parameter.declarator.name
    if parameter.direction is None:
        message = f"the parameter {name.text} has no direction"
        context.report_at(
            syntax.MISSING_DIRECTION,
            unit,
            parameter.type,
            message,
            hint="put in, out or inout before its type",
        )
    elif parameter.direction is not Direction.IN:
        if node.oneway:
            message = f"{node.name.text} is oneway, so its parameters are in"
            hint = "write in, or leave oneway out"
            context.report_at(rules.ONEWAY, unit, name, message, hint=hint)
        if node.factory:
            message = f"the parameters of a {node.factory} are in"
            hint = "write in"
            context.report_at(rules.BAD_PARAMETER, unit, name, message, hint=hint)
    if parameter.declarator.dimensions:
        context.report_at(
            type_rules.ANONYMOUS,
            unit,
            name,
            "an array needs a name here",
            hint="use a typedef",
        )
    _type(parameter.type, entity, context, remote)


def _is_void(node: tree.TypeNode) -> bool:
    return isinstance(node, tree.BasicType) and node.kind is Primitive.VOID


def _type(node: tree.TypeNode, entity: Entity, context: Context, remote: bool) -> None:
    if isinstance(node, tree.BasicType) and not _is_void(node):
        return
    if isinstance(node, tree.TextType) and node.bound is None:
        return
    if isinstance(node, _NAMELESS):
        context.report_at(
            type_rules.ANONYMOUS,
            entity.unit,
            (
                node
                if not isinstance(node, tree.Struct | tree.Union | tree.Bitset)
                else node.name
            ),
            "a type declared in place is not allowed here",
            hint="give it a name before: use a typedef",
        )
        return
    if not context.is_data(node, entity.unit):
        return
    if remote and context.is_local(context.types.of_node(node, entity.unit)):
        _mentions_local(node, entity, context)


def _mentions_local(node: tree.TypeNode, entity: Entity, context: Context) -> None:
    message = f"{entity.name} is not local, so it cannot mention a local type"
    hint = f"make {entity.name} local, or use a type that is not"
    context.report_at(type_rules.LOCAL_TYPE, entity.unit, node, message, hint=hint)


def _attribute(
    node: tree.Attribute, entity: Entity, context: Context, remote: bool
) -> None:
    _type(node.type, entity, context, remote)
    for clause in (node.get_raises, node.set_raises):
        if clause is None:
            continue
        hint = _CLAUSES.get((node.readonly, clause.keyword))
        if hint is not None:
            which = "that is readonly" if node.readonly else "that can be set"
            message = f"an attribute {which} has no {clause.keyword}"
            context.report_at(rules.BAD_CLAUSE, entity.unit, clause, message, hint=hint)
        _raises(clause, entity, context, remote)


def _raises(clause: tree.Names, entity: Entity, context: Context, remote: bool) -> None:
    unit = entity.unit
    if not clause.names:
        hint = "name an exception, or leave raises out"
        context.report_at(
            syntax.EMPTY_RAISES, unit, clause, "no exception is named", hint=hint
        )
    seen: dict[Entity, tree.ScopedName] = {}
    for name in clause.names:
        exception = context.target(name)
        if exception is None:
            continue
        if exception.kind not in (Kind.EXCEPTION, Kind.NATIVE):
            context.report_at(
                rules.NOT_RAISABLE,
                unit,
                name,
                f"the {exception.kind} {exception.scoped} is not an exception",
                related=[Related(exception.span, "declared here")],
                hint=f"declare it as exception {exception.name} {{ ... }};",
            )
        elif exception in seen:
            first = unit.span(seen[exception].start, seen[exception].end)
            context.report_at(
                rules.RAISED_TWICE,
                unit,
                name,
                f"{exception.name} is named twice",
                related=[Related(first, "the first time")],
                hint="remove one",
            )
        elif remote and context.is_local(context.types.named(exception)):
            _mentions_local(name, entity, context)
        seen.setdefault(exception, name)
