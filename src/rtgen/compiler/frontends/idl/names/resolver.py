"""Name resolution (OMG IDL 4.2, 7.5): declares and looks up all names of a translation unit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.idl.names.lookup import MAX_ELSEWHERE, called
from rtgen.compiler.frontends.idl.names.naming import FORWARDS
from rtgen.compiler.frontends.idl.names.repository import Identities, below
from rtgen.compiler.frontends.idl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.names.type_names import TypeNames
from rtgen.compiler.frontends.idl.rules import annotations as annotation_rules
from rtgen.compiler.frontends.idl.rules import lexical, syntax
from rtgen.compiler.frontends.idl.rules import names as rules
from rtgen.compiler.frontends.idl.rules import types as type_rules
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.source import Source
from rtgen.compiler.frontends.idl.text.unit import (
    Boundary,
    Inclusion,
    Pragma,
    Repeated,
    Unit,
)
from rtgen.compiler.kit.limits import MAX_NESTING


class Resolver(TypeNames):
    """Walks a unit's tree. `items_of` returns the tree of a unit; diagnostics go to `report`."""

    def __init__(
        self,
        items_of: Callable[[Unit], tuple[tree.Item, ...]],
        report: Callable[[Diagnostic], None],
        declares: Callable[[tuple[str, ...], Unit], str | None],
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
        self._leads = True
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
            if (
                entity.name.lower() in self._lookup.maybe_declared
                or entity.contradicted
            ):
                continue
            hard = entity.kind in (Kind.STRUCT, Kind.UNION)
            rule = rules.NEVER_DEFINED if hard else rules.NEVER_DEFINED_INTERFACE
            finding = rule.at(
                entity.span,
                f"{called(entity)} is declared, but never defined",
                related=uses.get(entity, [])[:MAX_ELSEWHERE],
                hint="define it, or remove the declaration",
            )
            if hard:
                self._report(finding)
            else:
                self.tables.undefined[entity.path] = finding

    def _run_unit(self, unit: Unit) -> None:
        saved = getattr(self, "_unit", unit), self._event, self.tables.top.ids
        leads = self._leads
        self._unit, self._event, self.tables.top.ids = unit, 0, ""
        self.tables.mark(unit)
        self._read.setdefault(unit.source, []).append(unit.text)
        self._reading.append(unit.source)
        items = self._items_of(unit)
        self._lookup.doubtful = self._lookup.doubtful or unit.lacking
        self._lookup.maybe_declared |= unit.maybe_declared
        self._items(items, self.tables.top, len(unit.text) + 1)
        self.tables.units.append(unit)
        self._leads = leads
        if leads:
            declared = self.tables.declared
            last = declared[-1] if declared else None
            self.tables.leading.append((unit, len(declared), last))
        self._reading.pop()
        self._unit, self._event, self.tables.top.ids = saved
        self.tables.mark(self._unit)

    def _items(self, items: Iterable[tree.Item], scope: Scope, end: int) -> None:
        events = self._unit.events
        for item in items:
            if self._event < len(events) and events[self._event].offset <= item.start:
                self._events(item.start, scope)
            self._leads = False
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
                    self._leads = False
                    self._identities.apply(event, scope)
                case Inclusion():
                    self._include(event)
                case Repeated():
                    self.tables.units.append(event)
                case Boundary(opens=True):
                    self._nested_ids.append((scope, scope.ids))
                    scope.ids = ""
                case Boundary() if self._nested_ids:
                    outer, ids = self._nested_ids.pop()
                    outer.ids = ids

    def _include(self, inclusion: Inclusion) -> None:
        """Resolve an included file; if it was already read, only its own inclusions."""
        unit = inclusion.unit
        if unit.text not in self._read.get(unit.source, ()):
            self._run_unit(unit)
            return
        if unit.source in self._reading:  # a cycle, already reported
            return
        if unit.text.strip():
            message = "the file is included again, and has no include guard"
            self._report(lexical.INCLUDED_AGAIN.at(inclusion.span, message))
        for event in unit.events:
            if isinstance(event, Inclusion):
                self._include(event)

    def _body(self, entity: Entity, body: tree.Body) -> None:
        """Walk the body of an entity in its scope."""
        assert entity.inner is not None
        self._depth += 1
        if self._depth > MAX_NESTING:
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
        self.tables.openings[node.name] = node.body
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

    # Interfaces and similar

    def _bases(
        self, entity: Entity, names: Iterable[tree.ScopedName], kinds: tuple[Kind, ...]
    ) -> None:
        assert entity.inner is not None
        for name in names:
            base = self._base(name, entity, kinds)
            self._inherit(entity.inner, base)

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
                    f"{called(managed)} is not a component that a home could manage",
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
                f"the home {entity.name} is read, but rtgen generates nothing for it",
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
        entity = self._find(scope, node.name)
        text = "".join(part[1:-1] for part in node.text.parts)
        if not isinstance(entity, Entity):
            return
        if node.keyword == "typeid":
            span = self._unit.span(node.start, node.text.end)
            self._identities.set_id(entity, text, span)
        elif entity.inner is None:
            self._report(
                rules.NOT_A_SCOPE.at(
                    self._unit.span(node.name.start, node.name.end),
                    f"{called(entity)} has no names inside it",
                    hint="typeprefix names a module or an interface",
                )
            )
        else:
            entity.prefix = text
            entity.inner.ids = below(text, "/".join(entity.path))

    def _import(self, node: tree.Import, scope: Scope, item: tree.Item) -> None:
        if node.name is None:
            self._import_of_text(node)
            return
        entity = self._find(scope, node.name)
        if isinstance(entity, Entity) and entity.inner is not None:
            scope.imported.append(entity.inner)

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
                f"{what} is read, but rtgen generates nothing for it",
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
