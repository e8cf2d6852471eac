"""The symbol table of a unit, which every pass reads and extends."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.cdl.rules import types as rules
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.unit import Unit
from rtgen.compiler.frontends.kit.suggestions import Guesses
from rtgen.compiler.model.tecs import TecsDeclaration
from rtgen.compiler.model.types import ScopedName


class Table(msgspec.Struct, eq=False):
    """The declarations of a unit, by scope and in order, and its sink of diagnostics.

    `with_prelude`: types of tecsgen's headers are known without an import; `prelude_used` are their
    first uses. `has_plugin` returns whether the Ruby file of a plug-in is found from a unit.
    """

    report: Callable[[Diagnostic], None]
    with_prelude: bool = True
    has_plugin: Callable[[Unit, str], bool] = lambda unit, file: False
    root: Scope = msgspec.field(default_factory=lambda: Scope((), None))
    declarations: list[Entity] = []
    lacking: bool = False
    """Whether an import is missing."""

    excused: bool = False
    """Whether an unknown name may be declared by a missing import."""

    prelude_used: dict[str, Span] = {}
    guesses: Guesses = msgspec.field(default_factory=Guesses)

    @property
    def incomplete(self) -> bool:
        """Whether a missing import may declare unknown names, so that they are not reported."""
        self.excused |= self.lacking
        return self.lacking

    def model(self) -> tuple[TecsDeclaration, ...]:
        """Return the model of the unit: all declarations without errors."""
        return tuple(e.declaration for e in self.declarations if e.declaration)

    def declare(
        self,
        kind: Kind,
        name: tree.Name,
        node: statements.Item | tree.Declarator,
        place: Place,
    ) -> Entity | None:
        """Declare an entity; None, after a diagnostic, if the name is taken."""
        existing = place.scope.own(name.text)
        if existing is not None:
            self._report_taken(name, place, existing)
            return None
        entity = Entity(
            kind, (*place.scope.name, name.text), place.unit, node, place.span(name)
        )
        place.scope.entities[name.text] = entity
        return entity

    def _report_taken(
        self, name: tree.Name, place: Place, existing: Entity | Scope
    ) -> None:
        if existing.kind is Kind.TYPEDEF and name.text in place.unit.maybe_declared:
            return  # reported by the parser
        related = (
            [Related(existing.place, "first declared here")] if existing.place else []
        )
        message = f"'{name.text}' is a {existing.kind} already"
        self.report(rules.DECLARED_TWICE.at(place.span(name), message, related=related))

    def open_scope(self, name: tree.Name, place: Place, kind: Kind) -> Scope | None:
        """Open or reopen a name space or region; None if the name is taken."""
        existing = place.scope.own(name.text)
        if isinstance(existing, Scope) and existing.kind is kind:
            return existing
        if existing is not None:
            self._report_taken(name, place, existing)
            return None
        opened = Scope(
            (*place.scope.name, name.text), place.scope, kind, place.span(name)
        )
        place.scope.scopes[name.text] = opened
        return opened

    def declared(self, entity: Entity) -> None:
        """Record an entity whose model is complete."""
        self.declarations.append(entity)

    def tag(self, name: ScopedName) -> Entity | None:
        """Return the struct or enum of a full name, if its members are known or being analysed."""
        scope: Scope | None = self.root
        for part in name[:-1]:
            scope = scope.scopes.get(part) if scope is not None else None
        return scope.structs.get(name[-1]) if scope is not None else None

    def find(
        self, name: tree.ScopedName, place: Place, kinds: Sequence[Kind], wanted_by: str
    ) -> Entity | None:
        """Look up an entity of one of the kinds; None, after a diagnostic, if there is none."""
        entity = place.scope.find(name)
        span = place.span(name)
        expectation = " or ".join(kinds)
        if entity is None:
            if name.parts[-1].text not in place.unit.maybe_declared:
                near = self.guesses.nearest(str(name), place.scope.visible())
                hint = f"did you mean '{near}'?" if near else None
                message = f"the {expectation} '{name}' is unknown"
                self.report(rules.UNKNOWN_NAME.at(span, message, hint=hint))
            return None
        if isinstance(entity, Entity) and entity.kind in kinds:
            return entity
        related = [Related(entity.place, "declared here")] if entity.place else []
        message = f"'{name}' is a {entity.kind}, but {wanted_by} wants a {expectation}"
        self.report(rules.WRONG_KIND.at(span, message, related=related))
        return None

    def note_prelude(self, name: str, place: Place, node: tree.Name) -> None:
        """Record the use of a type that is known without an import."""
        if name not in self.prelude_used:
            self.prelude_used[name] = place.span(node)
