"""Checks all cells after `joins`: call ports without joins, attributes without values."""

from __future__ import annotations

import re

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.cdl.names.entities import (
    Cell,
    Composite,
    Join,
    Place,
    Port,
    Report,
    Values,
    Variable,
)
from rtgen.compiler.frontends.cdl.passes import celltypes
from rtgen.compiler.frontends.cdl.passes.regions import Regions
from rtgen.compiler.frontends.cdl.rules import cells as rules
from rtgen.compiler.frontends.cdl.rules import celltypes as celltype_rules
from rtgen.compiler.frontends.cdl.rules import regions as region_rules
from rtgen.compiler.frontends.cdl.syntax import tree

_MAX_NAMED = 5
_WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)


class OpenEnds:
    """Checks cells whose joins are resolved."""

    def __init__(self, values: Values, regions: Regions, report: Report) -> None:
        self._values = values
        self._regions = regions
        self._report = report

    def check(self, cell: Cell) -> None:
        """Report call ports without joins and attributes without values."""
        if cell.celltype is None or not cell.defined:
            return
        for port in cell.celltype.ports:
            if port.kind == "call":
                self._check_port(cell, port)
        for variable in cell.celltype.variables:
            self._check_variable(cell, variable)

    def _check_port(self, cell: Cell, port: Port) -> None:
        assert cell.span is not None
        joins = cell.joins.get(port.name, [])
        if not joins:
            free = port.optional or "omit" in port.flags or port.required is not None
            free |= port.name in cell.assigned
            if free or port.name in cell.exported or port.signature is None:
                return
            hidden = port.hidden
            plugin = cell.celltype.joined_by if cell.celltype is not None else None
            if plugin is not None:
                message = (
                    f"{port.name} of {cell.name} is not joined here; {plugin} may do it"
                )
                self._report(rules.MADE_BY_PLUGIN.at(cell.span, message))
                return
            if hidden is None:
                message = f"the call port {port.name} of {cell.name} is not joined"
                hint = f"write {port.name} = Cell.eEntry, or make the port [optional]"
            else:
                message = (
                    f"{hidden.port.name}.{hidden.function}.{hidden.parameter} of "
                    f"{cell.name} has no allocator"
                )
                hint = f"{port.name} was made for it: see allocator( ) of the cell that is called"
            self._report(
                rules.NOT_JOINED.at(
                    cell.span,
                    message,
                    related=[Related(port.span, "the port")],
                    hint=hint,
                )
            )
            return
        if port.array:
            self._check_array(cell, port, joins)
        if cell.inside is None:
            for join in joins:
                self._check_link_unit(cell, join)

    def _check_array(self, cell: Cell, port: Port, joins: list[Join]) -> None:
        numbers = [j.index for j in joins if j.index is not None]
        if not numbers or port.name in cell.clashing:
            return
        taken = set(numbers) if min(numbers) >= 0 else set(range(len(numbers)))
        size = port.size if port.size is not None else max(taken) + 1
        surplus = max(taken) + 1 > size
        # Limited to what is needed to find all unjoined ports that the message names.
        places = range(min(size, len(taken) + _MAX_NAMED + 1))
        holes = [n for n in places if n not in taken]
        if not surplus and (port.optional or not holes):
            return
        if surplus:
            message = f"{port.name} has {size} places, and {max(taken) + 1} joins"
        else:
            which = ", ".join(f"{port.name}[{n}]" for n in holes[:_MAX_NAMED])
            message = f"{which}{' ...' * (len(holes) > _MAX_NAMED)} of {cell.name} is not joined"
        self._report(
            rules.ARRAY_HOLE.at(
                joins[-1].span, message, related=[Related(port.span, "the port")]
            )
        )

    def _check_link_unit(self, cell: Cell, join: Join) -> None:
        if join.cell is None or join.chain:
            return
        here = self._regions.link_unit(cell.region)
        there = self._regions.link_unit(join.cell.region)
        if here is not there:
            self._report(
                region_rules.LINK_UNITS.at(
                    join.span,
                    f"{cell.name} and {join.cell.name} are in different link units",
                    related=[Related(join.cell.entity.place, "the other cell")],
                    hint='put a plug-in between them: [through( RTCPlugin, "" )]',
                )
            )

    def _check_variable(self, cell: Cell, variable: Variable) -> None:
        assert cell.celltype is not None
        assert cell.span is not None
        given = cell.joins.get(variable.name)
        if variable.size_is is not None and not isinstance(cell.celltype, Composite):
            self._check_size(cell, variable, given[0] if given else None)
        if variable.kind == "var" or variable.value is not None or given:
            return
        if variable.name in cell.assigned and variable.name not in cell.exported:
            return
        exported = cell.exported.get(variable.name)
        if exported is None:
            self._report(
                rules.NO_VALUE.at(
                    cell.span,
                    f"the attribute {variable.name} of {cell.name} has no value",
                    related=[Related(variable.span, "the attribute")],
                    hint=f"write {variable.name} = ...",
                )
            )
        elif variable.size_is is not None:
            self._check_sized_export(cell, variable)

    def _check_size(self, cell: Cell, variable: Variable, given: Join | None) -> None:
        assert cell.celltype is not None
        assert variable.size_is is not None
        assert cell.span is not None
        if cell.inside is not None and any(
            name in cell.exported
            for name in self._names(variable.size_is, variable.place)
        ):
            return
        names = celltypes.attribute_values(cell.celltype, cell)
        size = self._values.constant(variable.size_is, variable.place, names)
        if not isinstance(size, int):
            self._report(
                celltype_rules.SIZE_NOT_CONSTANT.at(
                    cell.span,
                    f"the size of {variable.name} of {cell.name} is not known",
                    related=[
                        Related(variable.place.span(variable.size_is), "the size")
                    ],
                )
            )
            return
        place = given.place if given is not None else variable.place
        value = given.value if given is not None else variable.value
        if isinstance(value, tree.Aggregate):
            before = celltypes.declared_size(self._values, cell.celltype, variable)
            is_larger = isinstance(before, int) and before < len(value.items)
            if given is None and is_larger:
                return
            celltypes.check_length(variable, value, size, place, self._report)
        elif given is not None and value is not None:
            self._report(
                celltype_rules.SIZED_INITIALISER.at(
                    place.span(value),
                    f"{variable.name} has size_is and requires a list",
                    related=[Related(variable.span, "declared here")],
                    hint="write { ... }",
                )
            )

    def _names(self, expression: tree.Expression, place: Place) -> list[str]:
        code = place.unit.source.code[expression.start : expression.end]
        return _WORD.findall(code)

    def _check_sized_export(self, cell: Cell, variable: Variable) -> None:
        """Check that the size of an exported attribute is equal inside and outside."""
        assert cell.inside is not None
        assert variable.size_is is not None
        exported = cell.exported[variable.name]
        outer = cell.inside.members.get(exported.name)
        if not isinstance(outer, Variable):
            return
        problem = None
        names = self._names(variable.size_is, variable.place)
        missing = [n for n in names if n not in cell.exported]
        if outer.size_is is None:
            problem = f"{variable.name} has size_is, {outer.name} has not"
        elif missing:
            problem = (
                f"the size of {variable.name} needs {missing[0]}, which is not exported"
            )
        else:
            place = variable.place
            inner = _WORD.sub(
                lambda match: cell.exported[match[0]].name,
                place.unit.source.code[variable.size_is.start : variable.size_is.end],
            )
            written = outer.place.unit.source.code[
                outer.size_is.start : outer.size_is.end
            ]
            if "".join(inner.split()) != "".join(written.split()):
                problem = f"the sizes of {variable.name} and {outer.name} differ"
        if problem is not None:
            self._report(
                celltype_rules.SIZED_EXPORT.at(
                    exported.span,
                    problem,
                    related=[
                        Related(variable.span, "inside"),
                        Related(outer.span, "outside"),
                    ],
                )
            )
