"""Lowers the resolved tree to the model: one declaration for each valid name."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from decimal import Decimal
from typing import Any

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.lowering.common_fields import CommonFields
from rtgen.compiler.frontends.idl.lowering.components import Components
from rtgen.compiler.frontends.idl.meaning import traits
from rtgen.compiler.frontends.idl.meaning.annotations import Annotations, flag
from rtgen.compiler.frontends.idl.meaning.enumerations import Enumerations
from rtgen.compiler.frontends.idl.meaning.operands import fixed_type_of
from rtgen.compiler.frontends.idl.meaning.typetable import PRIMITIVES, Types
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import (
    VOID,
    Attribute,
    Bitfield,
    Bitset,
    Case,
    Component,
    Const,
    ConstantValue,
    Declaration,
    Direction,
    ExceptionDecl,
    FixedType,
    Home,
    Interface,
    Member,
    Native,
    Operation,
    Parameter,
    Primitive,
    ScopedName,
    StateMember,
    Struct,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)


class Lowering:
    """Lowers the declarations of a translation unit; diagnostics go to `report`."""

    def __init__(self, types: Types, report: Callable[[Diagnostic], None]) -> None:
        self._types = types
        self._tables = types.tables
        self._annotations = Annotations(types, report)
        self._fields = CommonFields(self._annotations)
        self._typedefs: dict[ScopedName, Typedef] = {}
        self._components = Components(types, self._fields, self._typedefs, report)
        self._enumerations = Enumerations(types, self._annotations, report)
        self._modules = {
            id(item): self._annotations.of(item.annotations, "module", unit)
            for item, unit in types.tables.modules
        }
        self._makers: dict[Kind, Callable[[Entity, Any], Declaration | None]] = {
            Kind.STRUCT: self._struct,
            Kind.EXCEPTION: self._exception,
            Kind.UNION: self._union,
            Kind.ENUM: self._enum,
            Kind.BITMASK: self._enum,
            Kind.BITSET: self._bitset,
            Kind.TYPEDEF: self._typedef,
            Kind.CONST: self._const,
            Kind.NATIVE: self._native,
            Kind.INTERFACE: self._interface,
            Kind.VALUETYPE: self._valuetype,
            Kind.VALUE_BOX: self._value_box,
            Kind.COMPONENT: self._component,
            Kind.HOME: self._home,
        }

    def declaration(self, entity: Entity) -> Declaration | None:
        """Lower an entity; None if it has an error, or is only forward-declared."""
        if entity.poisoned:
            return None
        if entity.node is None:
            return self._undefined(entity)
        lowered = self._makers[entity.kind](entity, entity.node)
        if lowered is None:
            entity.poisoned = True
        return lowered

    def keep(self, entity: Entity, lowered: Declaration) -> None:
        """Take what an entity was lowered to in another translation unit."""
        if isinstance(lowered, Typedef):
            self._typedefs[lowered.name] = lowered
        elif isinstance(lowered, Component):
            self._components.keep(entity, lowered)

    def _undefined(self, entity: Entity) -> Declaration | None:
        """Return an interface without a definition, which can still be referenced."""
        if entity.kind is Kind.INTERFACE:
            return Interface(
                **self._fields.common(entity),
                abstract=entity.modifier == "abstract",
                local=entity.modifier == "local",
                forward=True,
            )
        if entity.kind is Kind.VALUETYPE:
            return Valuetype(
                **self._fields.common(entity),
                abstract=entity.modifier == "abstract",
                forward=True,
            )
        return None

    def _with_defaults(
        self, entity: Entity, *, derived: bool = False
    ) -> dict[str, Any]:
        """Return a declaration's fields, with the annotations that its modules define for it."""
        common = self._fields.common(entity)
        if entity.around:
            modules = [self._modules[id(item)] for item in entity.around]
            common["annotations"] = traits.with_defaults(
                common["annotations"], modules, derived
            )
        return common

    # Structs and similar

    def _members(
        self, body: tree.Body, unit: Unit, hashed: bool = False
    ) -> tuple[Member, ...] | None:
        members: list[Member] = []
        whole = True
        for item in body.items:
            if isinstance(item.node, tree.Member):
                doc = self._fields.doc(item, unit)
                for declarator in item.node.declarators:
                    member = self._member(declarator, item, doc, unit, hashed)
                    if member is None:
                        whole = False
                    else:
                        members.append(member)
        return tuple(members) if whole else None

    def _member(
        self,
        declarator: tree.Declarator,
        item: tree.Item,
        doc: str,
        unit: Unit,
        hashed: bool = False,
    ) -> Member | None:
        entity = self._tables.entities[declarator.name]
        type_ = self._types.of_entity(entity)
        if type_ is None or entity.poisoned:
            return None
        commented = "@" in doc and self._fields.comment_says_key(item, unit)
        if not item.annotations and not hashed and not commented:
            return Member(span=entity.span, doc=doc, name=entity.name, type=type_)
        attached = self._annotations.of(item.annotations, "member", unit, type_)
        return Member(
            span=entity.span,
            doc=doc,
            annotations=attached,
            name=entity.name,
            type=type_,
            optional=flag(attached, "optional"),
            key=flag(attached, "key") or commented,
            id=traits.member_id(entity.name, attached, hashed),
            must_understand=flag(attached, "must_understand"),
            external=flag(attached, "external"),
            initial=self._annotations.initial(item.annotations, attached, type_, unit),
        )

    def _struct(self, entity: Entity, node: tree.Struct) -> Declaration | None:
        common = self._with_defaults(entity, derived=node.base is not None)
        annotations = common["annotations"]
        hashed = traits.hashes_ids(annotations)
        members = self._members(node.body, entity.unit, hashed)
        base = self._target(node.base)
        if members is None or (node.base is not None and base is None):
            return None
        of_type = traits.of_type(annotations)
        return Struct(**common, **of_type, members=members, base=base)

    def _exception(self, entity: Entity, node: tree.Struct) -> Declaration | None:
        members = self._members(node.body, entity.unit)
        return (
            None
            if members is None
            else ExceptionDecl(**self._fields.common(entity), members=members)
        )

    def _target(self, name: tree.ScopedName | None) -> ScopedName | None:
        target = self._tables.references.get(name) if name is not None else None
        return (
            target.path if isinstance(target, Entity) and not target.poisoned else None
        )

    def _targets(self, names: Iterable[tree.ScopedName]) -> tuple[ScopedName, ...]:
        return tuple(
            target for target in map(self._target, names) if target is not None
        )

    def _union(self, entity: Entity, node: tree.Union) -> Declaration | None:
        switch = self._types.of_node(node.switch, entity.unit)
        if switch is None or not self._types.can_switch(switch):
            return None
        common = self._with_defaults(entity)
        hashed = traits.hashes_ids(common["annotations"])
        cases = []
        whole = True
        for item in node.body.items:
            if isinstance(item.node, tree.Case):
                case = self._case(item, item.node, switch, entity.unit, hashed)
                whole = whole and case is not None
                if case is not None:
                    cases.append(case)
        if not whole:
            return None
        of_type = traits.of_type(common["annotations"])
        return Union(**common, **of_type, switch=switch, cases=tuple(cases))

    def _case(
        self,
        item: tree.Item,
        node: tree.Case,
        switch: Type,
        unit: Unit,
        hashed: bool,
    ) -> Case | None:
        labels: list[ConstantValue] = []
        whole = True
        for label in node.labels:
            if label.value is not None:
                value = self._types.constants.evaluate(
                    label.value, switch, unit, "switch"
                )
                whole = whole and value is not None
                if value is not None:
                    labels.append(value)
        entity = self._tables.entities[node.declarator.name]
        type_ = self._types.of_entity(entity)
        if type_ is None or entity.poisoned or not whole:
            return None
        attached = self._annotations.of(item.annotations, "case", unit, type_)
        return Case(
            span=entity.span,
            doc=self._fields.doc(item, unit),
            annotations=attached,
            labels=tuple(labels),
            default=any(label.value is None for label in node.labels),
            name=entity.name,
            type=type_,
            id=traits.member_id(entity.name, attached, hashed),
            external=flag(attached, "external"),
            initial=self._annotations.initial(item.annotations, attached, type_, unit),
        )

    def _enum(self, entity: Entity, node: tree.Enum) -> Declaration | None:
        return self._enumerations.declaration(
            node,
            entity,
            self._fields.common(entity),
            lambda member: self._fields.doc(member, entity.unit),
        )

    def _bitset(self, entity: Entity, node: tree.Bitset) -> Declaration | None:
        base = self._target(node.base)
        if node.base is not None and base is None:
            return None
        members: list[Bitfield] = []
        for item in node.body.items:
            if isinstance(item.node, tree.Bitfield):
                fields = self._bitfields(item, item.node, entity.unit)
                if fields is None:
                    return None
                members += fields
        return Bitset(**self._fields.common(entity), members=tuple(members), base=base)

    def _bitfields(
        self, item: tree.Item, node: tree.Bitfield, unit: Unit
    ) -> list[Bitfield] | None:
        bits = self._types.constants.positive(node.bits, unit)
        type_ = None if node.type is None else self._types.of_node(node.type, unit)
        if bits is None or (type_ is None and node.type is not None):
            return None
        of = (
            type_
            or PRIMITIVES[
                Primitive.BOOLEAN if bits == 1 else Primitive.UNSIGNED_LONG_LONG
            ]
        )
        attached = self._annotations.of(item.annotations, "bitfield", unit, of)
        common: dict[str, Any] = {
            "doc": self._fields.doc(item, unit),
            "annotations": attached,
            "bits": bits,
            "type": type_,
            "initial": self._annotations.initial(item.annotations, attached, of, unit),
        }
        if not node.names:
            return [Bitfield(span=unit.span(node.start, item.end), name=None, **common)]
        return [
            Bitfield(span=unit.span(name.start, name.end), name=name.text, **common)
            for name in node.names
        ]

    def _typedef(self, entity: Entity, node: object) -> Declaration | None:
        type_ = self._types.of_entity(entity)
        if type_ is None:
            return None
        common = self._fields.common(entity, type_)
        nodes = entity.item.annotations if entity.item else ()
        attached = common["annotations"]
        initial = self._annotations.initial(nodes, attached, type_, entity.unit)
        typedef = Typedef(**common, type=type_, initial=initial)
        self._typedefs[typedef.name] = typedef
        return typedef

    def _const(self, entity: Entity, node: tree.Const) -> Declaration | None:
        type_ = self._types.of_node(node.type, entity.unit)
        value = self._types.constants.value_of(entity)
        if type_ is None or value is None:
            return None
        if isinstance(type_, FixedType) and isinstance(value, Decimal):
            type_ = fixed_type_of(value)
        return Const(**self._fields.common(entity, type_), type=type_, value=value)

    def _native(self, entity: Entity, node: tree.Native) -> Declaration:
        return Native(**self._fields.common(entity))

    # Interfaces and similar

    def _interface(self, entity: Entity, node: tree.Interface) -> Declaration | None:
        return Interface(
            **self._fields.common(entity),
            bases=self._targets(node.bases),
            abstract=node.modifier == "abstract",
            local=node.modifier == "local",
            attributes=self._attributes(node.body, entity.unit),
            operations=self._operations(node.body, entity.unit, factories=False),
        )

    def _attributes(self, body: tree.Body, unit: Unit) -> tuple[Attribute, ...]:
        attributes: list[Attribute] = []
        for item in body.items:
            node = item.node
            if not isinstance(node, tree.Attribute):
                continue
            type_ = self._types.of_node(node.type, unit)
            for name in node.names if type_ is not None else ():
                entity = self._tables.entities[name]
                assert type_ is not None
                attributes.append(
                    Attribute(
                        span=entity.span,
                        doc=self._fields.doc(item, unit),
                        annotations=self._annotations.of(
                            item.annotations, "attribute", unit, type_
                        ),
                        name=name.text,
                        type=type_,
                        readonly=node.readonly,
                        get_raises=self._raised(node.get_raises),
                        set_raises=self._raised(node.set_raises),
                        repository_id=entity.repository_id,
                    )
                )
        return tuple(attributes)

    def _raised(self, clause: tree.Names | None) -> tuple[ScopedName, ...]:
        return tuple(dict.fromkeys(self._targets(clause.names))) if clause else ()

    def _operations(
        self, body: tree.Body, unit: Unit, *, factories: bool
    ) -> tuple[Operation, ...]:
        operations = []
        for item in body.items:
            node = item.node
            if isinstance(node, tree.Operation) and bool(node.factory) == factories:
                operation = self._operation(item, node, unit)
                if operation is not None:
                    operations.append(operation)
        return tuple(operations)

    def _operation(
        self, item: tree.Item, node: tree.Operation, unit: Unit
    ) -> Operation | None:
        entity = self._tables.entities[node.name]
        returns = VOID if node.type is None else self._types.of_node(node.type, unit)
        parameters = tuple(self._parameter(p, unit) for p in node.parameters)
        lowered = tuple(p for p in parameters if p is not None)
        if returns is None or len(lowered) < len(parameters):
            return None
        return Operation(
            span=entity.span,
            doc=self._fields.doc(item, unit),
            annotations=self._annotations.of(
                item.annotations, "operation", unit, returns
            ),
            name=node.name.text,
            returns=returns,
            parameters=lowered,
            raises=self._raised(node.raises),
            oneway=node.oneway,
            context=tuple(
                "".join(p[1:-1] for p in text.parts) for text in node.context
            ),
            repository_id=entity.repository_id,
        )

    def _parameter(self, node: tree.Parameter, unit: Unit) -> Parameter | None:
        entity = self._tables.entities[node.declarator.name]
        type_ = self._types.of_entity(entity)
        if type_ is None or entity.poisoned:
            return None
        return Parameter(
            span=entity.span,
            doc=self._fields.doc(node, unit),
            annotations=self._annotations.of(
                node.annotations, "parameter", unit, type_
            ),
            direction=node.direction or Direction.IN,
            name=node.declarator.name.text,
            type=type_,
        )

    def _valuetype(self, entity: Entity, node: tree.Valuetype) -> Declaration | None:
        state: list[StateMember] = []
        for item in node.body.items:
            if isinstance(item.node, tree.State):
                for declarator in item.node.member.declarators:
                    member = self._member(
                        declarator,
                        item,
                        self._fields.doc(item, entity.unit),
                        entity.unit,
                    )
                    if member is None:
                        return None
                    state.append(
                        StateMember(
                            span=member.span,
                            doc=member.doc,
                            annotations=member.annotations,
                            name=member.name,
                            type=member.type,
                            optional=member.optional,
                            key=member.key,
                            id=member.id,
                            must_understand=member.must_understand,
                            external=member.external,
                            initial=member.initial,
                            public=item.node.public,
                        )
                    )
        return Valuetype(
            **self._fields.common(entity),
            bases=self._targets(node.bases),
            supports=self._targets(node.supports),
            abstract=node.modifier == "abstract",
            custom=node.modifier == "custom",
            truncatable=node.truncatable,
            eventtype=node.keyword == "eventtype",
            attributes=self._attributes(node.body, entity.unit),
            operations=self._operations(node.body, entity.unit, factories=False),
            state=tuple(state),
            factories=self._operations(node.body, entity.unit, factories=True),
        )

    def _value_box(self, entity: Entity, node: tree.ValueBox) -> Declaration | None:
        type_ = self._types.of_node(node.type, entity.unit)
        return (
            None
            if type_ is None
            else ValueBox(**self._fields.common(entity), type=type_)
        )

    def _component(self, entity: Entity, node: tree.Component) -> Declaration | None:
        return self._components.declaration(entity, node, self._annotations)

    def _home(self, entity: Entity, node: tree.Home) -> Declaration | None:
        return Home(**self._fields.common(entity), manages=self._target(node.manages))
