"""Converts types of the tree to types of the model; resolves aliases and enumerators."""

from __future__ import annotations

from collections.abc import Callable

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.meaning.constants import Constants
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.rules import types as rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.compiler.model import (
    ArrayType,
    FixedType,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Type,
)
from rtgen.facts.primitives import INTEGER_RANGES

PRIMITIVES = {kind: PrimitiveType(kind) for kind in Primitive}
"""The one `PrimitiveType` of each kind; shared, since they are frozen."""

_OTHER_SWITCHES = (Primitive.BOOLEAN, Primitive.CHAR, Primitive.WCHAR)


class Types:
    """Model types of nodes; None if a name or a bound in the type has an error."""

    def __init__(self, tables: Tables, report: Callable[[Diagnostic], None]) -> None:
        self.tables = tables
        self.constants = Constants(self, report)
        self._report = report
        self._types_of_nodes: dict[tree.TypeNode, Type | None] = {}
        self._named: dict[Entity, NamedType] = {}
        self._aliases: dict[ScopedName, Entity] = {}
        self._enums: dict[ScopedName, Entity] = {}
        self._owners: dict[ScopedName, ScopedName] = {}
        self._types_of_entities: dict[Entity, Type | None] = {}
        self._depth = 0
        self._unaliased: dict[ScopedName, Type | None] = {}
        self._entities: dict[ScopedName, Entity] = {}
        for entity in sorted(
            tables.declared, key=lambda e: (e.clashes, e.node is None)
        ):
            if self._entities.setdefault(entity.path, entity) is not entity:
                continue
            if entity.kind is Kind.TYPEDEF:
                self._aliases[entity.path] = entity
            elif entity.kind is Kind.ENUM:
                self._enums[entity.path] = entity
                assert isinstance(entity.node, tree.Enum)
                for member in entity.node.members:
                    self._owners[(*entity.path[:-1], member.name.text)] = entity.path

    def entity(self, name: ScopedName) -> Entity | None:
        """Return the declaration of a scoped name."""
        return self._entities.get(name)

    def kind_of(self, type_: Type) -> Kind | None:
        """Return the kind of a named type; None for other types."""
        entity = (
            self._entities.get(type_.name) if isinstance(type_, NamedType) else None
        )
        return entity.kind if entity else None

    def is_enum(self, name: ScopedName) -> bool:
        """Return whether the name is that of an enum."""
        return name in self._enums

    def enum_of(self, enumerator: ScopedName) -> ScopedName | None:
        """Return the enum of an enumerator."""
        return self._owners.get(enumerator)

    def named(self, entity: Entity) -> NamedType:
        """Return a reference to a declared type."""
        type_ = self._named.get(entity)
        if type_ is None:
            type_ = self._named[entity] = NamedType(entity.path)
        return type_

    def of_entity(self, entity: Entity) -> Type | None:
        """Return the type of a typedef, member or parameter: its type node with its dimensions."""
        if entity not in self._types_of_entities:
            assert entity.type_node is not None
            type_ = self.of_node(entity.type_node, entity.unit)
            if entity.declarator is not None and entity.declarator.dimensions:
                type_ = self._array(type_, entity.declarator, entity.unit)
            self._types_of_entities[entity] = type_
        return self._types_of_entities[entity]

    def _array(
        self, type_: Type | None, declarator: tree.Declarator, unit: Unit
    ) -> Type | None:
        dimensions = tuple(
            self.constants.positive(d, unit) for d in declarator.dimensions
        )
        sizes = tuple(d for d in dimensions if d is not None)
        if type_ is None or len(sizes) < len(dimensions):
            return None
        return ArrayType(type_, sizes)

    def unaliased(self, type_: Type | None) -> Type | None:
        """Return the type with typedefs resolved; None for a typedef cycle."""
        passed: dict[ScopedName, None] = {}
        while isinstance(type_, NamedType) and type_.name in self._aliases:
            if type_.name in self._unaliased:
                type_ = self._unaliased[type_.name]
                break
            if type_.name in passed:
                type_ = None
                break
            passed[type_.name] = None
            type_ = self.of_entity(self._aliases[type_.name])
        for name in passed:
            self._unaliased[name] = type_
        return type_

    def can_switch(self, type_: Type) -> bool:
        """Return whether the type can be the switch of a union."""
        match self.unaliased(type_):
            case PrimitiveType(kind):
                return kind in INTEGER_RANGES or kind in _OTHER_SWITCHES
            case NamedType(name):
                return self.is_enum(name)
        return False

    def of_node(self, node: tree.TypeNode, unit: Unit) -> Type | None:
        """Return the type of a node."""
        if type(node) is tree.BasicType:
            return PRIMITIVES[node.kind]
        if node not in self._types_of_nodes:
            self._depth += 1
            self._types_of_nodes[node] = (
                self._make(node, unit) if self._depth <= MAX_NESTING else None
            )
            self._depth -= 1
        return self._types_of_nodes[node]

    def _make(self, node: tree.TypeNode, unit: Unit) -> Type | None:
        match node:
            case tree.BasicType(kind):
                return PRIMITIVES[kind]
            case tree.ScopedName():
                target = self.tables.references.get(node)
                if isinstance(target, Primitive):
                    return PRIMITIVES[target]
                if target is None or target.poisoned:
                    return None
                if target.kind is Kind.CONST and target.type_node is not None:
                    return self.of_node(target.type_node, target.unit)
                return self.named(target)
            case tree.TextType(wide, bound):
                return self._bounded(bound, unit, lambda size: StringType(wide, size))
            case tree.Sequence(element, bound):
                inner = self._element(element, unit)
                if inner is None:
                    return None
                return self._bounded(
                    bound, unit, lambda size: SequenceType(inner, size)
                )
            case tree.Map(key, value, bound):
                keys, values = self._element(key, unit), self._element(value, unit)
                if keys is None or values is None:
                    return None
                return self._bounded(
                    bound, unit, lambda size: MapType(keys, values, size)
                )
            case tree.Fixed():
                return self._fixed(node, unit)
            case _:
                entity = self.tables.entities.get(node.name)
                return None if entity is None or entity.poisoned else self.named(entity)

    def _element(self, node: tree.TypeNode, unit: Unit) -> Type | None:
        type_ = self.of_node(node, unit)
        if type_ == PRIMITIVES[Primitive.VOID]:
            self._report(
                rules.VOID.at(
                    unit.span(node.start, node.end),
                    "void is not a type for an element",
                    hint="write octet for bytes, any for whatever it is",
                )
            )
            return None
        return type_

    def _bounded(
        self,
        bound: tree.Expression | None,
        unit: Unit,
        make: Callable[[int | None], Type],
    ) -> Type | None:
        if bound is None:
            return make(None)
        size = self.constants.positive(bound, unit)
        return None if size is None else make(size)

    def _fixed(self, node: tree.Fixed, unit: Unit) -> Type | None:
        if node.digits is None or node.scale is None:
            return FixedType(0, 0)
        integer = PRIMITIVES[Primitive.LONG_LONG]
        digits = self.constants.evaluate(node.digits, integer, unit)
        scale = self.constants.evaluate(node.scale, integer, unit)
        if not isinstance(digits, int) or not isinstance(scale, int):
            return None
        if not 1 <= digits <= 31 or not 0 <= scale <= digits:
            self._report(
                rules.BAD_FIXED.at(
                    unit.span(node.start, node.end),
                    f"fixed<{digits},{scale}> is not possible",
                    hint="it has 1 to 31 digits, of which 0 to all are after the point",
                )
            )
            return None
        return FixedType(digits, scale)
