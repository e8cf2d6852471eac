"""Pass over cells: reads celltypes, adds bodies, prototypes, and joins without targets yet."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    DECLARE,
    Cell,
    CellAllocator,
    Celltype,
    Composite,
    Join,
    Member,
    Place,
    Plugin,
    Port,
    Report,
    Target,
    Values,
    Variable,
    component,
    here,
)
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.cdl.passes import specifiers
from rtgen.compiler.frontends.cdl.passes.cell_specifiers import CellSpecifiers
from rtgen.compiler.frontends.cdl.passes.regions import Regions
from rtgen.compiler.frontends.cdl.rules import cells as rules
from rtgen.compiler.frontends.cdl.rules import celltypes as celltype_rules
from rtgen.compiler.frontends.cdl.rules import regions as region_rules
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.model.tecs import Signature

_TYPES = (Kind.CELLTYPE, Kind.COMPOSITE)

Export: TypeAlias = Callable[[Cell, tree.Name, tree.Name, str, Place], Member | None]
"""Function that records an export of an inner cell and returns the composite's member of that name.

Its arguments are the cell, its member, the outer name, the kind of port (or `attribute`), and the
place.
"""


class Cells:
    """Declares cells in source order."""

    def __init__(self, values: Values, regions: Regions, report: Report) -> None:
        self._values = values
        self._regions = regions
        self._report = report
        self._specifiers = CellSpecifiers(values, regions, self.add, report)
        self._singletons: dict[tuple[Celltype, Scope], Cell] = {}
        self.all: list[Cell] = []
        """The defined cells, without inner cells of composites."""
        self.declared: list[Cell] = []
        """All declared cells, without inner cells of composites."""
        self.export: Export

    def finish(self) -> None:
        """Check specifiers of cells that refer to later declarations."""
        self._specifiers.finish()

    def check(self) -> None:
        """Report specifiers of joins in front of cells, once the joins are resolved."""
        self._specifiers.check(self.all)

    def declare(
        self,
        item: statements.Item,
        node: statements.Cell,
        place: Place,
        inside: Composite | None = None,
    ) -> None:
        """Declare a cell, or its prototype."""
        type_, guessed = self._celltype(node, place, inside)
        cell, fresh = self._cell(node, place, inside, type_, guessed)
        words = specifiers.CELL if inside is None else specifiers.INNER_CELL
        if inside is None:
            words = (*words, *specifiers.JOIN)  # reported by `check`
        given = specifiers.accepted(
            item.specifiers, words, f"the cell {node.name.text}", place, self._report
        )
        prototype = any(s.word == "prototype" for s in given)
        if node.joins is not None and not prototype:
            self._define(cell, node, place)
        self._specifiers.take(cell, given, place)
        for part in node.joins or ():
            self._part(cell, part, place, prototype)
        if node.joins is None or prototype or not fresh or inside is not None:
            return
        self.all.append(cell)
        self._count(cell)

    def _celltype(
        self, node: statements.Cell, place: Place, inside: Composite | None
    ) -> tuple[Celltype | None, bool]:
        """Return the celltype of a cell, and whether a plug-in may have declared it."""
        found = place.lookup(node.celltype)
        if found is not None and found.kind in _TYPES:
            known = component(found)
            if inside is not None and found is inside.entity:
                self._report(
                    rules.UNKNOWN_CELLTYPE.at(
                        place.span(node.celltype),
                        f"{inside.name} cannot have a cell of itself",
                        related=[Related(inside.entity.place, "declared here")],
                    )
                )
            return (known if isinstance(known, Celltype) else None), False
        span = place.span(node.celltype)
        if found is not None:
            self._report(
                rules.NOT_A_CELLTYPE.at(
                    span,
                    f"{node.celltype} is a {found.kind}, no celltype",
                    related=here(found),
                )
            )
        elif self._values.incomplete:
            return None, True
        elif maker := self._regions.applied.of_types:
            message = f"{node.celltype} is not declared here; {maker} may do it"
            hint = place.near(node.celltype.parts[-1], *_TYPES)
            self._report(rules.MADE_BY_PLUGIN.at(span, message, hint=hint))
            return None, True
        elif not place.may_be_declared(node.celltype):
            self._report(
                rules.UNKNOWN_CELLTYPE.at(
                    span,
                    f"there is no celltype {node.celltype}",
                    hint=place.near(node.celltype.parts[-1], *_TYPES) or DECLARE,
                )
            )
        return None, False

    def _cell(
        self,
        node: statements.Cell,
        place: Place,
        inside: Composite | None,
        type_: Celltype | None,
        guessed: bool,
    ) -> tuple[Cell, bool]:
        """Return the cell of that name, created if missing; False if another entity has the
        name.
        """
        name, scope = node.name.text, place.scope
        span = place.span(node.name)
        around = scope.name if inside is None else inside.entity.name
        entity = Entity(Kind.CELL, (*around, name), place.unit, None, span)
        cell = Cell(entity, type_, node.celltype, place, scope, inside, guessed=guessed)
        entity.component = cell
        if isinstance(type_, Composite):
            self._own_allocators(cell, type_)
        if inside is not None:
            known = inside.inner.get(name)
            before: Entity | Scope | None = known.entity if known is not None else None
        else:
            before = scope.own(name)
        if before is None:
            if inside is not None:
                inside.inner[name] = cell
            else:
                scope.entities[name] = entity
                self.declared.append(cell)
            if (
                inside is None
                and scope.kind is not Kind.REGION
                and scope.parent is not None
            ):
                self._report(
                    rules.CELL_IN_NAMESPACE.at(
                        span,
                        f"the cell {name} is in the name space {scope.name[-1]}",
                        hint="put it at the top or into a region",
                    )
                )
            return cell, True
        earlier = component(before)
        if isinstance(earlier, Cell) and earlier.celltype is type_:
            return earlier, True
        if isinstance(earlier, Cell) and (earlier.celltype is None or type_ is None):
            return cell, False
        what = f"a {before.kind}"
        if isinstance(earlier, Cell):
            what = f"a cell of {earlier.celltype_name}"
        self._report(
            rules.CELL_MISMATCH.at(
                span,
                f"{name} was declared as {what} before",
                related=here(before, "first declared here"),
                hint="rename one",
            )
        )
        return cell, False

    def _own_allocators(self, cell: Cell, type_: Composite) -> None:
        """Give a cell of the composite the allocators of its inner cells."""
        span = cell.entity.place
        for port in type_.ports:
            for (function, parameter), allocator in port.allocators.items():
                if allocator.entry:
                    name = f"{port.name}_{function}_{parameter}"
                    target = Target(cell, allocator.entry, None, span, span, cell.place)
                    join = Join(name, None, span, cell.place, target=target)
                    made = CellAllocator(port.name, None, function, parameter, join)
                    cell.allocators.append(made)

    def _define(self, cell: Cell, node: statements.Cell, place: Place) -> None:
        span = place.span(node.name)
        if cell.defined:
            assert cell.span is not None
            self._report(
                rules.CELL_TWICE.at(
                    span,
                    f"the cell {cell.name} is defined twice",
                    related=[Related(cell.span, "first defined here")],
                    hint="rename one",
                )
            )
            cell.joins.clear()
            cell.order.clear()
            cell.exported.clear()
            if cell in self.all:
                self.all.remove(cell)
        cell.defined = True
        cell.span, cell.place = span, place

    def _count(self, cell: Cell) -> None:
        """Report a second cell of a singleton in a link unit."""
        if cell.celltype is None:
            return
        cell.celltype.cells.append(cell)
        unit = self._regions.link_unit(cell.region)
        for type_ in cell.celltype.real():
            if not type_.singleton:
                continue
            first = self._singletons.setdefault((type_, unit), cell)
            if first is not cell:
                assert cell.span is not None
                assert first.span is not None
                self._report(
                    rules.SECOND_SINGLETON.at(
                        cell.span,
                        f"{cell.name} is a second cell of the singleton {type_.name}",
                        related=[Related(first.span, "the first one")],
                        hint="join to the first one",
                    )
                )

    # Joins

    def _part(
        self, cell: Cell, item: statements.Item, place: Place, prototype: bool
    ) -> None:
        part = item.node
        words = specifiers.JOIN if isinstance(part, statements.Join) else ()
        given = specifiers.accepted(item.specifiers, words, "this", place, self._report)
        match part:
            case statements.Join():
                self._join(cell, part, given, place)
            case statements.ReverseJoin():
                self._reverse(cell, part, place, prototype)
            case statements.Export():
                self._call_export(cell, part, place)

    def _join(
        self,
        cell: Cell,
        node: statements.Join,
        given: list[tree.Specifier],
        place: Place,
    ) -> None:
        name, value = node.name.text, node.value
        member = cell.celltype.members.get(name) if cell.celltype is not None else None
        cell.assigned.add(name)
        throughs = [self._through(s, place) for s in given]
        if throughs and isinstance(member, Variable):
            self._report(
                region_rules.THROUGH_ATTRIBUTE.at(
                    place.unit.span(given[0].start, given[-1].end),
                    f"{name} is an attribute: through precedes joins of call ports",
                    hint="remove it",
                )
            )
        if isinstance(value, tree.OfComposite) and not isinstance(
            member, Variable | None
        ):
            if cell.inside is not None:
                cell.inside.reported.add(value.name.text)
            self._outside(
                place,
                value,
                f"the call port {name} is exported by {name} => composite.{name}",
            )
            return
        if isinstance(value, tree.OfComposite) and cell.inside is None:
            self._outside(place, value, "this cell is not in a composite")
            return
        join = Join(
            name=name,
            index=self._specifiers.index(node.subscript, place),
            span=place.span(node.name),
            place=place,
            value=value,
            plugins=tuple(throughs),
        )
        if cell.inside is not None and isinstance(member, Variable):
            taken, replaced = self._inner_value(cell, node, place)
            if not taken:
                return
            join.value = replaced
        elif isinstance(value, tree.OfComposite):
            return
        self.add(cell, join)

    def _outside(self, place: Place, node: tree.OfComposite, message: str) -> None:
        self._report(celltype_rules.OUTSIDE_COMPOSITE.at(place.span(node), message))

    def _through(self, specifier: tree.Specifier, place: Place) -> Plugin:
        name, argument = specifier.arguments
        assert isinstance(name, tree.Name)
        assert isinstance(argument, tree.Text)
        self._regions.apply(name, place, on_way=True)
        return Plugin(name, argument, place)

    def _inner_value(
        self, cell: Cell, node: statements.Join, place: Place
    ) -> tuple[bool, tree.Initialiser | None]:
        """Return whether an inner cell's attribute has a value in the composite, and the value."""
        assert cell.inside is not None
        assert cell.celltype is not None
        value = node.value
        match value:
            case tree.OfComposite():
                name = value.name
            case tree.ScopedName(parts=(name,), absolute=False) if isinstance(
                cell.inside.members.get(name.text), Variable
            ):
                if name.text in cell.celltype.members:
                    self._ambiguous(cell, name, place)
            case tree.ScopedName() | tree.Aggregate() | tree.CExp() | tree.Text():
                return True, value
            case _:
                if self._values.constant(value, place) is None:
                    cell.inside.reported.update(cell.inside.members)
                    self._report(
                        celltype_rules.INNER_EXPRESSION.at(
                            place.span(value),
                            f"the value of {node.name.text} is not a constant",
                            hint="inside a composite, only composite.name is allowed",
                        )
                    )
                    return False, None
                return True, value
        outer = self.export(cell, node.name, name, "attribute", place)
        if isinstance(outer, Variable) and outer.value is not None:
            return True, outer.value
        return False, None

    def _ambiguous(self, cell: Cell, name: tree.Name, place: Place) -> None:
        assert cell.celltype is not None
        assert cell.inside is not None
        self._report(
            celltype_rules.INNER_NAME.at(
                place.span(name),
                f"{name.text} is a name of {cell.celltype.name}, too",
                hint=f"write composite.{name.text} for the one of {cell.inside.name}",
            )
        )

    def _call_export(self, cell: Cell, node: statements.Export, place: Place) -> None:
        if cell.inside is None:
            message = "this cell is not in a composite: nothing can be exported"
            self._report(celltype_rules.OUTSIDE_COMPOSITE.at(place.span(node), message))
            return
        if cell.celltype is None:
            return
        plain = "composite" not in place.unit.source.code[node.start : node.name.start]
        if plain and node.name.text in cell.celltype.members:
            self._ambiguous(cell, node.name, place)
        cell.assigned.add(node.port.text)
        self.export(cell, node.port, node.name, "call", place)

    def _reverse(
        self, cell: Cell, node: statements.ReverseJoin, place: Place, prototype: bool
    ) -> None:
        type_ = cell.celltype
        port = type_.members.get(node.name.text) if type_ is not None else None
        signature = port.signature if isinstance(port, Port) else None
        back = isinstance(signature, Signature) and signature.callback
        if not prototype and not back and type_ is not None:
            self._report(
                rules.REVERSE_JOIN.at(
                    place.span(node),
                    f"{cell.name} is not a prototype, and the signature is not callback",
                    hint=f"write the join in {node.target.owner}: "
                    f"{node.target.port.text} = {cell.name}.{node.name.text}",
                )
            )
            caller = component(place.lookup(node.target.owner))
            if isinstance(caller, Cell):
                caller.assigned.add(node.target.port.text)
            return
        cell.reversed.append((node, place))

    def turn(self, cell: Cell) -> None:
        """Turn the reverse joins of a cell into joins of the calling cells."""
        for node, place in cell.reversed:
            caller = self._caller(cell, node, place)
            if caller is None:
                continue
            target = Target(
                cell=cell,
                port=node.name.text,
                index=self._specifiers.index(node.subscript, place),
                span=place.span(node.name),
                port_span=place.span(node.name),
                place=place,
            )
            self.add(
                caller,
                Join(
                    name=node.target.port.text,
                    index=self._specifiers.index(node.target.subscript, place),
                    span=place.span(node.target.port),
                    place=place,
                    target=target,
                ),
            )
        cell.reversed.clear()

    def _caller(
        self, cell: Cell, node: statements.ReverseJoin, place: Place
    ) -> Cell | None:
        owner = node.target.owner
        if cell.inside is not None:
            found: object = cell.inside.inner.get(owner.parts[-1].text)
        else:
            found = component(place.lookup(owner))
        if isinstance(found, Cell):
            return found
        if found is None and (place.may_be_declared(owner) or self._values.incomplete):
            return None
        self._report(
            rules.UNKNOWN_CELL.at(
                place.span(owner),
                f"there is no cell {owner}",
                hint=place.near(owner.parts[-1], Kind.CELL),
            )
        )
        return None

    def add(self, cell: Cell, join: Join) -> bool:
        """Add a join to a cell; a second one for the same port or index is reported and dropped."""
        joins = cell.joins.setdefault(join.name, [])
        problem = None
        if joins:
            first = joins[0]
            if first.index is None or join.index is None:
                problem = f"{join.name} is set twice"
            elif (first.index < 0) != (join.index < 0):
                problem = f"{join.name} has a number in one place and none in another"
            elif join.index >= 0:
                first = next((j for j in joins if j.index == join.index), first)
                if first.index == join.index:
                    problem = f"{join.name}[{join.index}] is joined twice"
            if problem is not None:
                cell.clashing.add(join.name)
                self._report(
                    rules.JOINED_TWICE.at(
                        join.span,
                        problem,
                        related=[Related(first.span, "the first time")],
                        hint="remove one",
                    )
                )
                return False
        joins.append(join)
        cell.order.append(join)
        return True
