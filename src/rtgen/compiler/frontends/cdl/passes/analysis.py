"""Semantic analysis: from the syntax tree of a unit to its declarations, in source order.

A name of CDL is visible only after its declaration, so one walk suffices: imports in place of their
statement, constants, types, signatures. Celltypes, composites, cells and regions are declared
by this walk, and analysed by `components`.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import Place
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.passes.components import Components
from rtgen.compiler.frontends.cdl.passes.constants import Constants
from rtgen.compiler.frontends.cdl.passes.signatures import Signatures
from rtgen.compiler.frontends.cdl.passes.specifiers import belongs
from rtgen.compiler.frontends.cdl.passes.types import Types
from rtgen.compiler.frontends.cdl.passes.untagged import is_plain, name_of_untagged
from rtgen.compiler.frontends.cdl.passes.values import DeclaredValues
from rtgen.compiler.frontends.cdl.rules import headers as header_rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.unit import Header, Unit
from rtgen.compiler.model.c_types import CStructType, CType, resolve
from rtgen.compiler.model.tecs import TecsDeclaration, TecsEnum, TecsStruct, TecsTypedef

_OF_SIGNATURES = frozenset(("context", "callback", "deviate", "generate"))
_COMPONENTS = (
    statements.Celltype,
    statements.Composite,
    statements.Cell,
    statements.Region,
)
_CALLED = {
    tree.Typedef: "typedef",
    tree.Declaration: "constant",
    tree.TypeStatement: "type",
    statements.Namespace: "name space",
    statements.Import: "import",
    statements.ImportC: "import_C",
    statements.Generate: "generate",
}


class Analysis:
    """The walk over a unit that fills its symbol table."""

    def __init__(self, table: Table) -> None:
        self._table = table
        self._report = table.report
        self._types = Types(table)
        self._constants = Constants(table, self._types)
        self._signatures = Signatures(table, self._types)
        self._components = Components(
            table, DeclaredValues(table, self._types, self._constants)
        )

    def run(self, unit: Unit) -> None:
        """Enter the declarations of a unit and its imports into the table."""
        self._items(unit.items, Place(unit, self._table.root))
        self._types.finish()
        self._components.finish()

    def _items(self, items: Sequence[statements.Item], place: Place) -> None:
        """Analyse the statements of a file or a name space."""
        for item in items:
            self._statement(item, place)

    def _statement(self, item: statements.Item, place: Place) -> None:
        node = item.node
        self._check_specifiers(item, place)
        match node:
            case statements.Namespace():
                inner = self._table.open_scope(node.name, place, Kind.NAMESPACE)
                if not node.items:
                    message = f"there is nothing in the name space {node.name.text}"
                    span = place.unit.span(node.name.start, node.end)
                    self._report(syntax.EMPTY_BLOCK.at(span, message))
                if inner is not None:
                    self._items(node.items, Place(place.unit, inner))
            case tree.Typedef():
                self._typedef(item, node, place)
            case tree.TypeStatement():
                self._types.of(
                    tree.QualifiedType(node.start, node.end, (), node.type), place
                )
            case tree.Declaration():
                self._constants.declare(item, node, place)
            case statements.Signature():
                self._signature(item, node, place)
            case statements.Celltype():
                self._components.celltype(item, node, place)
            case statements.Composite():
                self._components.composite(item, node, place)
            case statements.Cell():
                self._components.cell(item, node, place)
            case statements.Region():
                region = self._components.region(item, node, place)
                self._items(node.items, Place(place.unit, region))
            case statements.Generate():
                self._components.generate(node, place)
            case statements.Import():
                imported = place.unit.imports.get(node)
                if imported is not None:
                    self._items(imported.items, Place(imported, self._table.root))
            case statements.ImportC():
                header = place.unit.headers.get(node)
                if header is not None:
                    self._header(header)

    def _check_specifiers(self, item: statements.Item, place: Place) -> None:
        if item.specifiers is None or isinstance(item.node, _COMPONENTS):
            return
        is_signature = isinstance(item.node, statements.Signature)
        allowed = _OF_SIGNATURES if is_signature else frozenset[str]()
        for specifier in item.specifiers.items:
            if specifier.word not in allowed:
                what = _CALLED.get(type(item.node)) or type(item.node).__name__.lower()
                span = place.span(specifier)
                message = f"'{specifier.word}' cannot precede a {what}"
                hint = belongs(specifier.word)
                self._report(syntax.MISPLACED_SPECIFIER.at(span, message, hint=hint))

    def _typedef(self, item: statements.Item, node: tree.Typedef, place: Place) -> None:
        for specifier in node.specifiers.items if node.specifiers else ():
            if specifier.word != "string":
                span = place.span(specifier)
                message = f"'{specifier.word}' is not allowed in a typedef"
                self._report(syntax.MISPLACED_SPECIFIER.at(span, message))
        untagged = name_of_untagged(node.declarators)
        if not any(map(is_plain, node.declarators)):
            untagged = f"{untagged}_type"  # the name itself is a pointer or array
        base = self._types.of(node.type, place, untagged)
        doc = place.doc(item)
        self._describe(node.type, base, doc)
        for declarator in node.declarators:
            name = declarator.name
            assert name is not None
            entity = self._table.declare(Kind.TYPEDEF, name, declarator, place)
            if entity is None:
                continue
            type_ = self._types.declared(base, declarator, place)
            if type_ is not None and self._types.knows_struct(type_, place, name):
                entity.declaration = TecsTypedef(
                    name=entity.name,
                    file=place.unit.source.name,
                    span=entity.place,
                    doc=doc,
                    type=type_,
                )
                self._table.declared(entity)

    def _describe(
        self, written: tree.QualifiedType, type_: CType | None, doc: str
    ) -> None:
        """Give the doc comment of a typedef to the struct in it, if that has none."""
        if isinstance(type_, CStructType) and getattr(written.type, "members", None):
            entity = self._table.tag(type_.tag)
            found = entity.declaration if entity is not None else None
            if entity is not None and found is not None and not found.doc:
                entity.declaration = replace(found, doc=doc)

    def _signature(
        self, item: statements.Item, node: statements.Signature, place: Place
    ) -> None:
        entity = self._table.declare(Kind.SIGNATURE, node.name, item, place)
        if entity is None:
            return
        entity.declaration = self._signatures.signature(item, node, place, entity)
        if entity.declaration is not None:
            self._table.declared(entity)
        generate = item.specifier("generate")
        if generate is not None:
            plugin = generate.arguments[0]
            assert isinstance(plugin, tree.Name)
            self._components.applied(plugin, place)

    def _header(self, header: Header) -> None:
        for declaration in header.declarations:
            name = declaration.name[-1]
            kind = _KINDS[type(declaration)]
            root = self._table.root
            table = root.entities if kind is Kind.TYPEDEF else root.structs
            known = table.get(name)
            if known is None:
                entity = Entity(
                    kind, declaration.name, None, None, declaration.span, declaration
                )
                table[name] = entity
                if kind is not Kind.TYPEDEF:
                    root.tags.setdefault(name, entity)
                self._table.declared(entity)
            elif known.declaration is None or not _same(known.declaration, declaration):
                message = f"'{name}' is declared differently before"
                related = [Related(known.place, "first declared here")]
                self._report(
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
    """Return whether two declarations of a name are equivalent."""
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
