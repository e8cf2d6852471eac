"""Pass over cells at the end: reads required and fixed ports, adds implicit joins."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Related, Span
from rtgen.compiler.frontends.cdl.names.entities import (
    Cell,
    Celltype,
    Composite,
    Join,
    Port,
    Target,
    component,
)
from rtgen.compiler.frontends.cdl.passes.joins import Joins
from rtgen.compiler.frontends.cdl.rules import cells as rules
from rtgen.compiler.frontends.cdl.rules import celltypes as celltype_rules


class ImplicitJoins(Joins):
    """Adds joins for required ports and fixed joins to cells."""

    def require(self, type_: Celltype) -> None:
        """Join the required ports of the cells of a celltype."""
        for port in type_.ports:
            if port.required is None:
                continue
            for cell in type_.cells:
                self._require(cell, port)

    def _require(self, cell: Cell, port: Port) -> None:
        assert port.required is not None
        assert cell.span is not None
        found = port.required.component
        target: Cell | None = None
        if isinstance(found, Celltype):
            target = self.nearest(found, cell)
        elif isinstance(found, Cell):
            target = found
            if self._regions.distance(cell.region, found.region) is None:
                target = None
        if target is None:
            self._report(
                rules.NOT_REACHED.at(
                    cell.span,
                    f"{cell.name} requires {port.required.name[-1]}.{port.required_port}, "
                    "and no cell of it is reached from here",
                    related=[Related(port.span, "required here")],
                    hint=f"define a cell of {port.required.name[-1]}",
                )
            )
            return
        if port.name in cell.joins:
            first = cell.joins[port.name][0]
            self._report(
                rules.REQUIRE_OVERRIDDEN.at(
                    first.span,
                    f"{port.name} is required, and joined to another cell here",
                    related=[Related(port.span, "required here")],
                )
            )
            return
        self._join_to(cell, port.name, None, target, port.required_port, cell.span)

    def _join_to(
        self,
        cell: Cell,
        name: str,
        index: int | None,
        target: Cell,
        port: str,
        span: Span,
    ) -> Join:
        join = Join(
            name=name,
            index=index,
            span=span,
            place=cell.place,
            target=Target(target, port, None, span, span, cell.place),
        )
        self._cells.add(cell, join)
        return join

    def nearest(self, type_: Celltype, cell: Cell) -> Cell | None:
        """Return the nearest reachable cell of a singleton celltype."""
        best, least = None, -1
        for other in type_.cells:
            distance = self._regions.distance(cell.region, other.region)
            if distance is not None and (best is None or distance < least):
                best, least = other, distance
        return best

    def fixed(self, cell: Cell) -> None:
        """Add the fixed joins of a cell to the calling cells.

        A fixed join to a port that an inner cell does not export has no target with an outer name:
        it only counts as a join of the caller's port.
        """
        for port, entry in cell.celltype.fixed() if cell.celltype is not None else ():
            caller = self._fixed_caller(cell, port)
            if caller is not None:
                assert port.fixed is not None
                assert cell.span is not None
                name = port.fixed.port.text
                join = self._join_to(caller, name, -1, cell, entry, cell.span)
                self._define(caller, join)
        if isinstance(cell.celltype, Composite):
            for port in cell.celltype.kept():
                caller = self._fixed_caller(cell, port)
                if caller is not None:
                    assert port.fixed is not None
                    caller.assigned.add(port.fixed.port.text)

    def _fixed_caller(self, cell: Cell, port: Port) -> Cell | None:
        assert port.fixed is not None
        assert port.fixed_place is not None
        found = component(port.fixed_place.lookup(port.fixed.owner))
        caller = self.nearest(found, cell) if isinstance(found, Celltype) else found
        if isinstance(caller, Cell):
            return caller
        if isinstance(found, Celltype):
            assert cell.span is not None
            self._report(
                celltype_rules.BAD_FIXED_JOIN.at(
                    cell.span,
                    f"{cell.name} has a fixed join to {found.name}, which has no cell here",
                    related=[Related(port.span, "the fixed join")],
                    hint=f"define a cell of {found.name}",
                )
            )
        return None
