"""Pass over composites: reads celltypes, adds inner cells (by `cells`) and exports."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Related, Span
from rtgen.compiler.frontends.cdl.names.entities import (
    Cell,
    Composite,
    Exported,
    Member,
    Place,
    Port,
    Report,
    Variable,
)
from rtgen.compiler.frontends.cdl.passes import allocators, specifiers
from rtgen.compiler.frontends.cdl.passes.cells import Cells
from rtgen.compiler.frontends.cdl.passes.celltypes import Celltypes
from rtgen.compiler.frontends.cdl.passes.joins import Joins
from rtgen.compiler.frontends.cdl.passes.open_ends import OpenEnds
from rtgen.compiler.frontends.cdl.rules import celltypes as rules
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.kit.limits import MAX_LEVELS


class Composites:
    """Analyses the bodies of composites, and checks each at its end."""

    def __init__(
        self,
        celltypes: Celltypes,
        cells: Cells,
        joins: Joins,
        open_ends: OpenEnds,
        report: Report,
    ) -> None:
        self._celltypes = celltypes
        self._cells = cells
        self._joins = joins
        self._open_ends = open_ends
        self._report = report
        cells.export = self.export

    def fill(self, composite: Composite, node: statements.Composite) -> None:
        """Analyse the body of a composite."""
        place = composite.place
        for item in node.items:
            match item.node:
                case statements.Port() as written:
                    self._celltypes.port(composite, item, written)
                case statements.Attributes() as attributes:
                    bracket = item.specifiers
                    specifiers.accepted(bracket, (), "attr { }", place, self._report)
                    self._celltypes.variables(composite, attributes)
                case statements.Cell() as cell:
                    self._cells.declare(item, cell, place, composite)
                case statements.EntryExport() as export:
                    bracket = item.specifiers
                    specifiers.accepted(bracket, (), "this", place, self._report)
                    self._entry(composite, export)
        self._celltypes.sizes(composite)
        self._check_kind(composite)
        for port in composite.ports:
            allocators.resolve(composite, port, self._report)
        self._relay(composite)
        inner = list(composite.inner.values())
        for inner_cell in inner:
            self._cells.turn(inner_cell)
        for inner_cell in inner:
            self._joins.resolve(inner_cell)
        for inner_cell in inner:
            self._open_ends.check(inner_cell)
        composite.close()
        if composite.levels == MAX_LEVELS + 1:
            message = f"composites are nested for more than {MAX_LEVELS} levels"
            self._report(syntax.TOO_DEEP.at(composite.entity.place, message))
        self._check_exports(composite)
        self._check_allocators(composite)

    def _entry(self, composite: Composite, node: statements.EntryExport) -> None:
        cell = composite.inner.get(node.cell.text)
        if cell is None:
            composite.reported.add(node.name.text)
            near = nearest(node.cell.text, composite.inner)
            self._report(
                rules.UNKNOWN_INNER_CELL.at(
                    composite.place.span(node.cell),
                    f"{composite.name} has no inner cell {node.cell.text}",
                    hint=f"did you mean {near}?" if near else None,
                )
            )
            return
        self.export(cell, node.port, node.name, "entry", composite.place)

    def export(
        self, cell: Cell, member: tree.Name, name: tree.Name, kind: str, place: Place
    ) -> Member | None:
        """Record an export of an inner cell under its outer name."""
        return self._export(
            cell, member.text, name.text, kind, (place.span(member), place.span(name))
        )

    def _export(
        self, cell: Cell, member: str, name: str, kind: str, spans: tuple[Span, Span]
    ) -> Member | None:
        composite, type_ = cell.inside, cell.celltype
        assert composite is not None
        composite.reported.add(name)
        cell.assigned.add(member)
        if type_ is None:
            cell.exported[member] = Exported(name, cell, member, spans[1])
            composite.exports.append(cell.exported[member])
            return None
        inner = type_.members.get(member)
        if inner is None:
            near = nearest(member, type_.members)
            self._report(
                rules.UNKNOWN_INNER_NAME.at(
                    spans[0],
                    f"{type_.name} has no port or attribute {member}",
                    related=[Related(type_.entity.place, "declared here")],
                    hint=f"did you mean {near}?" if near else None,
                )
            )
            return None
        if not self._kind_fits(inner, name, kind, spans):
            return None
        outer = composite.members.get(name)
        if outer is None:
            near = nearest(name, composite.members)
            self._report(
                rules.NOT_DECLARED.at(
                    spans[1],
                    f"{composite.name} declares no {name}",
                    hint=(
                        f"did you mean {near}?"
                        if near
                        else "declare it in the composite"
                    ),
                )
            )
        else:
            self._fits(inner, outer, spans)
        exported = Exported(name, cell, member, spans[1])
        if isinstance(inner, Port) and inner.kind == "entry":
            first = composite.export(name)
            if first is not None:
                self._report(
                    rules.NAME_TWICE.at(
                        spans[1],
                        f"{name} is exported twice",
                        related=[Related(first.span, "the first time")],
                        hint="remove one",
                    )
                )
        composite.exports.append(exported)
        cell.exported[member] = exported
        if isinstance(outer, Port):
            self._export_hidden(cell, member, outer, spans)
        return outer

    def _kind_fits(
        self, inner: Member, name: str, kind: str, spans: tuple[Span, Span]
    ) -> bool:
        found = inner.kind if isinstance(inner, Port) else "attribute"
        if isinstance(inner, Variable) and inner.kind == "var":
            message, hint = f"{inner.name} is a variable, and is not exported", None
        elif found != kind:
            message = f"{inner.name} is {_a(found)}; here {_a(kind)} is exported"
            hint = {
                "call": f"write {inner.name} => composite.{name} in the cell",
                "entry": f"write composite.{name} => Cell.{inner.name} outside the cell",
                "attribute": f"write {inner.name} = composite.{name} in the cell",
            }[found]
        else:
            return True
        related = [Related(inner.span, "declared here")]
        self._report(
            rules.EXPORT_KIND.at(spans[0], message, related=related, hint=hint)
        )
        return False

    def _fits(self, inner: Member, outer: Member, spans: tuple[Span, Span]) -> None:
        """Report differences between an inner port or attribute and the outer one."""
        related = [Related(inner.span, "inside"), Related(outer.span, "outside")]
        kinds = [m.kind if isinstance(m, Port) else "attribute" for m in (inner, outer)]
        if kinds[0] != kinds[1]:
            message = f"{inner.name} is {_a(kinds[0])}, {outer.name} {_a(kinds[1])}"
            self._report(rules.EXPORT_KIND.at(spans[1], message, related=related))
            return
        difference = _difference(inner, outer)
        if difference:
            self._report(
                rules.EXPORT_MISMATCH.at(
                    spans[1],
                    f"{inner.name} and {outer.name} have different {difference}",
                    related=related,
                    hint="declare both in the same way",
                )
            )

    def _export_hidden(
        self, cell: Cell, member: str, outer: Port, spans: tuple[Span, Span]
    ) -> None:
        """Export the call ports for the allocators of a port, too."""
        own = {
            (a.path[0].text, a.path[1].text)
            for a in outer.allocations
            if len(a.path) == 2
        }
        for function, parameter, _ in outer.parameters():
            if (function, parameter) not in own:
                inner = f"{member}_{function}_{parameter}"
                name = f"{outer.name}_{function}_{parameter}"
                self._export(cell, inner, name, "call", spans)

    def _relay(self, composite: Composite) -> None:
        """Export the call port of an allocator that an inner cell relays."""
        for exported in list(composite.exports):
            outer = composite.members.get(exported.name)
            if not isinstance(outer, Port) or outer.kind != "entry":
                continue
            for (function, parameter), allocator in outer.allocators.items():
                if allocator.call:
                    self._export(
                        exported.cell,
                        f"{exported.member}_{function}_{parameter}",
                        f"{outer.name}_{function}_{parameter}",
                        "call",
                        (exported.span, exported.span),
                    )

    # Checks at the end

    def _check_kind(self, composite: Composite) -> None:
        inner = [c for c in composite.inner.values() if c.celltype is not None]
        span = composite.entity.place
        single = next((c for c in inner if c.celltype and c.celltype.singleton), None)
        active = next((c for c in inner if c.celltype and c.celltype.active), None)
        if single is not None and not composite.singleton:
            self._report(
                rules.COMPOSITE_SINGLETON.at(
                    span,
                    f"{composite.name} is not a singleton, but its cell {single.name} is",
                    related=[Related(single.entity.place, "the cell")],
                    hint="put [singleton] before the composite",
                )
            )
        elif single is None and composite.singleton:
            message = f"{composite.name} is a singleton, but none of its cells is"
            self._report(rules.NO_SINGLETON_INSIDE.at(span, message))
        if active is not None and not composite.active:
            self._report(
                rules.COMPOSITE_ACTIVE.at(
                    span,
                    f"{composite.name} is not active, but its cell {active.name} is",
                    related=[Related(active.entity.place, "the cell")],
                    hint="put [active] before the composite",
                )
            )
        elif active is None and composite.active and len(inner) == len(composite.inner):
            message = f"{composite.name} is active, but none of its cells is"
            hint = "remove active"
            self._report(rules.COMPOSITE_ACTIVE.at(span, message, hint=hint))

    def _check_exports(self, composite: Composite) -> None:
        for exported in composite.exports:
            joins = exported.cell.joins.get(exported.member)
            inner = exported.cell.celltype
            member = inner.members.get(exported.member) if inner is not None else None
            if joins and isinstance(member, Port):
                self._report(
                    rules.JOINED_AND_EXPORTED.at(
                        joins[0].span,
                        f"{exported.member} is joined inside and exported",
                        related=[Related(exported.span, "exported here")],
                        hint="remove one",
                    )
                )
        names = {exported.name for exported in composite.exports}
        broken = any(cell.celltype is None for cell in composite.inner.values())
        for member in composite.members.values():
            if member.name in names | composite.reported or broken:
                continue
            hidden = member.hidden if isinstance(member, Port) else None
            if hidden is not None and hidden.port.name not in names:
                continue
            kind = member.kind if isinstance(member, Port) else "attribute"
            hint = {
                "call": f"write cName => composite.{member.name} in an inner cell",
                "entry": f"write composite.{member.name} => Cell.eName",
                "attribute": f"write name = composite.{member.name} in an inner cell",
            }[kind]
            self._report(
                rules.NOT_EXPORTED.at(
                    member.span,
                    f"{member.name} of {composite.name} is not exported by an inner cell",
                    hint=hint,
                )
            )

    def _check_allocators(self, composite: Composite) -> None:
        """Check that the composite has the allocator that the inner cell uses."""
        for exported in composite.exports:
            outer = composite.members.get(exported.name)
            if not isinstance(outer, Port):
                continue
            for (function, parameter), allocator in outer.allocators.items():
                shown = composite.export(allocator.entry) if allocator.entry else None
                if shown is None:
                    continue
                for given in exported.cell.allocators:
                    if (given.port, given.function, given.parameter) != (
                        exported.member,
                        function,
                        parameter,
                    ):
                        continue
                    if given.join.cell is None or (
                        given.join.cell is shown.cell
                        and given.join.port_name == shown.member
                    ):
                        continue
                    self._report(
                        rules.ALLOCATOR_MISMATCH.at(
                            given.join.span,
                            f"{exported.cell.name} uses another allocator than the composite names",
                            related=[
                                Related(
                                    composite.place.span(allocator.node), "named here"
                                )
                            ],
                        )
                    )


def _difference(inner: Member, outer: Member) -> str:
    if isinstance(inner, Port) and isinstance(outer, Port):
        if inner.signature is None or outer.signature is None:
            return ""
        if inner.signature.name != outer.signature.name:
            return "signatures"
        if (inner.array, inner.size) != (outer.array, outer.size):
            return "sizes"
        if inner.omitted != outer.omitted:
            return "omit"
        words = ("optional", "dynamic", "ref_desc")
        differ = [w for w in words if (w in inner.flags) != (w in outer.flags)]
        return differ[0] if differ else ""
    assert isinstance(inner, Variable)
    assert isinstance(outer, Variable)
    if inner.type is None or outer.type is None or str(inner.type) == str(outer.type):
        return ""
    return f"types ({inner.type} and {outer.type})"


def _a(kind: str) -> str:
    return {"call": "a call port", "entry": "an entry port"}.get(kind, "an attribute")
