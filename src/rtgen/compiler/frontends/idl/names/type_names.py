"""Name resolution of type declarations: structs, unions, enums, bitsets, typedefs, constants."""

from __future__ import annotations

from abc import abstractmethod

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.idl.names.lookup import called, kind_of
from rtgen.compiler.frontends.idl.names.naming import Naming
from rtgen.compiler.frontends.idl.names.repository import below
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.idl.names.structural_equality import structurally_equal
from rtgen.compiler.frontends.idl.rules import names as rules
from rtgen.compiler.frontends.idl.rules import types as type_rules
from rtgen.compiler.frontends.idl.syntax import tree


class TypeNames(Naming):
    """Declares types and their members; a subclass walks over bodies."""

    @abstractmethod
    def _body(self, entity: Entity, body: tree.Body) -> None:
        """Walk the body of an entity in its scope."""

    def _inner(self, entity: Entity, ids: str) -> Scope:
        scope = Scope(entity, entity.scope, ids, around=entity.around)
        entity.inner = scope
        return scope

    def _struct(self, node: tree.Struct, scope: Scope, item: tree.Item) -> None:
        kind = Kind.EXCEPTION if node.exception else Kind.STRUCT
        self._compound(
            self._new(scope, node.name, kind, node, item=item), node, node.base
        )

    def _compound(
        self,
        entity: Entity,
        node: tree.Struct | tree.Bitset,
        base: tree.ScopedName | None,
    ) -> None:
        inner = self._inner(entity, below(entity.scope.ids, entity.name))
        entity.complete = False
        if base is not None:
            base_entity = self._base(base, entity, (entity.kind,))
            self._inherit(inner, base_entity)
        self._body(entity, node.body)
        entity.complete = True
        self._to_end(entity)

    def _to_end(self, entity: Entity) -> None:
        """Number an in-place declaration before its user in the order of declarations."""
        if self.tables.declared and self.tables.declared[-1] is not entity:
            self.tables.declared.remove(entity)
            self.tables.declared.append(entity)

    @staticmethod
    def _inherit(inner: Scope, base: Entity | None) -> None:
        if base is not None and base.inner is not None:
            inner.bases.append(base.inner)
        else:
            inner.lacking = True

    def _base(
        self, name: tree.ScopedName, entity: Entity, kinds: tuple[Kind, ...]
    ) -> Entity | None:
        """Return the base with this name, through typedefs; else None, with a diagnostic."""
        target = self._find(entity.scope, name)
        while isinstance(target, Entity) and target.kind is Kind.TYPEDEF:
            if target.declarator is None or target.declarator.dimensions:
                break
            match target.type_node:
                case tree.ScopedName():
                    target = self.tables.references.get(target.type_node)
                case tree.Struct() | tree.Bitset():
                    target = self.tables.entities.get(target.type_node.name)
                case _:
                    break
        if target is None or (isinstance(target, Entity) and target.poisoned):
            entity.poisoned = True
            self.tables.references[name] = None
            return None
        if not isinstance(target, Entity) or target.kind not in kinds:
            what = called(target) if isinstance(target, Entity) else str(name)
            self._report(
                type_rules.BAD_BASE.at(
                    self._unit.span(name.start, name.end),
                    f"{what} cannot be a base of {kind_of(entity)}",
                    related=(
                        [Related(target.span, "declared here")]
                        if isinstance(target, Entity)
                        else []
                    ),
                    hint=f"a base of {kind_of(entity)} is {kind_of(entity)}",
                )
            )
            entity.poisoned = True
            self.tables.references[name] = None
            return None
        if not target.complete or target is entity:
            finding = type_rules.INCOMPLETE.at(
                self._unit.span(name.start, name.end),
                f"{target.scoped} is not defined before this place",
                related=[Related(target.span, "only declared here")],
                hint="put its definition before",
            )
            self._too_early.append((target, finding))
            self.tables.references[name] = None
            return None
        self.tables.references[name] = target
        return target

    def _member(self, node: tree.Member, scope: Scope, item: tree.Item) -> None:
        self._type(node.type, scope, external=_is_external(item))
        for declarator in node.declarators:
            self._declarator(declarator, node.type, scope, Kind.MEMBER, item)

    def _declarator(
        self,
        declarator: tree.Declarator,
        type_: tree.TypeNode,
        scope: Scope,
        kind: Kind,
        item: tree.Item | None,
    ) -> Entity:
        for dimension in declarator.dimensions:
            self._value(dimension, scope)
        listed = kind is Kind.TYPEDEF
        entity = self._new(
            scope, declarator.name, kind, declarator, item=item, listed=listed
        )
        entity.type_node = type_
        entity.declarator = declarator
        return entity

    def _union(self, node: tree.Union, scope: Scope, item: tree.Item) -> None:
        entity = self._new(scope, node.name, Kind.UNION, node, item=item)
        self._inner(entity, below(scope.ids, entity.name))
        entity.complete = False
        assert entity.inner is not None
        self._type(node.switch, entity.inner)
        self._body(entity, node.body)
        entity.complete = True
        self._to_end(entity)

    def _case(self, node: tree.Case, scope: Scope, item: tree.Item) -> None:
        for label in node.labels:
            if isinstance(label.value, tree.ScopedName):
                self._label(label.value, scope)
            else:
                self._value(label.value, scope)
        self._type(node.type, scope, external=_is_external(item))
        self._declarator(node.declarator, node.type, scope, Kind.MEMBER, item)

    def _label(self, name: tree.ScopedName, scope: Scope) -> None:
        """Resolve a label; falls back to the scope of the switch's enum (OMG IDL 4.2)."""
        entity = scope.entity
        assert entity is not None
        if len(name.parts) == 1 and isinstance(entity.node, tree.Union):
            enum = self._switch_enum(entity.node.switch)
            if enum is not None:
                enumerator = enum.scope.names.get(self._key(name.parts[0].text))
                if (
                    enumerator is not None
                    and enumerator.owner is enum
                    and enumerator.name == name.parts[0].text
                ):
                    plain = self._lookup.find(scope, name, self._unit, optional=True)
                    self.tables.references[name] = (
                        enumerator if plain is None else plain
                    )
                    return
        self._find(scope, name)

    def _switch_enum(self, node: object) -> Entity | None:
        while True:
            entity: object
            if isinstance(node, tree.Enum):
                return self.tables.entities.get(node.name)
            if not isinstance(node, tree.ScopedName):
                return None
            entity = self.tables.references.get(node)
            if not isinstance(entity, Entity):
                return None
            if entity.kind is Kind.ENUM:
                return entity
            node = entity.type_node

    def _enum(self, node: tree.Enum, scope: Scope, item: tree.Item) -> None:
        kind = Kind.BITMASK if node.mask else Kind.ENUM
        entity = self._new(scope, node.name, kind, node, item=item)
        holder = (
            self._inner(entity, below(scope.ids, entity.name)) if node.mask else scope
        )
        for member in node.members:
            enumerator = self._new(
                holder, member.name, Kind.ENUMERATOR, member, listed=False
            )
            enumerator.owner = entity
            self._annotations(member.annotations, scope)

    def _bitset(self, node: tree.Bitset, scope: Scope, item: tree.Item) -> None:
        self._compound(
            self._new(scope, node.name, Kind.BITSET, node, item=item), node, node.base
        )

    def _bitfield(self, node: tree.Bitfield, scope: Scope, item: tree.Item) -> None:
        self._value(node.bits, scope)
        if node.type is not None:
            self._type(node.type, scope)
        for name in node.names:
            self._new(scope, name, Kind.MEMBER, node, item=item, listed=False)

    def _typedef(self, node: tree.Typedef, scope: Scope, item: tree.Item) -> None:
        self._type(node.type, scope, alias=True)
        target = self._named_element(node.type)
        open_ended = target is not None and self._open_type(target) is not None
        for declarator in node.declarators:
            if self._is_repeated(declarator, node.type, scope):
                continue
            entity = self._declarator(declarator, node.type, scope, Kind.TYPEDEF, item)
            entity.complete = not open_ended

    def _is_repeated(
        self, declarator: tree.Declarator, type_: tree.TypeNode, scope: Scope
    ) -> bool:
        """Return whether another file declares the same name for the same type."""
        name = declarator.name
        entity = scope.names.get(name.text.lower())
        if (
            entity is None
            or entity.kind is not Kind.TYPEDEF
            or entity.unit.source is self._unit.source
            or not structurally_equal(
                (entity.declarator, entity.type_node),
                (declarator, type_),
            )
        ):
            return False
        self.tables.entities[name] = entity
        self._report(
            rules.DECLARED_ALIKE.at(
                self._unit.span(name.start, name.end),
                f"{name.text} is declared just so in another file",
                related=[Related(entity.span, "the first declaration")],
            )
        )
        return True

    def _const(self, node: tree.Const, scope: Scope, item: tree.Item) -> None:
        self._type(node.type, scope)
        self._value(node.value, scope)
        self._new(scope, node.name, Kind.CONST, node, item=item).type_node = node.type

    def _native(self, node: tree.Native, scope: Scope, item: tree.Item) -> None:
        self._new(scope, node.name, Kind.NATIVE, node, item=item)


def _is_external(item: tree.Item) -> bool:
    """Return whether a member may have an incomplete type (DDS-XTypes 1.3, 7.3.1.2.1)."""
    return any(
        a.name == "external" and all(map(_is_true, a.arguments))
        for a in item.annotations
    )


def _is_true(argument: tree.Argument) -> bool:
    return isinstance(argument.value, tree.Boolean) and argument.value.value
