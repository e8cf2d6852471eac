"""Semantic checks of resolved declarations, one module for each family of rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.meaning.checks import (
    defaults,
    interfaces,
    missing_definitions,
    operations,
    structures,
    unions,
    values,
)
from rtgen.compiler.frontends.idl.meaning.checks.context import Context
from rtgen.compiler.frontends.idl.meaning.typetable import Types
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.model import Declaration, ScopedName

_CHECKS: Mapping[Kind, tuple[Callable[[Entity, Context], None], ...]] = {
    Kind.STRUCT: (
        interfaces.inherited,
        structures.members,
        structures.annotated,
        defaults.defaults,
        structures.member_ids,
    ),
    Kind.EXCEPTION: (structures.members, structures.annotated, defaults.defaults),
    Kind.BITSET: (structures.bitset, defaults.defaults),
    Kind.TYPEDEF: (structures.typedef, defaults.defaults),
    Kind.CONST: (structures.constant,),
    Kind.UNION: (
        unions.branches,
        unions.labels,
        structures.annotated,
        defaults.defaults,
        structures.member_ids,
    ),
    Kind.INTERFACE: (interfaces.bases, interfaces.inherited, operations.all_of),
    Kind.VALUETYPE: (
        values.bases,
        values.members,
        defaults.defaults,
        interfaces.inherited,
        operations.all_of,
    ),
    Kind.VALUE_BOX: (values.box,),
}


class Checker:
    """Checks a translation unit: its tree, and the declarations lowered from it."""

    def __init__(
        self,
        types: Types,
        declarations: Mapping[ScopedName, Declaration],
        report: Callable[[Diagnostic], None],
    ) -> None:
        self._context = Context(types, declarations, report)
        self._ids: dict[str, Entity] = {}

    def check(self, entity: Entity, *, known: bool) -> None:
        """Check a declaration; a `known` one only beside the others."""
        if entity.node is None:
            return
        for check in () if known else _CHECKS.get(entity.kind, ()):
            check(entity, self._context)
        structures.repository_id(entity, self._ids, self._context)


def left_out(
    tables: Tables,
    types: Types,
    declarations: Mapping[ScopedName, Declaration],
    report: Callable[[Diagnostic], None],
) -> None:
    """Report valid declarations that are missing from the model."""
    missing_definitions.report(tables, Context(types, declarations, report))
