"""Names of CDL, from the syntax trees and symbols of a unit."""

from __future__ import annotations

from collections.abc import Sequence

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.cdl.names import scopes
from rtgen.compiler.frontends.cdl.names.entities import Cell as CellFacts
from rtgen.compiler.frontends.cdl.names.entities import Composite as CompositeFacts
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Scope
from rtgen.compiler.frontends.cdl.names.table import Table
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.unit import Unit
from rtgen.tools.indexing.index import Collector, Kind, path_of

_KINDS = {
    scopes.Kind.SIGNATURE: Kind.SIGNATURE,
    scopes.Kind.CELLTYPE: Kind.CELLTYPE,
    scopes.Kind.COMPOSITE: Kind.CELLTYPE,
    scopes.Kind.CELL: Kind.CELL,
    scopes.Kind.TYPEDEF: Kind.TYPEDEF,
    scopes.Kind.CONSTANT: Kind.CONSTANT,
    scopes.Kind.STRUCT: Kind.STRUCT,
    scopes.Kind.ENUM: Kind.ENUM,
}


def key_of(entity: Entity) -> str:
    """Return the key of an entity: its file and name; tags have a separate name space."""
    tag = entity.kind in (scopes.Kind.STRUCT, scopes.Kind.ENUM)
    name = "::".join(entity.name)
    return f"cdl {path_of(entity.place.file)}#{'struct ' if tag else ''}{name}"


class CdlNames:
    """Adds the names of units; a file imported by several units is added once."""

    def __init__(self, collector: Collector) -> None:
        self._collector = collector
        self._indexed: set[str] = set()

    def add(self, table: Table, units: Sequence[Unit]) -> None:
        """Add the names of a main file and its imports."""
        for unit in units:
            if unit.source.name not in self._indexed:
                self._indexed.add(unit.source.name)
                _Walk(self._collector, table, unit).run()
            for header in unit.headers.values():
                for declaration in header.declarations:
                    scope = table.root
                    name = declaration.name[-1]
                    entity = scope.entities.get(name) or scope.tags.get(name)
                    if entity is not None and entity.unit is None:
                        self._define_c(entity)

    def _define_c(self, entity: Entity) -> None:
        kind = _KINDS[entity.kind]
        self._collector.define(key_of(entity), entity.name[-1], kind, entity.place)


class _Walk:
    """Traversal of the statements of a file."""

    def __init__(self, collector: Collector, table: Table, unit: Unit) -> None:
        self._collector = collector
        self._table = table
        self._unit = unit

    def run(self) -> None:
        self._items(self._unit.items, self._table.root, "")

    def _span(self, node: tree.Name | statements.Item | tree.Declarator) -> Span:
        return self._unit.span(node.start, node.end)

    def _items(
        self, items: Sequence[statements.Item], scope: Scope, container: str
    ) -> None:
        for item in items:
            self._statement(item, scope, container)

    def _statement(self, item: statements.Item, scope: Scope, container: str) -> None:
        match item.node:
            case statements.Namespace() | statements.Region() as node:
                inner = scope.scopes.get(node.name.text)
                if inner is not None:
                    key = self._scope_key(inner)
                    self._define(key, node.name, Kind.MODULE, item, container)
                    self._items(node.items, inner, key)
            case statements.Import() as node:
                imported = self._unit.imports.get(node)
                if imported is not None:
                    path = path_of(imported.source.name)
                    span = self._unit.span(node.start, node.end)
                    self._collector.refer(f"file {path}", span)
            case tree.Typedef() as node:
                self._type(node.type.type, scope)
                for declarator in node.declarators:
                    self._declared(declarator.name, item, scope, container)
            case tree.Declaration() as node:
                self._type(node.type.type, scope)
                for each in node.declarators:
                    self._declared(each.declarator.name, item, scope, container)
                    self._value(each.value, scope)
            case tree.TypeStatement() as node:
                self._type(node.type, scope)
            case statements.Signature() as node:
                self._signature(node, item, scope, container)
            case statements.Celltype() as node:
                self._celltype(node, item, scope, container)
            case statements.Composite() as node:
                self._celltype(node, item, scope, container)
            case statements.Cell() as node:
                self._cell(node, item, scope, container, None)
            case statements.Generate() as node:
                self._refer(node.target, scope)

    def _scope_key(self, scope: Scope) -> str:
        return f"cdl scope {'::'.join(scope.name)}"

    def _define(
        self,
        key: str,
        name: tree.Name,
        kind: Kind,
        item: statements.Item | tree.Declarator | tree.Parameter | tree.MemberItem,
        container: str,
        detail: str = "",
    ) -> None:
        extent = self._unit.span(item.start, item.end)
        self._collector.define(
            *(key, name.text, kind, self._span(name), extent),
            container=container,
            detail=detail,
        )

    def _use(self, key: str, name: tree.Name) -> None:
        self._collector.refer(key, self._span(name))

    def _declared(
        self,
        name: tree.Name | None,
        item: statements.Item,
        scope: Scope,
        container: str,
    ) -> Entity | None:
        """Define a name of the scope, unless another entity has it."""
        entity = scope.entities.get(name.text) if name is not None else None
        if entity is None or name is None or entity.place != self._span(name):
            return None
        self._define(key_of(entity), name, _KINDS[entity.kind], item, container)
        return entity

    def _refer(self, name: tree.ScopedName, scope: Scope) -> Entity | None:
        """Record a use of a name with its parts, and return its entity."""
        entity = scope.find(name)
        part_of: Scope | None = None
        for part in name.parts[:-1]:
            if part_of is None:
                around = (s.scopes.get(part.text) for s in scope.outwards())
                part_of = next((inner for inner in around if inner), None)
            else:
                part_of = part_of.scopes.get(part.text)
            if part_of is None:
                break
            self._use(self._scope_key(part_of), part)
        if isinstance(entity, Entity):
            self._use(key_of(entity), name.parts[-1])
            return entity
        return None

    def _type(self, node: tree.TypeSpecifier, scope: Scope) -> None:
        match node:
            case tree.TypedefName(name=name):
                for place in scope.outwards():
                    entity = place.entities.get(name.text)
                    if entity is not None:
                        self._use(key_of(entity), name)
                        return
            case tree.StructSpecifier(tag=tag, members=members) if tag is not None:
                self._tag(tag, node, scope)
                for member in members or ():
                    self._type(member.type.type, scope)
                    for declarator in member.declarators:
                        self._inner(tag, declarator.name, member, scope)
            case tree.EnumSpecifier(tag=tag) if tag is not None:
                self._tag(tag, node, scope)
            case tree.DescriptorOf(signature=signature):
                self._refer(signature, scope)

    def _tag(
        self,
        tag: tree.Name,
        node: tree.StructSpecifier | tree.EnumSpecifier,
        scope: Scope,
    ) -> None:
        entity = scope.find_tag(tag.text)
        if entity is None:
            return
        span = self._span(tag)
        if entity.place == span:
            extent = self._unit.span(node.start, node.end)
            kind = _KINDS[entity.kind]
            self._collector.define(key_of(entity), tag.text, kind, span, extent)
        else:
            self._collector.refer(key_of(entity), span)

    def _inner(
        self,
        tag: tree.Name,
        name: tree.Name | None,
        member: tree.MemberItem,
        scope: Scope,
    ) -> None:
        entity = scope.find_tag(tag.text)
        if entity is not None and name is not None:
            key = key_of(entity)
            self._define(f"{key}::{name.text}", name, Kind.MEMBER, member, key)

    def _signature(
        self,
        node: statements.Signature,
        item: statements.Item,
        scope: Scope,
        container: str,
    ) -> None:
        entity = self._declared(node.name, item, scope, container)
        if entity is None:
            return
        key = key_of(entity)
        for each in node.functions:
            function = each.node
            if not isinstance(function, statements.Function):
                continue
            name = function.declarator.name
            self._type(function.type.type, scope)
            if name is None:
                continue
            own = f"{key}::{name.text}"
            self._define(own, name, Kind.FUNCTION, each, key)
            parameters = [
                parameter
                for suffix in function.declarator.suffixes
                if isinstance(suffix, tree.Parameters)
                for parameter in suffix.items
            ]
            names = {
                p.declarator.name.text
                for p in parameters
                if p.declarator is not None and p.declarator.name is not None
            }
            for parameter in parameters:
                self._parameter(parameter, own, names, scope)

    def _parameter(
        self,
        parameter: tree.Parameter,
        function: str,
        names: set[str],
        scope: Scope,
    ) -> None:
        self._type(parameter.type.type, scope)
        name = parameter.declarator.name if parameter.declarator else None
        if name is not None:
            key = f"{function}::{name.text}"
            self._define(key, name, Kind.PARAMETER, parameter, function)
        for specifier in parameter.specifiers.items if parameter.specifiers else ():
            for argument in specifier.arguments:
                if isinstance(argument, tree.ScopedName):
                    if specifier.word in ("send", "receive"):
                        self._refer(argument, scope)
                    elif str(argument) in names:
                        part = argument.parts[0]
                        own = f"{function}::{part.text}"
                        self._use(own, part)
                    else:
                        self._refer(argument, scope)

    def _celltype(
        self,
        node: statements.Celltype | statements.Composite,
        item: statements.Item,
        scope: Scope,
        container: str,
    ) -> None:
        entity = self._declared(node.name, item, scope, container)
        if entity is None:
            return
        key = key_of(entity)
        for each in node.items:
            match each.node:
                case statements.Port() as port:
                    self._refer(port.signature, scope)
                    text = f"{port.kind} {port.signature}"
                    own = f"{key}::{port.name.text}"
                    self._define(own, port.name, Kind.PORT, each, key, text)
                    if port.target is not None:
                        self._target(port.target, scope, None)
                case statements.Attributes() as attributes:
                    for declaration in attributes.items:
                        self._attributes(declaration, key, scope)
                case statements.Require() as required:
                    self._target(required.target, scope, None)
                case statements.Cell() as cell:
                    facts = entity.component
                    inside = facts if isinstance(facts, CompositeFacts) else None
                    self._cell(cell, each, scope, key, inside)
                case statements.EntryExport() as export:
                    facts = entity.component
                    own = f"{key}::{export.name.text}"
                    self._use(own, export.name)
                    if isinstance(facts, CompositeFacts):
                        inner = facts.inner.get(export.cell.text)
                        self._use(f"{key}::{export.cell.text}", export.cell)
                        self._port_of(inner, export.port)

    def _attributes(self, item: statements.Item, key: str, scope: Scope) -> None:
        if not isinstance(item.node, tree.Declaration):
            return
        self._type(item.node.type.type, scope)
        for each in item.node.declarators:
            name = each.declarator.name
            if name is not None:
                own = f"{key}::{name.text}"
                self._define(own, name, Kind.ATTRIBUTE, item, key)
            self._value(each.value, scope)

    def _cell(
        self,
        node: statements.Cell,
        item: statements.Item,
        scope: Scope,
        container: str,
        inside: CompositeFacts | None,
    ) -> None:
        type_, detail = self._refer(node.celltype, scope), str(node.celltype)
        entity = scope.entities.get(node.name.text)
        if inside is not None:
            key = f"{container}::{node.name.text}"
            self._define(key, node.name, Kind.CELL, item, container, detail)
        elif entity is not None and entity.place == self._span(node.name):
            self._define(key_of(entity), node.name, Kind.CELL, item, container, detail)
        elif entity is not None:
            self._use(key_of(entity), node.name)
        for each in node.joins or ():
            match each.node:
                case statements.Join() as join:
                    self._use_part(type_, join.name)
                    self._value(join.value, scope, inside)
                case statements.ReverseJoin() as reverse:
                    self._use_part(type_, reverse.name)
                    self._target(reverse.target, scope, inside)
                case statements.Export() as export:
                    self._use_part(type_, export.port)

    def _use_part(self, owner: Entity | None, name: tree.Name) -> None:
        """Record a use of a port or an attribute of a celltype, or of a cell's port."""
        if owner is not None:
            self._use(f"{key_of(owner)}::{name.text}", name)

    def _target(
        self,
        target: statements.PortOf,
        scope: Scope,
        inside: CompositeFacts | None,
    ) -> None:
        self._join(target.owner, target.port, scope, inside)

    def _join(
        self,
        owner: tree.ScopedName,
        port: tree.Name,
        scope: Scope,
        inside: CompositeFacts | None,
    ) -> None:
        """Record a cell or celltype, and one of its ports."""
        if inside is not None and len(owner.parts) == 1:
            inner = inside.inner.get(owner.parts[0].text)
            if inner is not None:
                key = f"{key_of(inside.entity)}::{owner.parts[0].text}"
                self._use(key, owner.parts[0])
                self._port_of(inner, port)
                return
        entity = self._refer(owner, scope)
        if entity is None:
            return
        if isinstance(entity.component, CellFacts):
            self._port_of(entity.component, port)
        elif entity.kind in (scopes.Kind.CELLTYPE, scopes.Kind.COMPOSITE):
            self._use_part(entity, port)

    def _port_of(self, cell: CellFacts | None, port: tree.Name) -> None:
        if cell is not None and cell.celltype is not None:
            self._use_part(cell.celltype.entity, port)

    def _value(
        self,
        node: tree.Initialiser | tree.OfComposite | None,
        scope: Scope,
        inside: CompositeFacts | None = None,
    ) -> None:
        """Record the names in a value: constants, or a cell and its port."""
        match node:
            case tree.Postfix(operand=operand, suffixes=suffixes):
                names = [s for s in suffixes if isinstance(s, tree.Name)]
                if isinstance(operand, tree.ScopedName) and names:
                    self._join(operand, names[0], scope, inside)
                else:
                    self._value(operand, scope, inside)
            case tree.ScopedName():
                self._refer(node, scope)
            case tree.Group(inner=inner):
                self._value(inner, scope, inside)
            case tree.Unary(operand=operand) | tree.Cast(operand=operand):
                self._value(operand, scope, inside)
            case tree.Chain(first=first, rest=rest):
                self._value(first, scope, inside)
                for _, each in rest:
                    self._value(each, scope, inside)
            case tree.Conditional(condition=condition, yes=yes, no=no):
                for each in (condition, yes, no):
                    self._value(each, scope, inside)
            case tree.Aggregate(items=items):
                for item in items:
                    self._value(item, scope, inside)
            case tree.OfComposite(name=name) if inside is not None:
                key = f"{key_of(inside.entity)}::{name.text}"
                self._use(key, name)


def file_and_name(key: str) -> tuple[str, tuple[str, ...]]:
    """Return the file and the scoped name of a key; without the keyword of a tag."""
    file, _, name = key.removeprefix("cdl ").partition("#")
    return file, tuple(name.removeprefix("struct ").split("::"))
