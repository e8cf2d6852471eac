"""Context of the checks: types, declarations and the sink of diagnostics."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule
from rtgen.compiler.frontends.idl.meaning.typetable import Types
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.rules import interfaces as interface_rules
from rtgen.compiler.frontends.idl.rules import types as rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import (
    ArrayType,
    Declaration,
    FixedType,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    Type,
)


class Context(msgspec.Struct, frozen=True):
    """The types and declarations of a translation unit, and the sink of diagnostics.

    `local` has the declarations of which it is known whether they contain a local interface.
    """

    types: Types
    made: Mapping[ScopedName, Declaration]
    report: Callable[[Diagnostic], None]
    local: dict[ScopedName, bool] = {}

    def report_at(
        self,
        rule: Rule,
        unit: Unit,
        node: tree.TypeNode | tree.Expression | tree.Name | tree.Names | tree.Label,
        message: str,
        *,
        related: Iterable[Related] = (),
        hint: str | None = None,
    ) -> None:
        """Report a diagnostic at a node."""
        span = unit.span(node.start, node.end)
        self.report(rule.at(span, message, related=related, hint=hint))

    def report_base(
        self, rule: Rule, entity: Entity, name: tree.ScopedName, message: str, hint: str
    ) -> None:
        """Report the name of a base, or of a supported interface."""
        base = self.target(name)
        related = [] if base is None else [Related(base.span, "declared here")]
        self.report_at(rule, entity.unit, name, message, related=related, hint=hint)

    def report_repeated_base(
        self,
        entity: Entity,
        base: Entity,
        name: tree.ScopedName,
        first: tree.ScopedName,
    ) -> None:
        """Report a name of a base that is also named by `first`."""
        place = entity.unit.span(first.start, first.end)
        self.report_at(
            interface_rules.DUPLICATE_BASE,
            entity.unit,
            name,
            f"{base.name} is named twice",
            related=[Related(place, "the first time")],
            hint="remove one",
        )

    def target(self, name: tree.ScopedName) -> Entity | None:
        """Return the declaration of a name, None if it is not a declaration."""
        entity = self.types.tables.references.get(name)
        return entity if isinstance(entity, Entity) else None

    def is_data(self, node: tree.TypeNode, unit: Unit) -> bool:
        """Check the type of a stored or transmitted value; return whether it is valid."""
        if isinstance(node, tree.BasicType) and node.kind is not Primitive.VOID:
            return True
        type_ = self.types.of_node(node, unit)
        if type_ is None:
            return False
        match self.types.unaliased(type_):
            case PrimitiveType(Primitive.VOID):
                message = "void is a return type only"
                hint = "write the type of the data, or any for whatever it is"
                self.report_at(rules.VOID, unit, node, message, hint=hint)
                return False
            case FixedType(digits=0):
                self.report_at(
                    rules.BAD_FIXED,
                    unit,
                    node,
                    "fixed needs digits and scale here",
                    hint="write fixed<DIGITS,SCALE>, such as fixed<8,2>",
                )
                return False
        return self.maps_are_good(type_, node, unit)

    def maps_are_good(self, type_: Type, node: tree.TypeNode, unit: Unit) -> bool:
        """Check the keys of maps in a type."""
        while isinstance(type_, SequenceType | ArrayType):
            type_ = type_.element
        if not isinstance(type_, MapType):
            return True
        key = self.types.unaliased(type_.key)
        floats = (
            Primitive.FLOAT,
            Primitive.DOUBLE,
            Primitive.LONG_DOUBLE,
            Primitive.ANY,
            Primitive.TYPE_CODE,
        )
        bad = (
            isinstance(key, SequenceType | ArrayType | MapType | FixedType)
            or (isinstance(key, PrimitiveType) and key.kind in floats)
            or (isinstance(key, NamedType) and not self.types.is_enum(key.name))
        )
        if bad:
            self.report_at(
                rules.BAD_MAP_KEY,
                unit,
                node,
                f"{type_.key} cannot be the key of a map",
                hint="keys are integers, characters, booleans, enums or strings",
            )
        return not bad and self.maps_are_good(type_.value, node, unit)

    def is_local(self, type_: Type | None) -> bool:
        """Return whether a type is, or contains, a local interface."""
        if isinstance(type_, PrimitiveType):
            return False
        if isinstance(type_, NamedType) and type_.name in self.local:
            return self.local[type_.name]
        holders: dict[ScopedName, ScopedName | None] = {}
        pending: list[tuple[Type | None, ScopedName | None]] = [(type_, None)]
        while pending:
            part, holder = pending.pop()
            match self.types.unaliased(part):
                case SequenceType(element) | ArrayType(element):
                    pending.append((element, holder))
                case MapType(key, value):
                    pending += [(key, holder), (value, holder)]
                case NamedType(name) if name not in holders:
                    holders[name] = holder
                    if name not in self.local:
                        pending += [(each, name) for each in self._members(name)]
                    if self.local.get(name) or self._is_local_interface(name):
                        self.local[name] = True
                        while (outer := holders[name]) is not None:
                            self.local[name := outer] = True
                        return True
        self.local.update(dict.fromkeys(holders, False))
        return False

    def _is_local_interface(self, name: ScopedName) -> bool:
        entity = self.types.entity(name)
        return (
            entity is not None
            and entity.kind is Kind.INTERFACE
            and entity.modifier == "local"
        )

    def _members(self, name: ScopedName) -> list[Type | None]:
        """Return the types of the members of a struct, union or exception."""
        entity = self.types.entity(name)
        holds = (Kind.STRUCT, Kind.UNION, Kind.EXCEPTION)
        if entity is None or entity.kind not in holds or entity.inner is None:
            return []
        return [
            self.types.of_entity(member)
            for member in entity.inner.names.values()
            if member.kind is Kind.MEMBER and member.type_node is not None
        ]
