"""Name resolution (OMG IDL 4.2, 7.5): declares and looks up all names of a translation unit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rtgen.diagnostics import Diagnostic, Related, Span
from rtgen.frontends.idl.names.lookup import MOST_ELSEWHERE, called, kind_of
from rtgen.frontends.idl.names.naming import FORWARDS, Naming
from rtgen.frontends.idl.names.repository import Identities, below
from rtgen.frontends.idl.names.scopes import Entity, Kind, Scope
from rtgen.frontends.idl.names.structural_equality import structurally_equal
from rtgen.frontends.idl.names.tables import MAX_DEPTH, Tables
from rtgen.frontends.idl.rules import annotations as annotation_rules
from rtgen.frontends.idl.rules import lexical, syntax
from rtgen.frontends.idl.rules import names as rules
from rtgen.frontends.idl.rules import types as type_rules
from rtgen.frontends.idl.syntax import tree
from rtgen.frontends.idl.text.source import Source
from rtgen.frontends.idl.text.unit import Boundary, Inclusion, Pragma, Unit


class Resolver(Naming):
    """Walks a unit's tree. `items_of` returns the tree of a unit; diagnostics go to `report`."""

    def __init__(
        self,
        items_of: Callable[[Unit], tuple[tree.Item, ...]],
        report: Callable[[Diagnostic], None],
        declares: Callable[[str, Unit], str | None],
        ignore_case_clashes: bool,
    ) -> None:
        super().__init__(report, declares, ignore_case_clashes)
        self._items_of = items_of
        self._identities = Identities(self._find_text, report)
        self._event = 0
        self._nested_ids: list[tuple[Scope, str]] = []
        self._handlers: dict[type, Callable[[Any, Scope, tree.Item], None]] = {
            tree.Module: self._module,
            tree.Forward: self._forward,
            tree.Struct: self._struct,
            tree.Union: self._union,
            tree.Enum: self._enum,
            tree.Bitset: self._bitset,
            tree.Typedef: self._typedef,
            tree.Const: self._const,
            tree.Native: self._native,
            tree.Interface: self._interface,
            tree.Valuetype: self._valuetype,
            tree.ValueBox: self._value_box,
            tree.Component: self._component,
            tree.Home: self._home,
            tree.Identity: self._identity,
            tree.Import: self._import,
            tree.Unused: self._unused,
            tree.AnnotationDcl: self._annotation_dcl,
            tree.Skipped: self._skipped,
            tree.Member: self._member,
            tree.Case: self._case,
            tree.Bitfield: self._bitfield,
            tree.Operation: self._operation,
            tree.Attribute: self._attribute,
            tree.State: self._state,
            tree.PortItem: self._port,
        }
        self._depth = 0
        self._read: dict[Source, list[str]] = {}
        self._reading: list[Source] = []

    def run(self, unit: Unit) -> Tables:
        """Resolve the translation unit of a main file."""
        self._run_unit(unit)
        self._lookup.report_unknown()
        self._never_defined()
        return self.tables

    def _never_defined(self) -> None:
        """Report missing definitions, for a struct or union together with its uses."""
        uses: dict[Entity, list[Related]] = {}
        for entity, finding in self._too_early:
            if entity.node is None and entity.kind in (Kind.STRUCT, Kind.UNION):
                assert finding.span is not None
                uses.setdefault(entity, []).append(Related(finding.span, "used here"))
            else:
                self._report(finding)
        for entity in self.tables.declared:
            if entity.node is not None or entity.kind is Kind.COMPONENT:
                continue
            if entity.name.lower() in self._lookup.lost or entity.contradicted:
                continue
            hard = entity.kind in (Kind.STRUCT, Kind.UNION)
            rule = rules.NEVER_DEFINED if hard else rules.NEVER_DEFINED_INTERFACE
            finding = rule.at(
                entity.span,
                f"{called(entity)} is declared, but never defined",
                related=uses.get(entity, [])[:MOST_ELSEWHERE],
                hint="define it, or remove the declaration",
            )
            if hard:
                self._report(finding)
            else:
                self.tables.undefined[entity.path] = finding

    def _run_unit(self, unit: Unit) -> None:
        saved = getattr(self, "_unit", unit), self._event, self.tables.top.ids
        self._unit, self._event, self.tables.top.ids = unit, 0, ""
        self._read.setdefault(unit.source, []).append(unit.text)
        self._reading.append(unit.source)
        items = self._items_of(unit)
        self._lookup.doubtful = self._lookup.doubtful or unit.lacking
        self._lookup.lost |= unit.lost
        self._items(items, self.tables.top, len(unit.text) + 1)
        self.tables.units.append(unit)
        self._reading.pop()
        self._unit, self._event, self.tables.top.ids = saved

    def _items(self, items: Iterable[tree.Item], scope: Scope, end: int) -> None:
        events = self._unit.events
        for item in items:
            if self._event < len(events) and events[self._event].offset <= item.start:
                self._events(item.start, scope)
            self._handlers[type(item.node)](item.node, scope, item)
            if item.annotations:
                self._annotations(item.annotations, scope)
        self._events(end, scope)

    def _in_place(
        self, node: tree.Struct | tree.Union | tree.Enum | tree.Bitset, scope: Scope
    ) -> None:
        item = tree.Item((), node, node.start, node.start)
        self._handlers[type(node)](node, scope, item)

    def _events(self, until: int, scope: Scope) -> None:
        """Apply the pragmas and inclusions before an offset."""
        events = self._unit.events
        while self._event < len(events) and events[self._event].offset <= until:
            event = events[self._event]
            self._event += 1
            match event:
                case Pragma():
                    self._identities.apply(event, scope)
                case Inclusion():
                    self._include(event)
                case Boundary(opens=True):
                    self._nested_ids.append((scope, scope.ids))
                    scope.ids = ""
                case Boundary() if self._nested_ids:
                    outer, ids = self._nested_ids.pop()
                    outer.ids = ids

    def _include(self, inclusion: Inclusion) -> None:
        """Resolve an included file; of a file that was already read, only its own inclusions."""
        unit = inclusion.unit
        if unit.text not in self._read.get(unit.source, ()):
            self._run_unit(unit)
            return
        if unit.source in self._reading:  # a circle, which is reported already
            return
        if unit.text.strip():
            message = "the file is included again, and has no include guard"
            self._report(lexical.INCLUDED_AGAIN.at(inclusion.span, message))
        for event in unit.events:
            if isinstance(event, Inclusion):
                self._include(event)

    def _inner(self, entity: Entity, ids: str) -> Scope:
        scope = Scope(entity, entity.scope, ids, around=entity.around)
        entity.inner = scope
        return scope

    def _body(self, entity: Entity, body: tree.Body) -> None:
        """Walk the body of an entity in its scope."""
        assert entity.inner is not None
        self._depth += 1
        if self._depth > MAX_DEPTH:
            message = "declarations are nested too deeply here"
            self._report(syntax.TOO_DEEP.at(entity.span, message))
            entity.poisoned = True
            while (
                self._event < len(self._unit.events)
                and self._unit.events[self._event].offset < body.end
            ):
                self._event += 1
        else:
            self._items(body.items, entity.inner, body.end)
        self._depth -= 1

    # Declarations

    def _module(self, node: tree.Module, scope: Scope, item: tree.Item) -> None:
        if node.template:
            self._unused(
                tree.Unused("template module", node.name, node.start, node.name.end),
                scope,
                item,
            )
            return
        existing = scope.names.get(self._key(node.name.text))
        if (
            existing is not None
            and existing.kind is Kind.MODULE
            and existing.inner is not None
        ):
            entity = existing
            if existing.name != node.name.text:
                span = self._unit.span(node.name.start, node.name.end)
                self._report(
                    rules.WRONG_CASE.at(
                        span,
                        f"the module is called {existing.name}",
                        related=[Related(existing.span, "first opened here")],
                    )
                )
        else:
            entity = self._new(scope, node.name, Kind.MODULE, node, listed=False)
            self._inner(entity, "")
        assert entity.inner is not None
        before = entity.inner.ids, entity.inner.around
        if item.annotations:
            self.tables.modules.append((item, self._unit))
        entity.inner.around = scope.around + ((item,) if item.annotations else ())
        entity.inner.ids = (
            below(scope.ids, entity.name)
            if entity.prefix is None
            else below(entity.prefix, "/".join(entity.path))
        )
        self._body(entity, node.body)
        entity.inner.ids, entity.inner.around = before

    def _forward(self, node: tree.Forward, scope: Scope, item: tree.Item) -> None:
        existing = scope.names.get(self._key(node.name.text))
        before = existing.span if existing else None
        entity = self._new(scope, node.name, FORWARDS[node.keyword], None, item=item)
        if entity is existing and before is not None:
            self._agree(entity, node.modifier, node.name, before)
        else:
            entity.complete = False
            entity.modifier = node.modifier

    def _agree(
        self, entity: Entity, modifier: str, name: tree.Name, other: Span
    ) -> None:
        if entity.modifier != modifier and "custom" not in (entity.modifier, modifier):
            span = self._unit.span(name.start, name.end)
            before = entity.modifier or "neither abstract nor local"
            message = f"{entity.name} is declared as {before} elsewhere"
            self._report(
                rules.FORWARD_MISMATCH.at(
                    span,
                    message,
                    related=[Related(other, "declared here")],
                    hint="make the two agree",
                )
            )

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
            found = self._base(base, entity, (entity.kind,))
            self._inherit(inner, found)
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
        """The base with this name, through typedefs; None, with a diagnostic, if it is no base."""
        found = self._find(entity.scope, name)
        while isinstance(found, Entity) and found.kind is Kind.TYPEDEF:
            if found.declarator is None or found.declarator.dimensions:
                break
            match found.type_node:
                case tree.ScopedName():
                    found = self.tables.references.get(found.type_node)
                case tree.Struct() | tree.Bitset():
                    found = self.tables.entities.get(found.type_node.name)
                case _:
                    break
        if found is None or (isinstance(found, Entity) and found.poisoned):
            entity.poisoned = True
            self.tables.references[name] = None
            return None
        if not isinstance(found, Entity) or found.kind not in kinds:
            what = called(found) if isinstance(found, Entity) else str(name)
            self._report(
                type_rules.BAD_BASE.at(
                    self._unit.span(name.start, name.end),
                    f"{what} cannot be a base of {kind_of(entity)}",
                    related=(
                        [Related(found.span, "declared here")]
                        if isinstance(found, Entity)
                        else []
                    ),
                    hint=f"a base of {kind_of(entity)} is {kind_of(entity)}",
                )
            )
            entity.poisoned = True
            self.tables.references[name] = None
            return None
        if not found.complete or found is entity:
            finding = type_rules.INCOMPLETE.at(
                self._unit.span(name.start, name.end),
                f"{found.scoped} is not defined before this place",
                related=[Related(found.span, "only declared here")],
                hint="put its definition before",
            )
            self._too_early.append((found, finding))
            self.tables.references[name] = None
            return None
        self.tables.references[name] = found
        return found

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
        """Resolve a label; falls back on the scope of the switch's enum (OMG IDL 4.2)."""
        entity = scope.entity
        assert entity is not None
        if len(name.parts) == 1 and isinstance(entity.node, tree.Union):
            enum = self._enum_behind(entity.node.switch)
            if enum is not None:
                found = enum.scope.names.get(self._key(name.parts[0].text))
                if (
                    found is not None
                    and found.owner is enum
                    and found.name == name.parts[0].text
                ):
                    plain = self._lookup.find(scope, name, self._unit, optional=True)
                    self.tables.references[name] = found if plain is None else plain
                    return
        self._find(scope, name)

    def _enum_behind(self, node: object) -> Entity | None:
        while True:
            found: object
            if isinstance(node, tree.Enum):
                return self.tables.entities.get(node.name)
            if not isinstance(node, tree.ScopedName):
                return None
            found = self.tables.references.get(node)
            if not isinstance(found, Entity):
                return None
            if found.kind is Kind.ENUM:
                return found
            node = found.type_node

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
        element = node.type
        while isinstance(element, tree.Sequence):
            element = element.element
        found = (
            self.tables.references.get(element)
            if isinstance(element, tree.ScopedName)
            else None
        )
        open_ended = isinstance(found, Entity) and self._open_type(found) is not None
        for declarator in node.declarators:
            if self._is_repeated(declarator, node.type, scope):
                continue
            entity = self._declarator(declarator, node.type, scope, Kind.TYPEDEF, item)
            entity.complete = not open_ended

    def _is_repeated(
        self, declarator: tree.Declarator, type_: tree.TypeNode, scope: Scope
    ) -> bool:
        """Whether another file declares the same name for the same type."""
        name = declarator.name
        known = scope.names.get(name.text.lower())
        if (
            known is None
            or known.kind is not Kind.TYPEDEF
            or known.unit.source is self._unit.source
            or not structurally_equal(
                (known.declarator, known.type_node),
                (declarator, type_),
            )
        ):
            return False
        self.tables.entities[name] = known
        self._report(
            rules.DECLARED_ALIKE.at(
                self._unit.span(name.start, name.end),
                f"{name.text} is declared just so in another file",
                related=[Related(known.span, "the first declaration")],
            )
        )
        return True

    def _const(self, node: tree.Const, scope: Scope, item: tree.Item) -> None:
        self._type(node.type, scope)
        self._value(node.value, scope)
        self._new(scope, node.name, Kind.CONST, node, item=item).type_node = node.type

    def _native(self, node: tree.Native, scope: Scope, item: tree.Item) -> None:
        self._new(scope, node.name, Kind.NATIVE, node, item=item)

    # Interfaces and similar

    def _bases(
        self, entity: Entity, names: Iterable[tree.ScopedName], kinds: tuple[Kind, ...]
    ) -> None:
        assert entity.inner is not None
        for name in names:
            found = self._base(name, entity, kinds)
            self._inherit(entity.inner, found)

    def _open(
        self, scope: Scope, name: tree.Name, kind: Kind, node: Any, item: tree.Item
    ) -> Entity:
        forward = scope.names.get(self._key(name.text))
        before = forward.span if forward else None
        entity = self._new(scope, name, kind, node, item=item)
        modifier = getattr(node, "modifier", "")
        if entity is forward and before is not None:
            self._agree(entity, modifier, name, before)
        entity.modifier = modifier
        entity.complete = False
        self._inner(entity, below(scope.ids, entity.name))
        return entity

    def _interface(self, node: tree.Interface, scope: Scope, item: tree.Item) -> None:
        entity = self._open(scope, node.name, Kind.INTERFACE, node, item)
        self._bases(entity, node.bases, (Kind.INTERFACE,))
        self._body(entity, node.body)
        entity.complete = True

    def _valuetype(self, node: tree.Valuetype, scope: Scope, item: tree.Item) -> None:
        entity = self._open(scope, node.name, Kind.VALUETYPE, node, item)
        self._bases(entity, node.bases, (Kind.VALUETYPE,))
        self._bases(entity, node.supports, (Kind.INTERFACE,))
        self._body(entity, node.body)
        entity.complete = True

    def _value_box(self, node: tree.ValueBox, scope: Scope, item: tree.Item) -> None:
        self._type(node.type, scope)
        self._new(scope, node.name, Kind.VALUE_BOX, node, item=item).type_node = (
            node.type
        )

    def _component(self, node: tree.Component, scope: Scope, item: tree.Item) -> None:
        entity = self._open(scope, node.name, Kind.COMPONENT, node, item)
        if node.base is not None:
            self._bases(entity, (node.base,), (Kind.COMPONENT,))
        for name in node.supports:
            self._find(scope, name)
        self._body(entity, node.body)
        entity.complete = True

    def _home(self, node: tree.Home, scope: Scope, item: tree.Item) -> None:
        entity = self._open(scope, node.name, Kind.HOME, node, item)
        if node.base is not None:
            self._bases(entity, (node.base,), (Kind.HOME,))
        managed = self._find(scope, node.manages)
        if isinstance(managed, Entity) and managed.kind is not Kind.COMPONENT:
            self._report(
                type_rules.BAD_BASE.at(
                    self._unit.span(node.manages.start, node.manages.end),
                    f"{called(managed)} is no component that a home could manage",
                    related=[Related(managed.span, "declared here")],
                    hint="name a component",
                )
            )
            entity.poisoned = True
        for name in (*node.supports, node.key):
            if name is not None:
                self._find(scope, name)
        self._body(entity, node.body)
        entity.complete = True
        self._report(
            annotation_rules.PASSED_OVER.at(
                entity.span,
                f"the home {entity.name} is read, but nothing is made of it",
                hint="components are made by the factory of their module",
            )
        )

    def _operation(self, node: tree.Operation, scope: Scope, item: tree.Item) -> None:
        if node.type is not None:
            self._type(node.type, scope)
        entity = self._new(
            scope, node.name, Kind.OPERATION, node, item=item, listed=False
        )
        inner = self._inner(entity, "")
        for parameter in node.parameters:
            self._type(parameter.type, inner)
            self._declarator(
                parameter.declarator, parameter.type, inner, Kind.PARAMETER, None
            )
            self._annotations(parameter.annotations, scope)
        for name in node.raises.names if node.raises else ():
            self._find(scope, name, introduce=False)

    def _attribute(self, node: tree.Attribute, scope: Scope, item: tree.Item) -> None:
        self._type(node.type, scope)
        for clause in (node.get_raises, node.set_raises):
            for name in clause.names if clause else ():
                self._find(scope, name, introduce=False)
        for attribute in node.names:
            entity = self._new(
                scope, attribute, Kind.ATTRIBUTE, node, item=item, listed=False
            )
            entity.type_node = node.type

    def _state(self, node: tree.State, scope: Scope, item: tree.Item) -> None:
        self._member(node.member, scope, item)

    def _port(self, node: tree.PortItem, scope: Scope, item: tree.Item) -> None:
        if node.keyword in ("port", "mirrorport") and isinstance(
            node.type, tree.ScopedName
        ):
            self._find(scope, node.type)
        else:
            self._type(node.type, scope)
        entity = Entity(
            *(
                node.name.text,
                Kind.PORT,
                scope,
                self._unit,
                node.name.start,
                node.name.end,
            ),
            path=(*scope.path, node.name.text),
            order=len(self.tables.declared),
            node=node,
        )
        entity.item = item
        self.tables.entities[node.name] = entity

    # Statements

    def _identity(self, node: tree.Identity, scope: Scope, item: tree.Item) -> None:
        found = self._find(scope, node.name)
        text = "".join(part[1:-1] for part in node.text.parts)
        if not isinstance(found, Entity):
            return
        if node.keyword == "typeid":
            span = self._unit.span(node.start, node.text.end)
            self._identities.set_id(found, text, span)
        elif found.inner is None:
            self._report(
                rules.NOT_A_SCOPE.at(
                    self._unit.span(node.name.start, node.name.end),
                    f"{called(found)} has no names inside it",
                    hint="typeprefix names a module or an interface",
                )
            )
        else:
            found.prefix = text
            found.inner.ids = below(text, "/".join(found.path))

    def _import(self, node: tree.Import, scope: Scope, item: tree.Item) -> None:
        if node.name is None:
            self._import_of_text(node)
            return
        found = self._find(scope, node.name)
        if isinstance(found, Entity) and found.inner is not None:
            scope.imported.append(found.inner)

    def _import_of_text(self, node: tree.Import) -> None:
        """Resolve an import of a scope by name or repository id; a file is included."""
        self._lookup.doubtful = True
        begin = self._unit.span(node.start, node.start + len("import"))
        self._report(
            lexical.BAD_INCLUDE.at(
                begin,
                "import of a text: nothing is read",
                hint='write #include "file.idl" for a file, import NAME; for a module',
            )
        )

    def _annotation_dcl(
        self, node: tree.AnnotationDcl, scope: Scope, item: tree.Item
    ) -> None:
        self.tables.annotations[node.name.text] = node.members
        self._read_only("the declaration of an annotation", node.name)

    def _unused(self, node: tree.Unused, scope: Scope, item: tree.Item) -> None:
        if node.name is not None:
            entity = self._new(scope, node.name, Kind.UNUSED, node, listed=False)
            target = self._find(scope, node.target) if node.target else None
            entity.poisoned = node.target is None
            entity.inner = target.inner if isinstance(target, Entity) else None
        self._read_only(node.keyword, node.name)

    def _read_only(self, what: str, name: tree.Name | None) -> None:
        self._report(
            type_rules.READ_ONLY.at(
                self._unit.span(name.start, name.end) if name else None,
                f"{what} is read, but nothing is made of it",
                hint="declarations of modules, types and interfaces are used",
            )
        )

    def _skipped(self, node: tree.Skipped, scope: Scope, item: tree.Item) -> None:
        if item.end > item.start and item.start not in self._unit.excused:
            span = self._unit.span(item.start, item.end)
            self._report(
                syntax.EXTRA_SEMICOLON.at(
                    span, "this ';' ends nothing", hint="remove it"
                )
            )


def _is_external(item: tree.Item) -> bool:
    """Whether a member may have an incomplete type (DDS-XTypes 1.3, 7.3.1.2.1)."""
    return any(
        a.name == "external" and all(map(_is_true, a.arguments))
        for a in item.annotations
    )


def _is_true(argument: tree.Argument) -> bool:
    return isinstance(argument.value, tree.Boolean) and argument.value.value
