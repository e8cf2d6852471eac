"""Declares names, and resolves names in types and expressions, for `names.Resolver`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.idl.names.annotation_definitions import DEFINITIONS, WORD
from rtgen.compiler.frontends.idl.names.lookup import Lookup, called, kind_of
from rtgen.compiler.frontends.idl.names.repository import repository_id
from rtgen.compiler.frontends.idl.names.scopes import TYPES, Entity, Kind, Scope
from rtgen.compiler.frontends.idl.names.tables import CORBA_TYPES, IDL_4_TYPES, Tables
from rtgen.compiler.frontends.idl.rules import names as rules
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.rules import types as type_rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.compiler.model import Primitive

FORWARDS = {
    "struct": Kind.STRUCT,
    "union": Kind.UNION,
    "interface": Kind.INTERFACE,
    "valuetype": Kind.VALUETYPE,
    "eventtype": Kind.VALUETYPE,
    "component": Kind.COMPONENT,
}
"""Kinds with forward declarations, by keyword."""


class Naming(ABC):
    """Fills the tables of a translation unit; diagnostics go to `report`."""

    def __init__(
        self,
        report: Callable[[Diagnostic], None],
        declares: Callable[[tuple[str, ...], Unit], str | None],
        ignore_case_clashes: bool,
    ) -> None:
        self.tables = Tables(Scope(None, None))
        self._report = report
        self._lookup = Lookup(self.tables.top, report, declares, ignore_case_clashes)
        self._key = self._lookup.key
        self._too_early: list[tuple[Entity, Diagnostic]] = []
        self._unit: Unit

    @abstractmethod
    def _in_place(
        self, node: tree.Struct | tree.Union | tree.Enum | tree.Bitset, scope: Scope
    ) -> None:
        """Resolve a type that is declared in place."""

    def _new(
        self,
        scope: Scope,
        name: tree.Name,
        kind: Kind,
        node: object,
        *,
        item: tree.Item | None = None,
        listed: bool = True,
    ) -> Entity:
        """Declare a name; a clashing declaration is reported, and kept out of the scope."""
        path = (*scope.path, name.text)
        entity = Entity(
            name.text,
            kind,
            scope,
            self._unit,
            name.start,
            name.end,
            path,
            len(self.tables.declared),
            repository_id(scope.ids, name.text),
            node,
        )
        entity.default_id = entity.repository_id
        entity.item = item
        entity.around = scope.around
        existing = self._lookup.declare(
            scope, entity, name.end - name.start > len(name.text)
        )
        if existing is not None:
            merged = self._merge(entity, existing)
            if merged is not None:
                self.tables.entities[name] = merged
                return merged
            entity.poisoned = entity.clashes = True
        elif scope.entity is not None and scope.entity.clashes:
            entity.clashes = True
        self.tables.entities[name] = entity
        if listed:
            self.tables.declared.append(entity)
        return entity

    def _merge(self, entity: Entity, existing: Entity) -> Entity | None:
        """Return the forward declaration that this one completes or repeats; None after a clash."""
        can_be_forward = entity.kind in FORWARDS.values()
        if not can_be_forward or not (existing.node is None or entity.node is None):
            self._lookup.clash(entity, existing)
            return None
        if existing.kind is not entity.kind or existing.name != entity.name:
            if existing.kind in FORWARDS.values() and existing.name == entity.name:
                message = f"{entity.name} is declared as {kind_of(existing)} before"
                self._mismatch(entity, existing, message)
            else:
                self._lookup.clash(entity, existing)
            return None
        if existing.default_id != entity.default_id:
            message = f"{entity.name} is declared with another prefix before"
            self._mismatch(entity, existing, message)
        if entity.node is not None:
            existing.node = entity.node
            existing.unit = entity.unit
            existing.start, existing.end = entity.start, entity.end
            existing.item = entity.item
            existing.around = entity.around
            existing.order = entity.order
            self.tables.declared.remove(existing)
            self.tables.declared.append(existing)
        return existing

    def _mismatch(self, entity: Entity, existing: Entity, message: str) -> None:
        existing.contradicted = True
        self._report(
            rules.FORWARD_MISMATCH.at(
                entity.span,
                message,
                related=[Related(existing.span, "declared here")],
                hint="make the two agree",
            )
        )

    def _find(
        self, scope: Scope, name: tree.ScopedName, *, introduce: bool = True
    ) -> Entity | Primitive | None:
        """Look up a name, and record the result in the table."""
        entity: Entity | Primitive | None
        built_in = _built_in(scope, name)
        if built_in is None or self._lookup.is_declared(scope, name):
            entity = self._lookup.find(scope, name, self._unit, introduce=introduce)
        else:
            entity = built_in
        self.tables.references[name] = entity
        return entity

    def _find_text(self, scope: Scope, text: str, span: Span) -> Entity | None:
        """Look up the scoped name in a pragma."""
        parts = [part.strip() for part in text.split("::")]
        absolute = not parts[0]
        places = [self.tables.top] if absolute else list(scope.outward())
        parts = parts[absolute:]
        names = [part.removeprefix("_") for part in parts]
        entity: Entity | None = None
        for place in places:
            entities = place.find(self._key(names[0]))
            if entities:
                entity = entities[0]
                break
        way = [entity]
        for name in names[1:]:
            inner = entity.inner if entity else None
            entities = inner.find(self._key(name)) if inner else []
            entity = entities[0] if entities else None
            way.append(entity)
        for name, passed in zip(names, way, strict=True):
            if entity is not None and passed is not None and passed.name != name:
                self._lookup.wrong_case(name, passed, span)
        if entity is None and names[-1].lower() not in self._lookup.maybe_declared:
            self._report(
                rules.UNKNOWN_NAME.at(
                    span,
                    f"{text} is not declared before the pragma",
                    hint="put the pragma after the declaration",
                )
            )
        return entity

    def _type(
        self,
        node: tree.TypeNode,
        scope: Scope,
        depth: int = 0,
        *,
        alias: bool = False,
        external: bool = False,
    ) -> None:
        """Resolve the names in a type, and declare types declared in place.

        `depth` counts enclosing sequences and maps; `alias`: the type is in a typedef;
        `external`: it is the whole type of an `@external` member.
        """
        if isinstance(node, tree.BasicType):
            return
        if depth >= MAX_NESTING:
            span = self._unit.span(node.start, node.start + 1)
            self._report(syntax.TOO_DEEP.at(span, "this type is nested too deeply"))
            return
        match node:
            case tree.ScopedName():
                entity = self._find(scope, node)
                if isinstance(entity, Entity):
                    self._check_type(entity, node)
                    if not entity.complete and not external:
                        self._incomplete(entity, node, scope, depth, alias)
            case tree.Sequence():
                self._type(node.element, scope, depth + 1, alias=alias)
                self._value(node.bound, scope)
            case tree.TextType():
                self._value(node.bound, scope)
            case tree.Map():
                self._type(node.key, scope, depth + 1, alias=alias)
                self._type(node.value, scope, depth + 1, alias=alias)
                self._value(node.bound, scope)
            case tree.Fixed():
                self._value(node.digits, scope)
                self._value(node.scale, scope)
            case _:
                self._in_place(node, scope)
                if depth:
                    self._report(
                        type_rules.ANONYMOUS.at(
                            self._unit.span(node.name.start, node.name.end),
                            f"{node.name.text} is declared where an element is expected",
                            hint=f"declare it before, and write {node.name.text} here",
                        )
                    )

    def _incomplete(
        self,
        entity: Entity,
        node: tree.ScopedName,
        scope: Scope,
        depth: int,
        alias: bool,
    ) -> None:
        """Check a use of an incomplete type, or of a type that contains one."""
        incomplete = self._open_type(entity)
        if incomplete is None:
            return
        in_sequence = depth > 0 or incomplete is not entity
        inside = any(place.entity is incomplete for place in scope.outward())
        if in_sequence and (alias or inside):
            if inside and depth > 0 and incomplete is entity:
                self._report(
                    type_rules.RECURSIVE_SEQUENCE.at(
                        self._unit.span(node.start, node.end),
                        f"this sequence is directly inside {incomplete.name}",
                        hint=f"declare '{incomplete.kind} {incomplete.name};' before,"
                        " and a typedef",
                    )
                )
            return
        label = (
            "its definition begins here"
            if incomplete.node is not None
            else "only declared here"
        )
        hint = (
            f"use a sequence: 'struct {incomplete.name};' and"
            f" 'typedef sequence<{incomplete.name}> ...;' before it"
            if inside
            else f"define {incomplete.name} before"
        )
        finding = type_rules.INCOMPLETE.at(
            self._unit.span(node.start, node.end),
            (
                f"{incomplete.scoped} cannot hold itself"
                if inside and incomplete.node is not None
                else f"{incomplete.scoped} is not complete here"
            ),
            related=[Related(incomplete.span, label)],
            hint=hint,
        )
        self._too_early.append((incomplete, finding))
        self.tables.references[node] = None

    def _open_type(self, entity: Entity) -> Entity | None:
        """Return the incomplete struct or union in typedefs and sequences."""
        seen = 0
        while not entity.complete and seen < MAX_NESTING:
            seen += 1
            if entity.kind in (Kind.STRUCT, Kind.UNION, Kind.BITSET):
                return entity
            if entity.kind is not Kind.TYPEDEF:
                return None
            target = self._named_element(entity.type_node)
            if target is None or target.complete:
                entity.complete = True
                return None
            entity = target
        return None

    def _named_element(self, node: object) -> Entity | None:
        """Return the declaration of a type, or of the elements of sequences; None without."""
        while isinstance(node, tree.Sequence):
            node = node.element
        if not isinstance(node, tree.ScopedName):
            return None
        target = self.tables.references.get(node)
        return target if isinstance(target, Entity) else None

    def _check_type(self, entity: Entity, node: tree.ScopedName) -> None:
        if entity.kind in TYPES:
            return
        if entity.kind is Kind.CONST:
            self._report(
                rules.CONSTANT_AS_TYPE.at(
                    self._unit.span(node.start, node.end),
                    f"{called(entity)} is not a type: its own type is taken",
                    related=[Related(entity.span, "declared here")],
                    hint="name the type",
                )
            )
            return
        self.tables.references[node] = None
        if not entity.poisoned:
            what = (
                "can only be raised"
                if entity.kind is Kind.EXCEPTION
                else "is not a type"
            )
            self._report(
                rules.NOT_A_TYPE.at(
                    self._unit.span(node.start, node.end),
                    f"{called(entity)} {what}",
                    related=[Related(entity.span, "declared here")],
                    hint=(
                        "put its contents into a struct"
                        if entity.kind is Kind.EXCEPTION
                        else None
                    ),
                )
            )

    def _value(
        self, node: tree.Expression | None, scope: Scope, *, optional: bool = False
    ) -> None:
        """Resolve the names in an expression; unknown names are ignored if `optional`."""
        pending = [node] if node is not None else []
        while pending:
            part = pending.pop()
            match part:
                case tree.ScopedName() if optional:
                    self.tables.references[part] = self._lookup.find(
                        scope, part, self._unit, optional=True
                    )
                case tree.ScopedName():
                    self._find(scope, part)
                case tree.Unary():
                    pending.append(part.operand)
                case tree.Group():
                    pending.append(part.inner)
                case tree.Chain():
                    pending.append(part.first)
                    pending += (operand for _, operand in part.rest)

    def _annotations(
        self, annotations: Iterable[tree.Annotation], scope: Scope
    ) -> None:
        """Resolve names in arguments; words such as FINAL or `XML | XCDR2` need not be names."""
        for annotation in annotations:
            definition = DEFINITIONS.get(annotation.name)
            for argument in annotation.arguments:
                value = argument.value
                words = definition is None or WORD in definition.arguments.values()
                # A flag or an enumerator in a default is known by the type.
                words |= annotation.name == "default"
                optional = words or isinstance(value, tree.ScopedName)
                self._value(value, scope, optional=optional)


def _built_in(scope: Scope, name: tree.ScopedName) -> Primitive | None:
    """Return the predefined type of an undeclared name."""
    last = name.parts[-1].text
    if last in IDL_4_TYPES:
        return IDL_4_TYPES[last] if len(name.parts) == 1 else None
    if last not in ("Object", "TypeCode"):
        return None
    inside = len(name.parts) == 1 and not name.absolute and scope.path[:1] == ("CORBA",)
    return CORBA_TYPES.get(f"CORBA::{last}" if inside else str(name).removeprefix("::"))
