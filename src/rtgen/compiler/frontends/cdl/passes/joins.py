"""Pass over all cells at the end: reads joins and exports, adds entry ports and plug-ins."""

from __future__ import annotations

import math

import msgspec

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    Cell,
    CellAllocator,
    Join,
    Port,
    Report,
    Target,
    Values,
    Variable,
    component,
    here,
)
from rtgen.compiler.frontends.cdl.names.scopes import Kind
from rtgen.compiler.frontends.cdl.passes import celltypes
from rtgen.compiler.frontends.cdl.passes.cells import Cells
from rtgen.compiler.frontends.cdl.passes.regions import Regions
from rtgen.compiler.frontends.cdl.rules import cells as rules
from rtgen.compiler.frontends.cdl.rules import celltypes as celltype_rules
from rtgen.compiler.frontends.cdl.rules import regions as region_rules
from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.frontends.kit.suggestions import nearest


class Joins(msgspec.Struct, eq=False):
    """Resolves the joins of cells."""

    _values: Values
    _regions: Regions
    _cells: Cells
    _report: Report

    # Resolution

    def resolve(self, cell: Cell) -> None:
        """Resolve the targets of a cell's joins, and check the values of its attributes."""
        if cell.resolved or not cell.defined:
            return
        cell.resolved = True
        if cell.celltype is None:
            for join in cell.order:
                self._guess(join)
            return
        for join in cell.order:  # the joins of allocators are appended in the loop
            self._define(cell, join)
        self._relay(cell)

    def _guess(self, join: Join) -> None:
        """Determine a best-effort target of a join of a cell of unknown celltype."""
        if join.value is None or isinstance(join.value, tree.OfComposite):
            return
        target = self._target(join)
        if target is not None and isinstance(target.cell, tree.ScopedName):
            found = component(join.place.lookup(target.cell))
            if isinstance(found, Cell):
                join.cell, join.port_name = found, target.port
                join.port_index = target.index
                found.used = True
            else:
                self._expect(join, None, target)

    def _define(self, cell: Cell, join: Join) -> None:
        if join.done:
            return
        join.done = True
        assert cell.celltype is not None
        member = cell.celltype.members.get(join.name)
        if member is None:
            near = nearest(join.name, cell.celltype.members)
            self._report(
                rules.UNKNOWN_NAME.at(
                    join.span,
                    f"{cell.celltype.name} has no port or attribute {join.name}",
                    related=[Related(cell.celltype.entity.place, "declared here")],
                    hint=f"did you mean {near}?" if near else None,
                )
            )
        elif isinstance(member, Variable):
            self._set(join, member)
        elif member.kind == "entry":
            self._report(
                rules.ENTRY_ON_THE_LEFT.at(
                    join.span,
                    f"{join.name} is an entry port, and is not joined to anything",
                    related=[Related(member.span, "declared here")],
                    hint="write the join in the cell that calls",
                )
            )
        else:
            self._resolve_call_port(cell, join, member)

    def _set(self, join: Join, variable: Variable) -> None:
        if variable.kind == "var":
            self._report(
                rules.VARIABLE_IN_CELL.at(
                    join.span,
                    f"{join.name} is a variable: a cell sets attributes only",
                    related=[Related(variable.span, "declared here")],
                )
            )
            return
        value = join.value
        if (
            variable.type is None
            or value is None
            or isinstance(value, tree.OfComposite)
        ):
            return
        if celltypes.is_unsized_list(variable, value):
            self._report(
                celltype_rules.UNSIZED_INITIALISER.at(
                    join.place.span(value),
                    f"{join.name} is a pointer without size_is and cannot have a list",
                    related=[Related(variable.span, "declared here")],
                )
            )
            return
        join.initial = self._values.initial(variable.type, value, join.place, {})
        fits = join.initial is not None
        choice = variable.choice
        if (
            fits
            and choice
            and isinstance(value, tree.Text)
            and value.text not in choice
        ):
            near = nearest(value.text, choice)
            self._report(
                rules.NOT_A_CHOICE.at(
                    join.place.span(value),
                    f'"{value.text}" is none of ' + ", ".join(f'"{c}"' for c in choice),
                    related=[Related(variable.span, "declared here")],
                    hint=f'did you mean "{near}"?' if near else None,
                )
            )

    def _resolve_call_port(self, cell: Cell, join: Join, port: Port) -> None:
        """Resolve the join of a call port."""
        if port.array != (join.index is not None):
            message = (
                f"{join.name} is an array and needs a subscript"
                if port.array
                else f"{join.name} is not an array and has no subscript"
            )
            hint = f"write {join.name}[0] or {join.name}[]" if port.array else None
            related = [Related(port.span, "declared here")]
            self._report(
                rules.LEFT_SUBSCRIPT.at(join.span, message, related=related, hint=hint)
            )
        target = join.target or self._target(join)
        if target is None:
            value = join.value
            assert value is not None
            self._report(
                rules.NOT_A_TARGET.at(
                    join.place.span(value),
                    f"{join.name} is a call port, and this is not an entry port",
                    hint="write Cell.eEntry or Cell.eEntry[0]",
                )
            )
            return
        callee = self._cell(cell, target)
        if callee is None:
            if cell.inside is None:
                self._expect(join, port, target)
            return
        callee.used = True
        if self._resolve_entry_port(join, port, callee, target):
            self._set_plugins(cell, join, port, callee)
            self._allocator_joins(cell, join, callee, target)

    def _expect(self, join: Join, port: Port | None, target: Target) -> None:
        """Keep a join to a cell that a plug-in may generate."""
        name = target.cell
        if (
            isinstance(name, tree.ScopedName)
            and self._regions.applied.of_cells is not None
            and target.place.lookup(name) is None
        ):
            join.made = tuple(part.text for part in name.parts)
            join.port_name, join.port_index = target.port, target.index
            if port is not None:
                join.port, join.chain = port, join.plugins

    def _target(self, join: Join) -> Target | None:
        """Return the target of `Cell.eEntry` or `Cell.eEntry[i]`."""
        value, place = join.value, join.place
        match value:
            case tree.Postfix(
                operand=tree.ScopedName() as owner, suffixes=(tree.Name() as port,)
            ):
                index = None
            case tree.Postfix(
                operand=tree.ScopedName() as owner,
                suffixes=(
                    tree.Name() as port,
                    tree.Subscript(index=subscript),
                ),
            ) if (
                subscript is not None
            ):
                found = self._values.constant(subscript, place)
                index = found if isinstance(found, int) else None
                if index is None or index < 0:
                    message = "a subscript is a constant integer, 0 or more"
                    span = place.span(subscript)
                    self._report(rules.RIGHT_SUBSCRIPT.at(span, message))
                    index = 0
            case _:
                return None
        return Target(
            owner, port.text, index, place.span(owner), place.span(port), place
        )

    def _cell(self, cell: Cell, target: Target) -> Cell | None:
        """Return the target cell of a join; None, after a diagnostic, if invalid."""
        name = target.cell
        if isinstance(name, Cell):
            return name
        inside = cell.inside
        plain = name.parts[-1].text
        if inside is not None:
            member = inside.inner.get(plain) or inside.members.get(plain)
            if isinstance(member, Cell):
                return member
            near = nearest(plain, inside.inner)
            hint = f"did you mean {near}?" if near else None
            found = None
            state = f"is not a cell of {inside.name}" if member else "is not known"
        else:
            found = target.place.lookup(name)
            if found is not None and found.kind is Kind.CELL:
                known = component(found)
                return known if isinstance(known, Cell) else None
            hint = target.place.near(name.parts[-1], Kind.CELL)
            state = f"is a {found.kind}" if found is not None else "is not known"
        unknown = found is None and inside is None
        if unknown and (target.place.may_be_declared(name) or self._values.incomplete):
            return None
        maker = self._regions.applied.of_cells
        if found is None and maker is not None and inside is None:
            message = f"the cell {name} is not declared here; {maker} may make it"
            self._report(rules.MADE_BY_PLUGIN.at(target.span, message, hint=hint))
            return None
        rule = rules.UNKNOWN_CELL if found is None else rules.NOT_A_CELL
        self._report(
            rule.at(
                target.span,
                f"{name} {state}: a join leads to a cell",
                related=here(found) if found else [],
                hint=hint,
            )
        )
        return None

    def _resolve_entry_port(
        self, join: Join, port: Port, callee: Cell, target: Target
    ) -> bool:
        """Resolve and validate the entry port of the target."""
        type_ = callee.celltype
        if type_ is None:
            if callee.guessed:
                join.cell, join.port_name = callee, target.port
                join.port_index = target.index
            return False
        entry = type_.members.get(target.port)
        related = [Related(type_.entity.place, "the celltype")]
        if entry is None or not isinstance(entry, Port) or entry.kind != "entry":
            near = nearest(
                target.port, (p.name for p in type_.ports if p.kind == "entry")
            )
            rule = rules.UNKNOWN_ENTRY if entry is None else rules.NOT_AN_ENTRY
            state = "port" if entry is None else "entry port"
            self._report(
                rule.at(
                    target.port_span,
                    f"{type_.name} has no {state} {target.port}",
                    related=related,
                    hint=f"did you mean {near}?" if near else None,
                )
            )
            return False
        if port.signature is None or entry.signature is None:
            return False
        related = [
            Related(port.span, "the call port"),
            Related(entry.span, "the entry port"),
        ]
        if port.signature.name != entry.signature.name:
            self._report(
                rules.SIGNATURE_MISMATCH.at(
                    target.port_span,
                    f"{port.name} has the signature {port.signature.scoped}, "
                    f"{entry.name} {entry.signature.scoped}",
                    related=related,
                )
            )
            return False
        problem = None
        if entry.array and target.index is None:
            problem = f"{entry.name} is an array and needs a subscript"
        elif not entry.array and target.index is not None:
            problem = f"{entry.name} is not an array"
        elif (target.index or 0) >= (entry.size or math.inf):
            problem = f"{entry.name} has {entry.size} places, from 0 on"
        if problem is not None:
            self._report(
                rules.RIGHT_SUBSCRIPT.at(target.port_span, problem, related=related[1:])
            )
            return False
        join.cell, join.port, join.port_index = callee, entry, target.index
        join.port_name = entry.name
        callee.callers[entry.name] = callee.callers.get(entry.name, 0) + 1
        return True

    def _set_plugins(self, cell: Cell, join: Join, port: Port, callee: Cell) -> None:
        """Set the plug-ins between a call port and its target, in order from the caller."""
        if join.plugins and port.omitted:
            reason = (
                f"the signature of {port.name} has no functions"
                if port.empty
                else f"{port.name} is omit"
            )
            self._report(
                region_rules.THROUGH_IGNORED.at(
                    join.place.span(join.plugins[0].name),
                    f"the plug-in is not used: {reason}",
                )
            )
            return
        what = f"{cell.name}.{join.name}"
        ways = self._regions.way(cell.region, callee.region, what, join.span)
        chain = (*join.plugins, *ways)
        if chain and cell.inside is not None:
            self._report(
                celltype_rules.THROUGH_INSIDE.at(
                    chain[0].place.span(chain[0].name),
                    f"{what} is inside a composite, and has no plug-ins",
                    hint="export the call port, and put through where the composite is used",
                )
            )
            return
        join.chain = chain

    # Allocators

    def _allocator_joins(
        self, cell: Cell, join: Join, callee: Cell, target: Target
    ) -> None:
        """Join the call ports for allocators to the allocators that the callee names.

        A plug-in between regions has its own allocators at the caller's side.
        """
        far = bool(join.chain) and callee.region is not cell.region
        self.resolve(callee)
        for allocator in callee.allocators:
            if (allocator.port, allocator.index) != (target.port, target.index):
                continue
            source = allocator.join
            name = f"{join.name}_{allocator.function}_{allocator.parameter}"
            if far:
                cell.assigned.add(name)
                continue
            made = Join(
                name=name,
                index=join.index,
                span=join.span,
                place=source.place,
                value=source.value,
                target=source.target or self._target(source),
            )
            self._cells.add(cell, made)

    def _relay(self, cell: Cell) -> None:
        """Forward allocators from call ports to entry ports."""
        assert cell.celltype is not None
        assert cell.span is not None
        for port in cell.celltype.ports:
            for (function, parameter), allocator in port.allocators.items():
                if not allocator.call:
                    continue
                if port.array:
                    cell.assigned.add(f"{port.name}_{function}_{parameter}")
                    message = (
                        f"{port.name} is an array: its allocators are not passed on"
                    )
                    related = [Related(port.span, "the port")]
                    self._report(rules.RELAY.at(cell.span, message, related=related))
                    break
                name = f"{allocator.call}_{allocator.function}_{allocator.parameter}"
                joins = cell.joins.get(name)
                if not joins:
                    if name not in cell.exported:
                        cell.assigned |= {name, f"{port.name}_{function}_{parameter}"}
                        self._report(
                            rules.RELAY.at(
                                cell.span,
                                f"{cell.name}.{allocator.call} has no allocator for "
                                f"{allocator.function}.{allocator.parameter} to pass on",
                                related=[Related(port.span, "the port")],
                                hint=f"join {allocator.call} to a cell with an allocator",
                            )
                        )
                    continue
                self._pass_on(cell, port, function, parameter, joins[0])

    def _pass_on(
        self, cell: Cell, port: Port, function: str, parameter: str, source: Join
    ) -> None:
        join = Join(
            name=f"{port.name}_{function}_{parameter}",
            index=None,
            span=source.span,
            place=source.place,
            value=source.value,
            target=source.target or self._target(source),
        )
        cell.allocators.append(
            CellAllocator(port.name, None, function, parameter, join)
        )
        if port.name not in cell.exported and self._cells.add(cell, join):
            self._define(cell, join)
