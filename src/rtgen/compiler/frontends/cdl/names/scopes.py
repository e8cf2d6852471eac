"""Scopes of CDL and the entities declared in them."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.cdl.names.operands import Operand
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.unit import Unit
from rtgen.compiler.model.tecs import TecsDeclaration
from rtgen.compiler.model.types import ScopedName


class Kind(StrEnum):
    """The kind of an entity; the value is its name in messages."""

    NAMESPACE = "name space"
    REGION = "region"
    SIGNATURE = "signature"
    CELLTYPE = "celltype"
    COMPOSITE = "composite"
    CELL = "cell"
    TYPEDEF = "type"
    CONSTANT = "constant"
    STRUCT = "struct"
    ENUM = "enum"


class Entity(msgspec.Struct, eq=False):
    """A declared entity.

    `unit` and `node` are None for declarations of C headers and of the prelude. `declaration` is
    its model; None while it is analysed, and if it has errors. `place` is that of its name.
    `component` holds the facts of the passes over celltypes and cells, `value` the value of a
    constant before its conversion to the constant's type.
    """

    kind: Kind
    name: ScopedName
    unit: Unit | None
    node: (
        statements.Item
        | tree.Declarator
        | tree.StructSpecifier
        | tree.EnumSpecifier
        | None
    )
    place: Span
    declaration: TecsDeclaration | None = None
    broken: bool = False
    component: object = None
    value: Operand | None = None


class Scope(msgspec.Struct, eq=False):
    """A name space or region; the root has no name.

    Name spaces and regions are scopes, not entities. Structs and enums have tables of their own:
    `tags` those with a tag, by tag, `structs` all, by the last part of their names.
    """

    name: ScopedName
    parent: Scope | None
    kind: Kind = Kind.NAMESPACE
    place: Span | None = None
    scopes: dict[str, Scope] = msgspec.field(default_factory=dict)
    entities: dict[str, Entity] = msgspec.field(default_factory=dict)
    tags: dict[str, Entity] = msgspec.field(default_factory=dict)
    structs: dict[str, Entity] = msgspec.field(default_factory=dict)

    def outwards(self) -> Iterator[Scope]:
        """Yield this scope and the enclosing ones."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    @property
    def root(self) -> Scope:
        """The outermost scope."""
        scope = self
        while scope.parent is not None:
            scope = scope.parent
        return scope

    def find(self, name: tree.ScopedName) -> Entity | Scope | None:
        """Look a name up: its first part in this scope and the enclosing ones."""
        first = name.parts[0].text
        entity: Entity | Scope | None = None
        if name.absolute:
            entity = self.root.own(first)
        else:
            for scope in self.outwards():
                entity = scope.own(first)
                if entity is not None:
                    break
        for part in name.parts[1:]:
            if not isinstance(entity, Scope):
                return None
            entity = entity.own(part.text)
        return entity

    def own(self, name: str) -> Entity | Scope | None:
        """Return the entity of that name in this scope itself."""
        return self.entities.get(name) or self.scopes.get(name)

    def find_tag(self, tag: str) -> Entity | None:
        """Return the struct or enum of a tag in this scope or an enclosing one."""
        for scope in self.outwards():
            entity = scope.tags.get(tag)
            if entity is not None:
                return entity
        return None

    def visible(self) -> Iterator[str]:
        """Yield the names that are visible without a path, for hints."""
        for scope in self.outwards():
            yield from scope.entities
            yield from scope.scopes
