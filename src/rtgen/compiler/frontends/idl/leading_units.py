"""Declarations of translation units, of which those that begin several are made once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.lowering.lower import Lowering
from rtgen.compiler.frontends.idl.meaning.checks import Checker, levels
from rtgen.compiler.frontends.idl.meaning.typetable import Types
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.kit import stages
from rtgen.compiler.model import Declaration, ScopedName

_Facts: TypeAlias = tuple[object, tree.Item | None, str, str, tuple[tree.Item, ...]]
"""What an entity is lowered from. The entity itself would keep all tables of its unit."""


class _Lowered(msgspec.Struct, frozen=True, eq=False):
    """Facts of entities without findings, and what they were lowered to, in the same order."""

    facts: list[_Facts]
    declarations: list[Declaration]
    annotations: Mapping[str, tuple[str, ...]]

    def fits(self, tables: Tables, count: int) -> bool:
        """Return whether the first entities of another unit are equal to these."""
        pairs = zip(tables.declared[:count], self.facts, strict=False)
        return self.annotations == tables.annotations and all(
            mine.node is node
            and mine.item is item
            and mine.repository_id == repository_id
            and mine.modifier == modifier
            and mine.around == around
            and not mine.poisoned
            and not mine.contradicted
            for mine, (node, item, repository_id, modifier, around) in pairs
        )


class _Reports:
    """Passes findings on; `quiet` is the number of entities before the first finding."""

    def __init__(self, report: Callable[[Diagnostic], None], total: int) -> None:
        self._report = report
        self.position = 0
        self.quiet = total

    def end_here(self) -> None:
        """Note that the entity at the position is not like in other units."""
        self.quiet = min(self.quiet, self.position)

    def __call__(self, diagnostic: Diagnostic) -> None:
        self.end_here()
        self._report(diagnostic)


class LeadingUnits:
    """The declarations of the units that begin translation units, by these units in order."""

    def __init__(self) -> None:
        self._lowered: dict[tuple[Unit, ...], _Lowered] = {}

    def declarations(
        self, types: Types, report: Callable[[Diagnostic], None]
    ) -> Mapping[ScopedName, Declaration]:
        """Return the valid declarations of a translation unit, checked."""
        tables = types.tables
        known = self._known(tables)
        reports = _Reports(report, len(tables.declared))
        lowered: list[Declaration] = []
        declarations: dict[ScopedName, Declaration] = {}
        with stages.stage("make the model"):
            lowering = Lowering(types, reports)
            for reports.position, entity in enumerate(tables.declared):
                if reports.position < len(known):
                    declaration: Declaration | None = known[reports.position]
                    assert declaration is not None
                    lowering.keep(entity, declaration)
                else:
                    declaration = lowering.declaration(entity)
                if declaration is None:
                    reports.end_here()
                else:
                    declarations[declaration.name] = declaration
                    lowered.append(declaration)
        with stages.stage("check"):
            reports.position = 0
            declarations = levels.checked(declarations, reports)
            checker = Checker(types, declarations, reports)
            for reports.position, entity in enumerate(tables.declared):
                checker.check(entity, known=reports.position < len(known))
        self._keep(tables, reports.quiet, lowered)
        return declarations

    def _known(self, tables: Tables) -> list[Declaration]:
        """Return the declarations of the first entities that another unit begins with."""
        units = tuple(unit for unit, _, _ in tables.leading)
        for index, (_, count, last) in reversed([*enumerate(tables.leading)]):
            lowered = self._lowered.get(units[: index + 1])
            if (
                lowered is not None
                and _is_whole(tables, count, last)
                and lowered.fits(tables, count)
            ):
                return lowered.declarations[:count]
        return []

    def _keep(self, tables: Tables, quiet: int, lowered: list[Declaration]) -> None:
        units = tuple(unit for unit, _, _ in tables.leading)
        most = 0
        fresh = []
        for index, (_, count, last) in enumerate(tables.leading):
            own = units[: index + 1]
            is_new = own not in self._lowered and count <= quiet
            if is_new and _is_whole(tables, count, last):
                fresh.append(own)
                most = max(most, count)
        facts = [
            (e.node, e.item, e.repository_id, e.modifier, e.around)
            for e in tables.declared[:most]
        ]
        entry = _Lowered(facts, lowered[:most], tables.annotations)
        self._lowered |= dict.fromkeys(fresh, entry)


def _is_whole(tables: Tables, count: int, last: Entity | None) -> bool:
    """Return whether no later definition of a forward declaration has moved an entity."""
    return count > 0 and tables.declared[count - 1] is last
