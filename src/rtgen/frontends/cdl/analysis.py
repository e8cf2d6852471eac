"""From the syntax tree of a unit to its declarations, in the order of the text.

CDL knows a name only behind its declaration, so one walk does: imports in place of their
statement, constants, types, signatures. Celltypes, composites, cells and regions are declared on
the way, and looked at by `components`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rtgen.diagnostics import Diagnostic, Related, Span
from rtgen.frontends.cdl import tree
from rtgen.frontends.cdl.components import Components
from rtgen.frontends.cdl.constants import Constants
from rtgen.frontends.cdl.entities import Place
from rtgen.frontends.cdl.expressions import Expressions
from rtgen.frontends.cdl.header_file import Header
from rtgen.frontends.cdl.rules import headers as header_rules
from rtgen.frontends.cdl.rules import syntax
from rtgen.frontends.cdl.rules import types as rules
from rtgen.frontends.cdl.scopes import Entity, Kind, Scope
from rtgen.frontends.cdl.signatures import Signatures
from rtgen.frontends.cdl.types import Types
from rtgen.frontends.cdl.unit import Unit
from rtgen.frontends.suggestions import Guesses
from rtgen.model.tecs import TecsDeclaration, TecsEnum, TecsStruct, TecsTypedef, resolve
from rtgen.model.types import ScopedName

_OF_SIGNATURES = frozenset(("context", "callback", "deviate", "generate"))
_COMPONENTS = (tree.Celltype, tree.Composite, tree.Cell, tree.Region)
_CALLED = {
    tree.Typedef: "typedef",
    tree.Declaration: "constant",
    tree.TypeStatement: "type",
    tree.Namespace: "name space",
    tree.Import: "import",
    tree.ImportC: "import_C",
    tree.Generate: "generate",
}


class Analysis:
    """What is declared, and the findings on the way."""

    def __init__(
        self, report: Callable[[Diagnostic], None], *, with_prelude: bool = True
    ) -> None:
        self.report = report
        self.with_prelude = with_prelude
        self.root = Scope((), None)
        self.declarations: list[Entity] = []
        self.lacking = False
        """Whether an import is missing."""

        self.excused = False
        """Whether something is unknown that a missing import may declare."""

        self.prelude_used: dict[str, Span] = {}
        self.guesses = Guesses()
        self.types = Types(self)
        self.expressions = Expressions(self)
        self._signatures = Signatures(self)
        self.constants = Constants(self)
        self._components = Components(self)
        self._tags: dict[ScopedName, Entity] = {}

    @property
    def incomplete(self) -> bool:
        """For what is unknown: whether a missing import may declare it, so that it is not told."""
        self.excused |= self.lacking
        return self.lacking

    def run(self, unit: Unit) -> None:
        """Declare what a unit and its imports declare."""
        self.items(unit.items, unit, self.root)
        self.types.finish()
        self._components.finish()

    def model(self) -> tuple[TecsDeclaration, ...]:
        """The declarations without those that have errors."""
        return tuple(e.declaration for e in self.declarations if e.declaration)

    def items(self, items: Sequence[tree.Item], unit: Unit, scope: Scope) -> None:
        """Walk over the statements of a file or a name space."""
        for item in items:
            self._statement(item, unit, scope)

    def _statement(self, item: tree.Item, unit: Unit, scope: Scope) -> None:
        node = item.node
        self._check_specifiers(item, unit)
        match node:
            case tree.Namespace():
                inner = self.open_scope(node.name, unit, scope, Kind.NAMESPACE)
                if not node.items:
                    message = f"there is nothing in the name space {node.name.text}"
                    span = unit.span(node.name.start, node.end)
                    self.report(syntax.EMPTY_BLOCK.at(span, message))
                if inner is not None:
                    self.items(node.items, unit, inner)
            case tree.Typedef():
                self._typedef(item, node, unit, scope)
            case tree.TypeStatement():
                self.types.of(
                    tree.QualifiedType((), node.type, node.start, node.end), unit, scope
                )
            case tree.Declaration():
                self.constants.declare(item, node, unit, scope)
            case tree.Signature():
                self._signature(item, node, unit, scope)
            case tree.Celltype():
                self._components.celltype(item, node, Place(unit, scope))
            case tree.Composite():
                self._components.composite(item, node, Place(unit, scope))
            case tree.Cell():
                self._components.cell(item, node, Place(unit, scope))
            case tree.Region():
                region = self._components.region(item, node, Place(unit, scope))
                self.items(node.items, unit, region)
            case tree.Generate():
                self._components.generate(node, Place(unit, scope))
            case tree.Import():
                imported = unit.imports.get(node)
                if imported is not None:
                    self.items(imported.items, imported, self.root)
            case tree.ImportC():
                header = unit.headers.get(node)
                if header is not None:
                    self._header(header)

    def _check_specifiers(self, item: tree.Item, unit: Unit) -> None:
        if item.specifiers is None or isinstance(item.node, _COMPONENTS):
            return
        is_signature = isinstance(item.node, tree.Signature)
        allowed = _OF_SIGNATURES if is_signature else frozenset[str]()
        for specifier in item.specifiers.items:
            if specifier.word not in allowed:
                what = _CALLED.get(type(item.node)) or type(item.node).__name__.lower()
                span = unit.span(specifier.start, specifier.end)
                message = f"'{specifier.word}' cannot stand before a {what}"
                self.report(syntax.MISPLACED_SPECIFIER.at(span, message))

    def _typedef(
        self, item: tree.Item, node: tree.Typedef, unit: Unit, scope: Scope
    ) -> None:
        for specifier in node.specifiers.items if node.specifiers else ():
            if specifier.word != "string":
                span = unit.span(specifier.start, specifier.end)
                message = f"'{specifier.word}' cannot stand in a typedef"
                self.report(syntax.MISPLACED_SPECIFIER.at(span, message))
        base = self.types.of(node.type, unit, scope)
        for declarator in node.declarators:
            name = declarator.name
            assert name is not None
            entity = self.declare(Kind.TYPEDEF, name, declarator, unit, scope)
            if entity is None:
                continue
            type_ = self.types.declared(base, declarator, unit, scope)
            if type_ is not None and self.types.knows_struct(type_, unit, name):
                entity.declaration = TecsTypedef(
                    name=entity.name,
                    file=unit.source.name,
                    span=entity.place,
                    doc=self.doc(unit, item.start, item.end),
                    type=type_,
                )
                self.declared(entity)

    def _signature(
        self, item: tree.Item, node: tree.Signature, unit: Unit, scope: Scope
    ) -> None:
        entity = self.declare(Kind.SIGNATURE, node.name, item, unit, scope)
        if entity is None:
            return
        entity.declaration = self._signatures.signature(item, node, unit, scope, entity)
        if entity.declaration is not None:
            self.declared(entity)
        generate = item.specifier("generate")
        if generate is not None:
            plugin = generate.arguments[0]
            assert isinstance(plugin, tree.Name)
            self._components.applied(plugin, Place(unit, scope))

    # What the passes over the parts use

    def declare(
        self,
        kind: Kind,
        name: tree.Name,
        node: tree.Item | tree.Declarator,
        unit: Unit,
        scope: Scope,
    ) -> Entity | None:
        """A new entity; None if the name is taken, which is told."""
        place = unit.place(name)
        known = scope.own(name.text)
        if known is not None:
            self._tell_taken(name, unit, known)
            return None
        entity = Entity(kind, (*scope.name, name.text), unit, node, place)
        scope.entities[name.text] = entity
        return entity

    def _tell_taken(self, name: tree.Name, unit: Unit, known: Entity | Scope) -> None:
        if known.kind is Kind.TYPEDEF and name.text in unit.lost:
            return  # told by the parser
        related = [Related(known.place, "first declared here")] if known.place else []
        message = f"'{name.text}' is a {known.kind} already"
        place = unit.place(name)
        self.report(rules.DECLARED_TWICE.at(place, message, related=related))

    def open_scope(
        self, name: tree.Name, unit: Unit, scope: Scope, kind: Kind
    ) -> Scope | None:
        """A name space or region, new or opened again; None if the name is taken."""
        known = scope.own(name.text)
        if isinstance(known, Scope) and known.kind is kind:
            return known
        if known is not None:
            self._tell_taken(name, unit, known)
            return None
        place = unit.place(name)
        made = Scope((*scope.name, name.text), scope, kind, place)
        scope.scopes[name.text] = made
        return made

    def declared(self, entity: Entity) -> None:
        """Note an entity whose model is made."""
        self.declarations.append(entity)
        if entity.kind in (Kind.STRUCT, Kind.ENUM):
            self._tags[entity.name] = entity

    def tag(self, name: ScopedName) -> Entity | None:
        """The struct or enum of a full name, if its members are known or being read."""
        scope: Scope | None = self.root
        for part in name[:-1]:
            scope = scope.scopes.get(part) if scope is not None else None
        return scope.tags.get(name[-1]) if scope is not None else None

    def find(
        self,
        name: tree.ScopedName,
        unit: Unit,
        scope: Scope,
        kinds: Sequence[Kind],
        wanted_by: str,
    ) -> Entity | None:
        """What a name stands for, if it is of one of the kinds; tells what is wrong if not."""
        found = scope.find(name)
        span = unit.span(name.start, name.end)
        wanted = " or ".join(kinds)
        if found is None:
            if name.parts[-1].text not in unit.lost:
                near = self.guesses.nearest(str(name), scope.visible())
                hint = f"did you mean '{near}'?" if near else None
                message = f"the {wanted} '{name}' is unknown"
                self.report(rules.UNKNOWN_NAME.at(span, message, hint=hint))
            return None
        if isinstance(found, Entity) and found.kind in kinds:
            return found
        related = [Related(found.place, "declared here")] if found.place else []
        message = f"'{name}' is a {found.kind}, but {wanted_by} wants a {wanted}"
        self.report(rules.WRONG_KIND.at(span, message, related=related))
        return None

    def note_prelude(self, name: str, unit: Unit, node: tree.Name) -> None:
        """Note the use of a type that is known without an import."""
        if name not in self.prelude_used:
            self.prelude_used[name] = unit.place(node)

    def doc(self, unit: Unit, start: int, end: int) -> str:
        """The comment that belongs to [start, end)."""
        return unit.source.docs.of(start, end)

    def _header(self, header: Header) -> None:
        for declaration in header.declarations:
            name = declaration.name[-1]
            kind = _KINDS[type(declaration)]
            table = self.root.entities if kind is Kind.TYPEDEF else self.root.tags
            known = table.get(name)
            if known is None:
                entity = Entity(
                    kind, declaration.name, None, None, declaration.span, declaration
                )
                table[name] = entity
                self.declared(entity)
            elif known.declaration is None or not _same(known.declaration, declaration):
                message = f"'{name}' is declared differently before"
                related = [Related(known.place, "first declared here")]
                self.report(
                    header_rules.HEADER_REDEFINES.at(
                        declaration.span, message, related=related
                    )
                )


_KINDS: dict[type[TecsDeclaration], Kind] = {
    TecsTypedef: Kind.TYPEDEF,
    TecsStruct: Kind.STRUCT,
    TecsEnum: Kind.ENUM,
}


def _same(one: TecsDeclaration, two: TecsDeclaration) -> bool:
    """Whether two declarations of a name say the same."""
    match one, two:
        case TecsTypedef(), TecsTypedef():
            return resolve(one.type) == resolve(two.type)
        case TecsStruct(), TecsStruct():
            return [(m.name, resolve(m.type)) for m in one.members] == [
                (m.name, resolve(m.type)) for m in two.members
            ]
        case TecsEnum(), TecsEnum():
            return one.members == two.members
    return False
