"""Reports valid declarations that are dropped because they need unsupported ones."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.rules import types as rules
from rtgen.compiler.frontends.idl.syntax import tree


def report(tables: Tables, context: Context) -> None:
    """Report dropped declarations, and dropped parts of interfaces and components.

    Only for a translation unit without errors, which would explain what is missing.
    """
    if all(map(_is_made, tables.references.values())):
        return
    for entity in tables.declared:
        if entity.node is None:
            continue
        if entity.path not in context.made:
            _report_one(entity, entity.name, context)
            continue
        for name in _parts(entity, context):
            _report_one(tables.entities[name], f"{entity.name}::{name.text}", context)
        for used in _mentioned(entity.node):
            if not _is_made(tables.references.get(used)):
                context.report_at(
                    rules.LEFT_OUT,
                    entity.unit,
                    used,
                    f"{used} is left out, as rtgen generates nothing for it",
                    hint="declare it outside of template modules",
                )


def _report_one(entity: Entity, name: str, context: Context) -> None:
    context.report(
        rules.LEFT_OUT.at(
            entity.span,
            f"{name} is left out, as it needs something of which nothing is made",
            hint="use declarations outside of template modules",
        )
    )


def _is_made(entity: object) -> bool:
    return entity is not None and not (isinstance(entity, Entity) and entity.poisoned)


def _parts(entity: Entity, context: Context) -> Iterator[tree.Name]:
    """Yield the operations, attributes and ports with an unsupported type."""
    body = getattr(entity.node, "body", None)
    for item in body.items if isinstance(body, tree.Body) else ():
        types: tuple[tree.TypeNode | None, ...]
        match item.node:
            case tree.Operation() as node:
                types = (node.type, *(p.type for p in node.parameters))
                names: tuple[tree.Name, ...] = (node.name,)
            case tree.Attribute() as node:
                types, names = (node.type,), node.names
            case tree.PortItem() as node if node.keyword not in ("port", "mirrorport"):
                types, names = (node.type,), (node.name,)
            case _:
                continue
        for type_ in types:
            if type_ is not None and context.types.of_node(type_, entity.unit) is None:
                yield from names
                break


def _mentioned(node: object) -> Iterator[tree.ScopedName]:
    """Yield the exceptions and supported interfaces of a declaration."""
    yield from getattr(node, "supports", ())
    body = getattr(node, "body", None)
    for item in body.items if isinstance(body, tree.Body) else ():
        match item.node:
            case tree.Operation(raises=clause):
                clauses = [clause]
            case tree.Attribute(get_raises=getter, set_raises=setter):
                clauses = [getter, setter]
            case _:
                continue
        for clause in clauses:
            yield from clause.names if clause else ()
